// SPDX-License-Identifier: Apache-2.0
// test_viewer.mjs - exported pages in a browser: node test_viewer.mjs CHROMIUM SHEEN FOLDER SESSION...
// The sessions are fitted ones, by one method each; pages and screenshots are left in FOLDER. All must look as sheen
// renders them; the first one's page is tried out.
import axe from "axe-core";
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { cpSync, mkdirSync, readFileSync, renameSync, rmSync, utimesSync, writeFileSync } from "node:fs";
import { request } from "node:http";
import { basename, join } from "node:path";
import { deflateRawSync, inflateRawSync } from "node:zlib";
import { PNG } from "pngjs";
import { openBrowser, openPage, picture, psnr, settled } from "./browser.mjs";

const [, , chromium, sheen, folder, ...sessions] = process.argv;
const size = { width: 960, height: 720 };
const leastDb = 40;
const looks = ["30,25", "120,10", "205,42", "290,60", "345,-20", "75,85"];
mkdirSync(folder, { recursive: true });

const run = (...args) => execFileSync(sheen, args, { encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
const exported = (session, name, ...options) => {
    const file = join(folder, name);
    return { session, file, facts: JSON.parse(run("export", session, "-o", file, "--json", "--max-loss", "20", ...options)) };
};
const rendered = (session, look, ...options) => {
    const file = join(folder, `sheen-${basename(session)}-${look}${options.at(-1) ?? ""}.png`);
    // The refined method fills what no photograph saw, and the page shows it; the paper's leaves it black.
    const { method } = JSON.parse(readFileSync(join(session, "model/model.json"), "utf8"));
    const holes = method === "refined" ? "fill" : "black";
    run("render", session, `--view=${look}`, "--size", `${size.width}x${size.height}`, "--holes", holes, "-o", file, ...options);
    return PNG.sync.read(readFileSync(file));
};

// Pixels that are not all background; with `inside`, that no background touches.
function objectIn(image, inside = false) {
    const empty = (i) => [0, 1, 2].every((c) => image.data[4 * i + c] === image.data[c]);
    const w = image.width;
    return (i) => !empty(i) && (!inside || [i - 1, i + 1, i - w, i + w, i - w - 1, i - w + 1, i + w - 1, i + w + 1].every((k) => !empty(k)));
}

const browser = await openBrowser(chromium);
const pages = sessions.map((session, i) => exported(session, `page${i}.html`, "--title", `<a> & "b" 'c'`));
const small = pages[0];
let failed = 0;

async function test(name, body) {
    const began = Date.now();
    try {
        await body();
        console.log(`ok   ${name} (${Date.now() - began} ms)`);
    } catch (error) {
        failed++;
        console.log(`FAIL ${name}\n${error.stack}`);
    }
}

// Opens a page, runs the body on it, and refuses any error or request.
async function on(file, options, body) {
    const { tab, faults } = await openPage(browser, file, { ...size, ...options });
    try {
        await settled(tab, options.state);
        await body(tab);
        assert.deepEqual(faults.filter((fault) => !options.expected?.test(fault)), []);
    } finally {
        await tab.context().close();
    }
}

const hash = (tab) => tab.evaluate(() => location.hash);
const said = (tab) => tab.locator("#message-text").textContent();

// What the action changes in the picture, in dB against before.
async function changes(tab, action) {
    const before = await picture(tab);
    await action();
    await tab.waitForTimeout(200); // until it has been noticed
    await settled(tab);
    return psnr(await picture(tab), before).db;
}

await test("the small page opens without error or request, within its size", async () => {
    assert.ok(small.facts.size_bytes <= 1e6, `${small.facts.size_bytes} bytes`);
    await on(small.file, {}, async (tab) => {
        assert.equal(await tab.title(), `<a> & "b" 'c'`);
        writeFileSync(join(folder, "desktop.png"), await tab.screenshot());
    });
});

for (const { session, file } of pages)
    for (const look of looks)
        await test(`${basename(session)} from ${look}: the page shows what sheen renders`, async () => {
            const distance = 0.5;
            const want = rendered(session, `${look},${distance}`);
            await on(file, { hash: `#view=${look},${distance}&interface=none` }, async (tab) => {
                const got = await picture(tab);
                writeFileSync(join(folder, `page-${basename(session)}-${look}.png`), PNG.sync.write(got));
                const { db, n } = psnr(got, want, objectIn(want));
                console.log(`     ${db.toFixed(1)} dB over ${n} pixels`);
                assert.ok(n > 2000, "the object should be in view");
                assert.ok(db >= leastDb);
            });
        });

for (const layer of ["diffuse", "specular"])
    await test(`the ${layer} layer is sheen's`, async () => {
        const look = `${looks[2]},0.5`;
        const inside = objectIn(rendered(small.session, look), true);
        const want = rendered(small.session, look, "--layer", layer);
        await on(small.file, { hash: `#view=${look}&interface=none&layer=${layer}` }, async (tab) => {
            const { db } = psnr(await picture(tab), want, inside);
            console.log(`     ${db.toFixed(1)} dB`);
            assert.ok(db >= leastDb);
        });
    });

await test("mouse, wheel and keys move the view; Home goes back", async () => {
    await on(small.file, { hash: "" }, async (tab) => {
        const first = await hash(tab);
        const drag = async () => {
            await tab.mouse.move(400, 300);
            await tab.mouse.down();
            await tab.mouse.move(480, 330, { steps: 4 });
            await tab.mouse.up();
        };
        assert.ok((await changes(tab, drag)) < 35, "dragging");
        assert.notEqual(await hash(tab), first);
        assert.ok((await changes(tab, () => tab.mouse.wheel(0, 400))) < 35, "wheel");
        await tab.focus("#stage");
        for (const key of ["ArrowLeft", "ArrowUp", "Shift+ArrowRight", "+", "-"]) {
            const before = await hash(tab);
            await changes(tab, () => tab.keyboard.press(key));
            assert.notEqual(await hash(tab), before, key);
        }
        await changes(tab, () => tab.keyboard.press("Home"));
        assert.equal(await hash(tab), first);
    });
});

await test("the controls change the picture and go back on reset", async () => {
    await on(small.file, { hash: `#view=${looks[2]},0.5` }, async (tab) => {
        for (const id of ["strength", "roughness", "lights"]) {
            const slide = async () => {
                await tab.focus(`#${id}`);
                await tab.keyboard.press("PageUp");
                await tab.keyboard.press("PageUp");
            };
            const value = await tab.locator(`#${id}-value`).textContent();
            assert.ok((await changes(tab, slide)) < 60, id);
            assert.notEqual(await tab.locator(`#${id}-value`).textContent(), value);
        }
        assert.ok((await changes(tab, () => tab.check("input[value=diffuse]"))) < 60, "layer");
        const link = await hash(tab);
        assert.match(link, /layer=diffuse.*strength=.*sigma=.*lights=/);
        await changes(tab, () => tab.click("#reset"));
        assert.doesNotMatch(await hash(tab), /layer|strength|sigma|lights/);
    });
});

await test("the turntable turns and stops", async () => {
    await on(small.file, {}, async (tab) => {
        const first = await hash(tab);
        await tab.click("#turn");
        await tab.waitForTimeout(1000);
        assert.equal(await tab.getAttribute("#turn", "aria-pressed"), "true");
        await tab.click("#turn");
        await settled(tab);
        await tab.waitForTimeout(300);
        await settled(tab);
        assert.notEqual(await hash(tab), first);
    });
});

await test("a link's view is the one that is shown, whatever it holds", async () => {
    const link = "#view=205,42,0.5&pan=0.01,-0.02&layer=specular&sigma=0.05&lights=40";
    await on(small.file, { hash: link }, async (tab) => assert.equal(await hash(tab), link));
    for (const bad of ["#view=NaN,,1e999&sigma=-1&lights=x&pan=,", "#%", "#view=1,2,0"])
        await on(small.file, { hash: bad }, async (tab) => assert.match(await hash(tab), /^#view=[-\d.]+,[-\d.]+,[\d.]+/));
});

await test("axe finds nothing serious", async () => {
    for (const colorScheme of ["light", "dark"])
        await on(small.file, { colorScheme }, async (tab) => {
            await tab.evaluate(() => document.querySelectorAll("details").forEach((part) => (part.open = true)));
            await tab.addScriptTag({ content: axe.source });
            const { violations } = await tab.evaluate(() => window.axe.run());
            for (const found of violations) console.log(`     ${found.impact}: ${found.id}: ${found.nodes.map((n) => n.target).join(" ")}`);
            assert.deepEqual(violations.filter(({ impact }) => impact === "serious" || impact === "critical"), []);
        });
});

await test("on a phone the object comes first, and a finger turns it", async () => {
    const phone = { width: 390, height: 844, deviceScaleFactor: 2, isMobile: true, hasTouch: true };
    await on(small.file, phone, async (tab) => {
        assert.equal(await tab.evaluate(() => document.getElementById("panel").open), false);
        assert.equal(await tab.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true);
        const before = await hash(tab);
        const client = await tab.context().newCDPSession(tab);
        const touch = (type, x) => client.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x, y: 300 }] });
        await touch("touchStart", 150);
        for (const x of [180, 210, 240]) await touch("touchMove", x);
        await touch("touchEnd");
        await tab.waitForTimeout(200);
        await settled(tab);
        assert.notEqual(await hash(tab), before);
        await tab.click("#panel summary");
        writeFileSync(join(folder, "phone.png"), await tab.screenshot());
    });
});

