// SPDX-License-Identifier: Apache-2.0
// start.ts - the few lines that run as they stand in the page: inflate the viewer and start it, or say why not.
function fail(text: string): void {
    document.documentElement.dataset.state = "error";
    document.getElementById("message-text")!.textContent = text;
}

async function start(): Promise<void> {
    if (typeof DecompressionStream === "undefined") {
        fail("This browser is too old for this page: it wants one of 2023 or later.");
        return;
    }
    const packed = Uint8Array.from(atob(document.getElementById("viewer")!.textContent!), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.append(script);
}

start().catch(() => fail("This page is damaged: its viewer cannot be read. Was it saved or sent incompletely?"));
