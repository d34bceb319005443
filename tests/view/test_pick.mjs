// SPDX-License-Identifier: Apache-2.0
// test_pick.mjs - the page of marks in a browser: node test_pick.mjs CHROMIUM SHEEN FOLDER SESSION MESH MARKS
// SESSION has camera and poses but no masks; MESH (millimetres, y up) stands in it; MARKS are true marks of it, by which
// the test knows where to click. Marks by mouse and by keys; the file that comes of it registers the mesh.
import axe from "axe-core";
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { openBrowser, openPage } from "./browser.mjs";

const [, , chromium, sheen, folder, session, mesh, truth] = process.argv;
mkdirSync(folder, { recursive: true });
const file = join(folder, "marks.txt");
rmSync(file, { force: true });
const lines = (path) => readFileSync(path, "utf8").split("\n").filter((line) => line && !line.startsWith("#"));
const marks = lines(truth).map((line) => line.split(" ")).map(([frame, ...x]) => ({ frame, q: x.slice(0, 2).map(Number), p: x.slice(2).map(Number) }));

const program = spawn(sheen, ["register", session, mesh, "--pick", file, "--unit", "mm", "--up", "y", "--no-browser"], { stdio: ["ignore", "pipe", "inherit"] });
const [line] = await once(program.stdout, "data");
const address = String(line).split("\n")[0];
const browser = await openBrowser(chromium);
const { tab, faults } = await openPage(browser, address, { width: 1400, height: 900 });
await tab.waitForFunction(() => document.documentElement.dataset.state === "ready");
await tab.waitForFunction(() => [...document.images].every((image) => image.complete && image.naturalWidth > 0));

const said = () => tab.locator("#said").textContent();
const counted = (n) => tab.waitForFunction((want) => document.getElementById("said").textContent.startsWith(want), `${n} mark`);
const clickAt = async (pane, q, side) => {
    const image = tab.locator(`#${pane} img`);
    const box = await image.boundingBox();
    const [w, h] = side;
    await image.click({ position: { x: ((q[0] + 0.5) / w) * box.width, y: ((q[1] + 0.5) / h) * box.height } });
};
const facts = await (await fetch(`${address}frames`)).json();
const meshSide = [facts.mesh_side_px, facts.mesh_side_px];

// Where the page's view of the mesh shows a point: its camera (cli/pick.c) written again.
const places = async (points, azimuth, elevation, bounds) => {
    const [a, e] = [azimuth, elevation].map((degrees) => (degrees * Math.PI) / 180);
    const axes = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]; // up y
    const along = (k) => [0, 1, 2].map((c) => k[0] * axes[0][c] + k[1] * axes[1][c] + k[2] * axes[2][c]);
    const right = along([-Math.sin(a), Math.cos(a), 0]);
    const forward = along([-Math.cos(e) * Math.cos(a), -Math.cos(e) * Math.sin(a), -Math.sin(e)]);
    const down = [forward[1] * right[2] - forward[2] * right[1], forward[2] * right[0] - forward[0] * right[2], forward[0] * right[1] - forward[1] * right[0]];
    const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    const f = 0.48 * meshSide[0] * Math.sqrt(24);
    return points.map((p) => {
        const d = p.map((x, c) => x - bounds.centre[c]);
        const z = dot(forward, d) + 5 * bounds.radius;
        return [(f * dot(right, d)) / z + (meshSide[0] - 1) / 2, (f * dot(down, d)) / z + (meshSide[0] - 1) / 2];
    });
};
// The sphere that `sheen` puts round the mesh: round the middle of its box.
const vertices = readFileSync(mesh, "utf8").split("\n").filter((l) => l.startsWith("v ")).map((l) => l.split(" ").slice(1).map(Number));
const centre = [0, 1, 2].map((c) => (Math.min(...vertices.map((v) => v[c])) + Math.max(...vertices.map((v) => v[c]))) / 2);
const bounds = { centre, radius: Math.max(...vertices.map((v) => Math.hypot(...v.map((x, c) => x - centre[c])))) };

