import type { Model } from "../client/index.js";
import { h } from "./dom.js";
import { draco } from "./draco.js";
import { bytes, count, hex32, milliseconds } from "./format.js";

const names = [
    ["vertices", "Vertices"],
    ["faces", "Faces"],
    ["received", "Received"],
    ["frames", "Log frames"],
    ["decode", "Decoding"],
    ["replay", "Replay"],
    ["fps", "Drawn / s"],
    ["hash", "State hash"],
] as const;

type Statistic = (typeof names)[number][0];

/** What a model has cost so far, and what there is for it. */
export class StatisticsPanel {
    readonly element: HTMLElement;
    private readonly values = new Map<Statistic, HTMLElement>();
    /** Milliseconds that Draco had taken for other models. */
    private readonly dracoBefore = draco().milliseconds;

    constructor() {
        const items = names.map(([name, label]) => {
            const value = h("dd", { "data-statistic": name }, "–");
            this.values.set(name, value);
            return h("div", {}, h("dt", {}, label), value);
        });
        this.element = h("section", { class: "panel", "aria-label": "Statistics" }, h("dl", { class: "statistics" }, ...items));
    }

    /** @param framesPerSecond undefined where nothing is drawn */
    update(model: Model | undefined, framesPerSecond: number | undefined): void {
        this.set("fps", framesPerSecond === undefined ? "–" : String(Math.round(framesPerSecond)));
        const mesh = model?.mesh;
        if (!mesh) return;
        this.set("vertices", count(mesh.nVertices));
        this.set("faces", count(mesh.nFaces));
        this.set("received", bytes(model.nBytes));
        this.set("frames", count(model.nFrames));
        this.set("decode", milliseconds(draco().milliseconds - this.dracoBefore));
        this.set("replay", milliseconds(model.replayMilliseconds));
        this.set("hash", hex32(mesh.stateHash));
    }

    private set(name: Statistic, text: string): void {
        const value = this.values.get(name)!;
        if (value.textContent !== text) value.textContent = text;
    }
}
