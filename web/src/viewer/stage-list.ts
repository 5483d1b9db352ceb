import type { ModelInfo } from "./api.js";
import { h } from "./dom.js";

const stages = [
    ["load", "Load"],
    ["hull", "Hull"],
    ["poisson", "Surface"],
    ["remesh", "Remesh"],
    ["optimise", "Optimise"],
    ["refine", "Refine"],
    ["seal", "Seal"],
] as const;

/** The stages of a reconstruction and how far the current one has come. */
export class StageList {
    readonly element = h("ol", { class: "stages", "aria-label": "Stages of the reconstruction" });
    private readonly items = stages.map(([, label]) => {
        const bar = h("span", { class: "bar" }, h("span", { class: "fill" }));
        return { item: h("li", {}, bar, h("span", { class: "label" }, label)), fill: bar.firstElementChild as HTMLElement };
    });

    constructor() {
        this.element.append(...this.items.map(({ item }) => item));
    }

    update({ state, stage, fraction }: ModelInfo): void {
        const current = stages.findIndex(([name]) => name === stage);
        this.items.forEach(({ item, fill }, i) => {
            const share = state === "done" || i < current ? 1 : i === current && state === "running" ? fraction : 0;
            item.classList.toggle("done", share === 1);
            item.classList.toggle("current", i === current && state === "running");
            fill.style.width = `${100 * share}%`;
        });
    }
}

/** In words: "Refining, 40 %". */
export function stateSentence({ state, stage, fraction }: ModelInfo): string {
    if (state !== "running") return { queued: "Waiting for its turn", done: "Done", failed: "Failed", cancelled: "Cancelled" }[state];
    const label = stages.find(([name]) => name === stage)?.[1] ?? "Starting";
    return `${label} ${Math.round(100 * fraction)} %`;
}
