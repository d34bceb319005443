// SPDX-License-Identifier: Apache-2.0
// test_gltf.mjs - exported glTF files: node test_gltf.mjs CHROMIUM SHEEN FOLDER SESSION...
// The Khronos validator finds nothing, and three.js shows them under their panorama as sheen renders the model, highlights
// at the same places (but for a session called "bent"). Files and pictures are left in FOLDER.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";
import validator from "gltf-validator";
import { PNG } from "pngjs";
import { openBrowser, psnr } from "./browser.mjs";

const [, , chromium, sheen, folder, ...sessions] = process.argv;
const here = dirname(fileURLToPath(import.meta.url));
const [width, height] = [1920, 1080];
const leastDb = 28;
const mostPx = 3;
const looks = [[30, 25], [120, 10], [205, 42], [290, 60]];
mkdirSync(folder, { recursive: true });
const run = (...args) => execFileSync(sheen, args, { encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });

function rendered(session, look, layer) {
    const file = join(folder, `gltf-want-${basename(session)}-${look}-${layer}.png`);
    run("render", session, `--view=${look},0.5`, "--size", `${width}x${height}`, "--layer", layer, "-o", file);
    return PNG.sync.read(readFileSync(file));
}

const linear = (code) => (code <= 10.31475 ? code / 255 / 12.92 : ((code / 255 + 0.055) / 1.055) ** 2.4);

// Rectangles about the highlights: connected pixels whose specular part is near the brightest, the first `most` by area.
function highlightsIn(specular, most = 4) {
    const label = new Int32Array(width * height);
    const found = [];
    const brightest = specular.data.reduce((most, code, i) => (i % 4 === 1 && code > most ? code : most), 0);
    const bright = (i) => specular.data[4 * i + 1] > 0.6 * brightest;
    for (let start = 0; start < width * height; start++) {
        if (label[start] || !bright(start)) continue;
        const stack = [start];
        const blob = { n: 0, x0: width, y0: height, x1: 0, y1: 0 };
        label[start] = found.length + 1;
        while (stack.length) {
            const i = stack.pop();
            const [x, y] = [i % width, Math.floor(i / width)];
            blob.n++;
            blob.x0 = Math.min(blob.x0, x);
            blob.x1 = Math.max(blob.x1, x);
            blob.y0 = Math.min(blob.y0, y);
            blob.y1 = Math.max(blob.y1, y);
            for (const k of [i - 1, i + 1, i - width, i + width])
                if (k >= 0 && k < width * height && !label[k] && bright(k)) {
                    label[k] = found.length + 1;
                    stack.push(k);
                }
        }
        found.push(blob);
    }
    return found.filter(({ n }) => n >= 60).sort((a, b) => b.n - a.n).slice(0, most);
}

// By how many pixels `got` has a highlight elsewhere than `want`: the shift at which what is brighter than the diffuse layer, by a
// third of the most and more, correlates best, over the object in the blob's rectangle with a margin. (GGX's peak is another
// than the model's and its tail is longer, so that middles of long highlights differ where nothing has moved.)
function shiftOf(got, want, diffuse, object, { x0, y0, x1, y1 }, margin = 12) {
    const brighter = (picture, i) => linear(picture.data[4 * i + 1]) - linear(diffuse.data[4 * i + 1]);
    const third = (picture) => {
        let most = 0;
        for (let y = y0; y <= y1; y++)
            for (let x = x0; x <= x1; x++) if (object(y * width + x)) most = Math.max(most, brighter(picture, y * width + x));
        return most / 3;
    };
    const [fromGot, fromWant] = [third(got), third(want)];
    const correlation = (dx, dy) => {
        let [n, a, b, aa, bb, ab] = [0, 0, 0, 0, 0, 0];
        for (let y = y0 - margin; y <= y1 + margin; y++)
            for (let x = x0 - margin; x <= x1 + margin; x++) {
                const [i, k] = [y * width + x, (y + dy) * width + x + dx];
                if (!object(i) || !object(k)) continue;
                const [p, q] = [Math.max(0, brighter(want, i) - fromWant), Math.max(0, brighter(got, k) - fromGot)];
                n++;
                a += p;
                b += q;
                aa += p * p;
                bb += q * q;
                ab += p * q;
            }
        return (ab - (a * b) / n) / Math.sqrt((aa - (a * a) / n) * (bb - (b * b) / n));
    };
    let best = { value: -1, apart: NaN };
    for (let dy = -margin; dy <= margin; dy++)
        for (let dx = -margin; dx <= margin; dx++) {
            const value = correlation(dx, dy);
            if (value > best.value) best = { value, apart: Math.hypot(dx, dy) };
        }
    return best.apart;
}

