// SPDX-License-Identifier: Apache-2.0
// build.mjs - the viewer as one HTML text, and the page of marks, written as C arrays: node build.mjs OUTPUT.c [OUTPUT.html]
//
// The program text is deflated and inflated again by the page, as the model is: three.js is long.
import { build } from "esbuild";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { deflateRawSync } from "node:zlib";

const here = dirname(fileURLToPath(import.meta.url));
const [, , cFile, htmlFile] = process.argv;

async function bundle(entry, options) {
    const result = await build({
        entryPoints: [join(here, entry)],
        bundle: true,
        minify: true,
        write: false,
        logLevel: "warning",
        legalComments: "none",
        target: ["chrome103", "firefox113", "safari16.4"],
        ...options,
    });
    return result.outputFiles[0].text;
}

// Replaces a mark that must be there once; a function, because text may hold `$&`.
function put(text, mark, value) {
    if (text.split(mark).length !== 2) throw new Error(`page.html should hold ${mark} once`);
    return text.replace(mark, () => value);
}

const script = await bundle("main.ts", { format: "iife" });
const start = await bundle("start.ts", { format: "iife" });
const style = await bundle("style.css", {});
let html = readFileSync(join(here, "page.html"), "utf8");
html = put(html, "/*@STYLE@*/", style.trim());
html = put(html, "/*@START@*/", start.trim().replaceAll("</script", "<\\/script"));
html = put(html, "@VIEWER@", deflateRawSync(script, { level: 9 }).toString("base64"));
if (htmlFile) writeFileSync(htmlFile, html);

let pick = readFileSync(join(here, "pick.html"), "utf8");
pick = put(pick, "/*@STYLE@*/", (await bundle("pick.css", {})).trim());
pick = put(pick, "/*@PICK@*/", (await bundle("pick.ts", { format: "iife" })).trim().replaceAll("</script", "<\\/script"));

function array(name, text) {
    const bytes = [...Buffer.from(text, "utf8"), 0];
    const lines = [];
    for (let i = 0; i < bytes.length; i += 24) lines.push(bytes.slice(i, i + 24).map((b) => (b > 127 ? b - 256 : b)).join(","));
    return `\nconst char ${name}[] = {\n${lines.join(",\n")}};\n`;
}
writeFileSync(
    cFile,
    `// Made by view/build.mjs; do not edit.\n#include "cli/viewer_html.h"\n${array("sheen_viewer_html", html)}${array("sheen_pick_html", pick)}`,
);
