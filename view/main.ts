// SPDX-License-Identifier: Apache-2.0
// main.ts - the page: reads the model, draws it, and connects what a person can do with it.
import { listen, motionOn } from "./controls";
import { drawHemisphere } from "./hemisphere";
import { type Model, ModelError, readModel } from "./model";
import { type More, readMore } from "./more";
import { Stage } from "./scene";
import { firstView, fromHash, toHash, type View, viewOfPhoto } from "./view";

const degreesPerSecond = 24; // of the turntable
const root = document.documentElement;

function element<T extends HTMLElement>(id: string): T {
    return document.getElementById(id) as T;
}

function fail(text: string): void {
    root.dataset.state = "error";
    element("message-text").textContent = text;
}

// Shows how far loading is, and lets the browser paint it.
async function progress(share: number): Promise<void> {
    element<HTMLProgressElement>("bar").value = share;
    await new Promise((resolve) => setTimeout(resolve, 0));
}

class Page {
    private readonly canvas = element<HTMLCanvasElement>("stage");
    private readonly stage: Stage;
    private readonly first: View;
    private view: View;
    private moving = false; // drawn coarsely until things stand still
    private turning = false;
    private complete = false;
    private last = 0; // time of the last frame, ms
    private movedAt = 0;

    constructor(
        private readonly model: Model,
        private readonly more: More,
    ) {
        this.stage = new Stage(this.canvas, model, more);
        this.stage.resize();
        this.first = firstView(model, more, this.canvas.width, this.canvas.height);
        this.view = this.fromAddress();
        if (new URLSearchParams(location.hash.slice(1)).get("interface") === "none") root.dataset.interface = "none";
        const home = (): void => this.show({ ...this.view, ...this.viewpoint(this.first), photo: -1 });
        const move = (view: View): void => this.show({ ...view, photo: -1 }); // the photograph was taken from where it was
        listen(this.canvas, motionOn(() => this.view, move, home, model.radius, model.focalPerWidth));
        this.connectForm();
        this.connectButtons();
        addEventListener("resize", () => this.show({ ...this.view }));
        addEventListener("hashchange", () => this.show(this.fromAddress()));
        this.connectPhotographs();
        this.followServer();
        this.canvas.addEventListener("webglcontextlost", () => fail("The browser took the graphics away. The object comes back with them; if it does not, reload the page."));
        this.canvas.addEventListener("webglcontextrestored", () => {
            this.stage.restore();
            root.dataset.state = "ready";
            this.show({ ...this.view });
        });
        this.fillForm();
        // The first picture is drawn here, so that a shader that does not compile is noticed.
        while (!this.stage.drawStill(this.view));
        requestAnimationFrame((now) => this.frame(now));
    }

    private fromAddress(): View {
        const view = fromHash(location.hash, this.first, this.model.radius, this.more.photographs.length);
        return view.photo < 0 ? view : { ...view, ...viewOfPhoto(this.model, this.more.photographs[view.photo].rtCamObj) };
    }

    private connectPhotographs(): void {
        const { photographs } = this.more;
        const choice = element<HTMLSelectElement>("photo");
        element("photographs").hidden = photographs.length === 0;
        photographs.forEach(({ name }, i) => choice.append(new Option(name, String(i))));
        choice.addEventListener("change", () => {
            const photo = Number(choice.value);
            this.setTurning(false);
            this.show({ ...this.view, photo, ...(photo < 0 ? {} : viewOfPhoto(this.model, photographs[photo].rtCamObj)) });
        });
        element("slide").addEventListener("input", () => this.fillForm());
        element("taken").addEventListener("error", () => this.say("The photograph could not be had."));
    }

    // The photograph covers the right of the drawing, as far as the slider says.
    private layPhotograph(): void {
        const taken = element<HTMLImageElement>("taken");
        const photograph = this.more.photographs[this.view.photo];
        const share = element<HTMLInputElement>("slide").valueAsNumber;
        element("slide-value").textContent = `${share} %`;
        taken.hidden = !photograph;
        if (!photograph) return;
        if (taken.getAttribute("src") !== photograph.src) taken.src = photograph.src;
        taken.alt = `Photograph ${photograph.name}`;
        taken.style.clipPath = `inset(0 0 0 ${100 - share}%)`;
    }

    // A page that is served asks whether the model has changed, and shows the new one from the same view.
    private followServer(): void {
        const { state } = this.more;
        if (!state) return;
        setInterval(() => {
            fetch(state)
                .then(async (answer) => {
                    if (((await answer.json()) as { changed: boolean }).changed) location.reload();
                })
                .catch(() => this.say("sheen view has ended; this page stays as it is."));
        }, 2000);
    }

    private setTurning(turning: boolean): void {
        this.turning = turning;
        element("turn").setAttribute("aria-pressed", String(turning));
    }

    private viewpoint(view: View): Pick<View, "azimuth" | "elevation" | "distance" | "pan"> {
        return { azimuth: view.azimuth, elevation: view.elevation, distance: view.distance, pan: view.pan };
    }