const viewer = await build({ entryPoints: [join(here, "gltf_viewer.js")], bundle: true, minify: true, write: false, format: "iife" });
const browser = await openBrowser(chromium);
let failed = 0;

async function test(name, body) {
    try {
        await body();
        console.log(`ok   ${name}`);
    } catch (error) {
        failed++;
        console.log(`FAIL ${name}\n${error.stack}`);
    }
}

async function shown(glb, hdr, facts, [azimuth, elevation], more = {}) {
    const tab = await browser.newPage({ viewport: { width, height } });
    try {
        await tab.setContent("<!doctype html><body style='margin:0'></body>");
        await tab.addScriptTag({ content: viewer.outputFiles[0].text });
        const look = { azimuth, elevation, distance: 0.5, middle: facts.middle_gltf, focalPerWidth: facts.focal_per_width, width, height, ...more };
        await tab.evaluate(([a, b, c]) => window.show(a, b, c), [readFileSync(glb, "base64"), readFileSync(hdr, "base64"), look]);
        return PNG.sync.read(await tab.screenshot());
    } finally {
        await tab.close();
    }
}

for (const session of sessions) {
    const name = basename(session, ".session");
    const glb = join(folder, `${name}.glb`);
    const facts = JSON.parse(run("export", session, "-o", glb, "--json"));

    await test(`${name}: the validator finds nothing, the file is within shops' limits`, async () => {
        for (const lights of [0, 4]) {
            const file = lights ? join(folder, `${name}-lights.glb`) : glb;
            if (lights) assert.equal(JSON.parse(run("export", session, "-o", file, "--json", "--lights", String(lights))).lights > 0, true);
            const { issues, info } = await validator.validateBytes(new Uint8Array(readFileSync(file)));
            assert.deepEqual(issues.messages, []);
            assert.ok(info.totalTriangleCount <= 150000);
            assert.ok(readFileSync(file).length <= 3e6);
        }
        assert.ok(facts.texture_px <= 2048);
    });

    for (const look of looks)
        await test(`${name} from ${look}: three.js shows what sheen renders`, async () => {
            const want = rendered(session, look, "all");
            const got = await shown(glb, facts.panorama, facts, look);
            writeFileSync(join(folder, `gltf-got-${name}-${look}.png`), PNG.sync.write(got));
            // The object, but for surface that no photograph saw (marked magenta here, filled from about it there) and the
            // outermost pixel, in which both blend it with the background in their own ways.
            const drawn = (i) => [0, 1, 2].some((c) => want.data[4 * i + c] !== want.data[c]);
            const hole = (i) => want.data[4 * i] > 250 && want.data[4 * i + 2] > 250 && want.data[4 * i + 1] < want.data[4 * i] - 20;
            const about = [-1, 0, 1].flatMap((y) => [-1, 0, 1].map((x) => y * width + x));
            const mask = Uint8Array.from({ length: width * height }, (_, i) => about.every((step) => drawn(i + step) && !hole(i + step)));
            const object = (i) => mask[i] === 1;
            const { db, n } = psnr(got, want, object);
            const diffuse = rendered(session, look, "diffuse");
            const apart = highlightsIn(rendered(session, look, "specular")).map((blob) => shiftOf(got, want, diffuse, object, blob));
            console.log(`     ${db.toFixed(1)} dB over ${n} pixels; highlights apart by ${apart.map((d) => d.toFixed(1)).join(", ")} px`);
            assert.ok(n > 2000);
            assert.ok(db >= leastDb, `${db} dB`);
            assert.ok(apart.length > 0, "no highlight to compare");
            // A relief breaks them into streaks, whose middles go with the lobe's shape, and GGX's is another.
            assert.ok(name === "bent" || apart.every((d) => d <= mostPx), "highlights");
        });
}

await browser.close();
console.log(failed ? `${failed} tests failed` : "all tests passed");
process.exit(failed ? 1 : 0);