const photographs = exported(sessions[0], "photographs.html", "--photographs", "2");
await test("a photograph lies over the drawing from its own viewpoint, as far as the slider says", async () => {
    await on(photographs.file, {}, async (tab) => {
        assert.equal(await tab.locator("#photo option").count(), 3);
        await changes(tab, () => tab.selectOption("#photo", "0"));
        assert.match(await hash(tab), /photograph=1/);
        const slide = (to) => tab.locator("#slide").evaluate((input, value) => ((input.value = value), input.dispatchEvent(new Event("input"))), to);
        const hide = (tab) => tab.evaluate(() => (document.getElementById("panel").hidden = true));
        await hide(tab);
        await slide("0");
        await settled(tab);
        const drawn = await picture(tab);
        await slide("100");
        await tab.locator("#taken").evaluate((img) => img.decode());
        const taken = await picture(tab);
        await slide("50");
        writeFileSync(join(folder, "photograph.png"), await tab.screenshot());
        const { db, n } = psnr(drawn, taken, objectIn(drawn, true));
        console.log(`     ${db.toFixed(1)} dB over ${n} pixels`);
        assert.ok(n > 2000 && db > 20);
        await tab.focus("#stage");
        await changes(tab, () => tab.keyboard.press("ArrowLeft"));
        assert.doesNotMatch(await hash(tab), /photograph/);
        assert.equal(await tab.locator("#taken").isVisible(), false);
    });
});

