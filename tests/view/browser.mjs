// SPDX-License-Identifier: Apache-2.0
// browser.mjs - headless Chromium with software GL and no network, and pictures out of it.
import { chromium } from "playwright-core";
import { PNG } from "pngjs";
import { pathToFileURL } from "node:url";

export async function openBrowser(executable) {
    return chromium.launch({
        executablePath: executable,
        args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
    });
}

// A tab on a file (or an address), with everything that went wrong in it: errors, and requests other than for the file itself, or below
// the address.
export async function openPage(browser, file, { hash = "", width = 960, height = 720, ...context } = {}) {
    const tab = await browser.newPage({ viewport: { width, height }, ...context });
    const faults = [];
    const address = file.startsWith("http") ? file : pathToFileURL(file).href;
    tab.on("pageerror", (error) => faults.push(`error: ${error.message}`));
    tab.on("console", (message) => {
        if (message.type() === "error") faults.push(`console: ${message.text()}`);
    });
    tab.on("request", (request) => {
        const url = request.url();
        if (!url.startsWith(address) && !/^(data|blob):/.test(url)) faults.push(`request: ${url}`);
    });
    await tab.goto(address + hash);
    return { tab, faults };
}

// Until the picture that belongs to the present view stands complete.
export async function settled(tab, state = "ready") {
    await tab.waitForFunction((want) => document.documentElement.dataset.state === want, state, { timeout: 60000 });
    if (state === "ready")
        await tab.waitForFunction(() => document.documentElement.dataset.drawn === "still", null, { timeout: 60000 });
}

export async function picture(tab) {
    return PNG.sync.read(await tab.screenshot());
}

// dB of 8-bit sRGB values over the pixels that select() picks.
export function psnr(a, b, select = () => true) {
    if (a.width !== b.width || a.height !== b.height) throw new Error(`${a.width}x${a.height} against ${b.width}x${b.height}`);
    let sum = 0;
    let n = 0;
    for (let i = 0; i < a.width * a.height; i++) {
        if (!select(i)) continue;
        n++;
        for (let c = 0; c < 3; c++) sum += (a.data[4 * i + c] - b.data[4 * i + c]) ** 2;
    }
    return { db: 10 * Math.log10((255 * 255 * 3 * n) / Math.max(sum, 1e-9)), n };
}