// A point on the side that is looked at, marked in a frame: by mouse.
let n = 0;
const view = [30, 20];
const turnTo = async (azimuth) => {
    for (; view[0] !== azimuth; view[0] = (view[0] + 15) % 360) await tab.getByRole("button", { name: "Right" }).click();
    await tab.waitForFunction((want) => document.querySelector("#mesh img").src.endsWith(want) && document.querySelector("#mesh img").complete, `mesh/${azimuth}/20`);
};
const mark = async (m, azimuth) => {
    await turnTo(azimuth);
    const [q] = await places([m.p], azimuth, 20, bounds);
    await tab.selectOption("#which", m.frame);
    await clickAt("mesh", q, meshSide);
    await clickAt("frame", m.q, [facts.width_px, facts.height_px]);
    await counted(++n);
};
try {
    // of each frame's six marks: five, each from the side that it is on
    for (const frame of [...new Set(marks.map((m) => m.frame))]) {
        const of = marks.filter((m) => m.frame === frame);
        for (const [i, azimuth] of [[0, 30], [1, 90], [4, 180], [3, 270], [2, 0]]) await mark(of[i], azimuth);
    }
    assert.match(await said(), /fit to [0-2]\.\d px/);
    const byMouse = lines(file);
    assert.equal(byMouse.length, n);
    await turnTo(30);
    writeFileSync(join(folder, "pick.png"), await tab.screenshot());

    // a place beside the mesh is refused, and the last mark can be taken back
    await clickAt("mesh", [2, 2], meshSide);
    await clickAt("frame", [100, 100], [facts.width_px, facts.height_px]);
    await tab.waitForFunction(() => document.getElementById("said").textContent.includes("no mesh at that place"));
    assert.equal(lines(file).length, n);

    // by keys alone: crosses to the middle's right, Enter on both
    await tab.locator("#mesh").focus();
    await tab.keyboard.press("d");
    await tab.keyboard.press("ArrowDown");
    await clickAt("mesh", [320, 320], meshSide);
    await tab.keyboard.press("ArrowLeft");
    await tab.keyboard.press("Enter");
    await tab.locator("#frame").focus();
    await tab.keyboard.press("Shift+ArrowRight");
    await tab.keyboard.press("Enter");
    await counted(n + 1);
    const byKeys = lines(file).at(-1).split(" ").map(Number);
    assert.ok(Math.abs(byKeys[1] - 100.5) < 1 && Math.abs(byKeys[2] - 100) < 1, lines(file).at(-1));
    await tab.getByRole("button", { name: "Undo" }).click();
    await counted(n);
    assert.deepEqual(lines(file), byMouse);

    await tab.selectOption("#size", "4");
    assert.ok((await tab.locator("#frame img").boundingBox()).width > 3.9 * facts.width_px);
    await tab.evaluate(axe.source);
    const found = await tab.evaluate(() => window.axe.run());
    assert.deepEqual(found.violations.map((v) => `${v.id}: ${v.help}`), []);
    for (const [path, status] of [["mark/0/1/2/3", 404], ["mark/99/1/2/3/4/5/6", 404], ["mark/-1/1/2/3/4/5/6", 404], ["mark/0/nan/2/3/4/5/6", 404], ["frame/-1", 404], ["frame/99", 404], ["mesh/1e9/0", 404], ["marks/1", 404]])
        assert.equal((await fetch(address + path)).status, status, path);
    assert.deepEqual(faults, []);
} finally {
    await browser.close();
    program.kill("SIGINT");
}
assert.equal((await once(program, "exit"))[0], 0);
const said2 = JSON.parse(execFileSync(sheen, ["register", session, mesh, "--points", file, "--unit", "mm", "--json"], { encoding: "utf8" }));
assert.ok(said2.points_rms_px < 2, `marks fit to ${said2.points_rms_px} px`);
console.log(`ok   ${n} marks on the page fit to ${said2.points_rms_px.toFixed(2)} px`);