await test("the triangles can be seen", async () => {
    await on(small.file, {}, async (tab) => assert.ok((await changes(tab, () => tab.check("#wire"))) < 35));
});

// sheen view on a session, until the body is done.
async function served(session, body) {
    const program = spawn(sheen, ["view", session, "--no-browser"], { stdio: ["ignore", "pipe", "inherit"] });
    try {
        const [line] = await once(program.stdout, "data");
        await body(String(line).split("\n")[0]);
    } finally {
        program.kill("SIGINT");
        const [code] = await once(program, "exit");
        assert.equal(code, 0);
    }
}

// The answer's status to a request with these headers.
const asked = (address, path, { method = "GET", host } = {}) =>
    new Promise((resolve, reject) => {
        const { hostname, port } = new URL(address);
        const query = request({ hostname, port, path, method, headers: host ? { host } : {} }, (answer) => {
            answer.resume();
            answer.on("end", () => resolve(answer.statusCode));
        });
        query.on("error", reject);
        query.end();
    });

await test("the served page follows the session, and nobody else is answered", async () => {
    const session = join(folder, "served.session");
    cpSync(sessions[0], session, { recursive: true });
    renameSync(join(session, "model"), join(session, "later"));
    await served(session, async (address) => {
        const { pathname, port } = new URL(address);
        const { tab, faults } = await openPage(browser, address, size);
        assert.match(await tab.locator("main").textContent(), /no model yet/);
        renameSync(join(session, "later"), join(session, "model"));
        await settled(tab);
        await changes(tab, () => tab.selectOption("#photo", "1"));
        await tab.locator("#taken").evaluate((img) => img.decode());
        writeFileSync(join(folder, "served.png"), await tab.screenshot());
        const again = tab.waitForEvent("framenavigated");
        const later = new Date(Date.now() + 5000);
        utimesSync(join(session, "model/model.json"), later, later);
        await again;
        await settled(tab);
        assert.match(await hash(tab), /photograph=2/);
        assert.deepEqual(faults, []);
        await tab.context().close();
        assert.equal(await asked(address, pathname, { host: `localhost:${port}` }), 200);
        for (const host of ["evil.example", `evil.example:${port}`, "127.0.0.1", `127.0.0.1.evil.example:${port}`])
            assert.equal(await asked(address, pathname, { host }), 403, host);
        for (const path of ["/", pathname.slice(0, -3) + "00/", "/../", `${pathname}../../etc/passwd`, `${pathname}photo/..%2f..%2fsession.json`, `${pathname}photo/99`, `${pathname}photo/-1`, `${pathname}session.json`, `//${pathname}`])
            assert.equal(await asked(address, path), 404, path);
        for (const method of ["POST", "PUT", "DELETE", "OPTIONS"]) assert.equal(await asked(address, pathname, { method }), 405, method);
        assert.equal(await asked(address, pathname, { method: "HEAD" }), 200);
    });
    rmSync(session, { recursive: true });
});

