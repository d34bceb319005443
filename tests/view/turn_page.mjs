// SPDX-License-Identifier: Apache-2.0
// turn_page.mjs - a page's turntable, in frames a second and as pictures: node turn_page.mjs CHROMIUM PAGE [FOLDER]
// Software GL: what it says is of processors. With FOLDER the object from 24 sides is left there.
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { openBrowser, openPage, settled } from "./browser.mjs";

const [, , chromium, page, folder] = process.argv;
const seconds = 5;
const browser = await openBrowser(chromium);

// Frames of the turning page; the renderer's time is in them, since each picture is waited for.
async function rate(size, hash) {
    const { tab } = await openPage(browser, page, { ...size, hash });
    await settled(tab);
    await tab.evaluate(() => document.getElementById("turn").click());
    await tab.waitForTimeout(1500);
    const shown = await tab.evaluate(
        (duration) =>
            new Promise((resolve) => {
                const began = performance.now();
                let n = 0;
                const count = () => {
                    const elapsed = performance.now() - began;
                    if (elapsed > 1000 * duration && n > 2) resolve((1000 * n) / elapsed);
                    else n++, requestAnimationFrame(count);
                };
                requestAnimationFrame(count);
            }),
        seconds,
    );
    await tab.context().close();
    return shown;
}

for (const [width, height] of [[960, 720], [1920, 1080]])
    for (const hash of ["", "#sigma=0.2"]) console.log(`${width} x ${height}${hash && " " + hash}: ${(await rate({ width, height }, hash)).toFixed(1)} frames/s`);

if (folder) {
    mkdirSync(folder, { recursive: true });
    const { tab } = await openPage(browser, page, { hash: "#interface=none", width: 480, height: 480 });
    await settled(tab);
    const first = (await tab.evaluate(() => location.hash)).match(/view=([^&]*)/)?.[1].split(",").map(Number);
    for (let i = 0; i < 24; i++) {
        const view = [first[0] + 15 * i, first[1], first[2]].map((x) => x.toPrecision(6)).join(",");
        await tab.evaluate((hash) => (location.hash = hash), `#view=${view}&interface=none`);
        await tab.waitForTimeout(200);
        await settled(tab);
        writeFileSync(join(folder, `turn-${String(i).padStart(2, "0")}.png`), await tab.screenshot());
    }
}
await browser.close();