    private show(view: View): void {
        this.view = view;
        this.moving = true;
        this.complete = false;
        this.movedAt = performance.now();
        this.fillForm();
    }

    private frame(now: number): void {
        requestAnimationFrame((next) => this.frame(next));
        if (this.stage.lost) return;
        const elapsed = this.last ? (now - this.last) / 1000 : 0;
        this.last = now;
        if (this.stage.resize()) this.show(this.view);
        if (this.turning)
            this.show({ ...this.view, photo: -1, azimuth: (this.view.azimuth + Math.min(elapsed, 0.25) * degreesPerSecond) % 360 });
        if (this.moving) {
            root.dataset.drawn = "moving";
            this.stage.drawMoving(this.view, elapsed);
            this.moving = now - this.movedAt < 120;
        } else if (!this.complete) {
            this.complete = this.stage.drawStill(this.view);
            if (this.complete) {
                root.dataset.drawn = "still";
                this.keepAddress();
            }
        }
    }

    private keepAddress(): void {
        const none = root.dataset.interface === "none" ? "&interface=none" : "";
        try {
            history.replaceState(null, "", toHash(this.view, this.first) + none);
        } catch {
            // a page in a frame or from a disk may not be permitted to; the link button still works
        }
    }

    // Controls say what the view is, however it came about.
    private fillForm(): void {
        const { view } = this;
        const set = (id: string, value: number, text: string): void => {
            element<HTMLInputElement>(id).value = String(value);
            element(`${id}-value`).textContent = text;
            element(id).setAttribute("aria-valuetext", text);
        };
        set("strength", view.strength, `${Math.round(100 * view.strength)} %`);
        set("roughness", Math.log10(view.sigma), `σ ${view.sigma.toPrecision(3)} rad`);
        set("lights", view.turn, `${Math.round(view.turn)}°`);
        element<HTMLInputElement>("holes").checked = view.holes;
        element<HTMLInputElement>("wire").checked = view.wire;
        element<HTMLSelectElement>("photo").value = String(view.photo);
        this.layPhotograph();
        for (const radio of document.querySelectorAll<HTMLInputElement>("input[name=layer]")) radio.checked = radio.value === view.layer;
        if (element<HTMLDetailsElement>("hemisphere-part").open)
            drawHemisphere(element<HTMLCanvasElement>("hemisphere"), this.model, view);
    }

    private connectForm(): void {
        const on = (id: string, change: (input: HTMLInputElement) => Partial<View>): void => {
            const input = element<HTMLInputElement>(id);
            input.addEventListener("input", () => this.show({ ...this.view, ...change(input) }));
        };
        on("strength", (input) => ({ strength: input.valueAsNumber }));
        on("roughness", (input) => ({ sigma: 10 ** input.valueAsNumber }));
        on("lights", (input) => ({ turn: input.valueAsNumber }));
        on("holes", (input) => ({ holes: input.checked }));
        on("wire", (input) => ({ wire: input.checked }));
        for (const radio of document.querySelectorAll<HTMLInputElement>("input[name=layer]"))
            radio.addEventListener("input", () => this.show({ ...this.view, layer: radio.value as View["layer"] }));
        element("controls").addEventListener("submit", (event) => event.preventDefault());
        element("controls").addEventListener("reset", (event) => {
            event.preventDefault();
            this.show({ ...this.first });
        });
        element("hemisphere-part").addEventListener("toggle", () => this.fillForm());
        // On a small screen the object comes first.
        if (matchMedia("(max-width: 560px)").matches) element<HTMLDetailsElement>("panel").open = false;
    }

    private connectButtons(): void {
        const turn = element("turn");
        turn.addEventListener("click", () => this.setTurning(!this.turning));
        const full = element("full");
        full.hidden = !document.fullscreenEnabled;
        full.addEventListener("click", () => {
            if (document.fullscreenElement) void document.exitFullscreen();
            else root.requestFullscreen().catch(() => this.say("This browser does not permit full screen here."));
        });
        document.addEventListener("fullscreenchange", () => {
            full.textContent = document.fullscreenElement ? "Leave full screen" : "Full screen";
        });
        element("link").addEventListener("click", () => {
            const link = location.href.replace(/#.*/, "") + toHash(this.view, this.first);
            navigator.clipboard
                ?.writeText(link)
                .then(() => this.say("The link to this view is in the clipboard."))
                .catch(() => this.say(link));
            if (!navigator.clipboard) this.say(link);
        });
    }

    private say(text: string): void {
        element("said").textContent = text;
    }
}

async function main(): Promise<void> {
    element("title").textContent = document.title;
    element("stage").setAttribute("aria-label", document.title);
    const model = await readModel(progress);
    await progress(0.8);
    new Page(model, readMore());
    root.dataset.state = "ready";
    root.dataset.drawn = "still";
}

main().catch((error: unknown) => {
    console.error(error);
    fail(error instanceof ModelError ? error.message : `This page could not be shown: ${String(error)}`);
});