// The page whose model's numbers were changed, packed again as sheen packs them (render/page_layout.h).
function hostile(html, change) {
    const start = html.indexOf('id="geometry">') + 'id="geometry">'.length;
    const end = html.indexOf("</script>", start);
    const bytes = inflateRawSync(Buffer.from(html.slice(start, end), "base64"));
    const after = 8 + bytes.readUInt32LE(4);
    const text = Buffer.from(change(bytes.subarray(8, after).toString("utf8")));
    const head = Buffer.from(bytes.subarray(0, 8));
    head.writeUInt32LE(text.length, 4);
    const packed = deflateRawSync(Buffer.concat([head, text, bytes.subarray(after)]), { level: 1 });
    return html.slice(0, start) + packed.toString("base64") + html.slice(end);
}

await test("a model that was made to harm is one sentence", async () => {
    const html = readFileSync(small.file, "utf8");
    const numbers = (change) => (text) => {
        const n = JSON.parse(text);
        change(n);
        return JSON.stringify(n);
    };
    const many = (n, one) => `[${`${one},`.repeat(n - 1)}${one}]`;
    const pages = {
        same: [(text) => text, undefined, null],
        nodes: [(text) => text.replace(/"radiance": ?\[[^\]]*\]/, () => `"radiance":${many(1e7, 1)}`), "error", /damaged/],
        "nodes-alike": [numbers((n) => Object.assign(n.model.nodes, { radiance: Array(2e5).fill(1), direction_world: Array(2e5).fill([0, 0, 1]) })), "error", /damaged/],
        bytes: [(text) => text + " ".repeat(3e8), "error", /damaged/],
        infinite: [(text) => text.replace(/"k_s": ?[^,]*/, '"k_s":1e999'), "error", /damaged/],
        none: [(text) => text.replace(/"sigma_rad": ?[^,]*/, '"sigma_rad":NaN'), "error", /damaged/],
        texels: [numbers((n) => (n.texels_per_edge = 0)), "error", /damaged/],
        triangles: [numbers((n) => (n.n_triangles = 1)), "error", /damaged/],
    };
    for (const [name, [change, state, expected]] of Object.entries(pages)) {
        const file = join(folder, `hostile-${name}.html`);
        writeFileSync(file, hostile(html, change));
        await on(file, { state, expected: /^console: / }, async (tab) => {
            if (state === "error") assert.match(await said(tab), expected, name);
        });
    }
});

await test("graphics that are taken away are said to be, and come back with the same picture", async () => {
    await on(small.file, { hash: `#view=${looks[2]},0.5` }, async (tab) => {
        const before = await picture(tab);
        await tab.evaluate(() => {
            window.graphics = document.getElementById("stage").getContext("webgl2").getExtension("WEBGL_lose_context");
            window.graphics.loseContext();
        });
        await settled(tab, "error");
        assert.match(await said(tab), /took the graphics away/);
        await tab.waitForTimeout(300);
        await tab.evaluate(() => window.graphics.restoreContext());
        await settled(tab);
        await tab.waitForTimeout(300);
        await settled(tab);
        const { db } = psnr(await picture(tab), before);
        console.log(`     ${db.toFixed(1)} dB`);
        assert.ok(db > 50);
        assert.ok((await changes(tab, () => tab.check("input[value=diffuse]"))) < 60, "controls still work");
    });
});

await test("without WebGL2, and with a damaged model, the page says so", async () => {
    const html = readFileSync(small.file, "utf8");
    const write = (name, text) => {
        writeFileSync(join(folder, name), text);
        return join(folder, name);
    };
    const start = html.indexOf('id="geometry">') + 'id="geometry">'.length;
    const damaged = {
        "cut.html": html.slice(0, start + 2000) + html.slice(html.indexOf("</script>", start)),
        "other.html": html.slice(0, start) + "AAAA" + html.slice(start + 4),
        "none.html": html.slice(0, start) + html.slice(html.indexOf("</script>", start)),
    };
    for (const [name, text] of Object.entries(damaged))
        await on(write(name, text), { state: "error", expected: /^console: / }, async (tab) => assert.match(await said(tab), /damaged/));
    const blind = `<script>HTMLCanvasElement.prototype.getContext = () => null;</script>`;
    await on(write("blind.html", html.replace("<main>", `<main>${blind}`)), { state: "error", expected: /^console: / }, async (tab) =>
        assert.match(await said(tab), /WebGL2/),
    );
});

await browser.close();
console.log(failed ? `${failed} tests failed` : "all tests passed");
process.exit(failed ? 1 : 0);
