import { h } from "./dom.js";
import { count } from "./format.js";

/** What a budget step did to a mesh. */
export interface Step {
    /** Vertices that came; below 0 those that went. */
    readonly added: number;
    /** Of those before and after it, the ones that are elsewhere now. */
    readonly moved: number;
}

/** What the colours of the heat map mean, and the step that it shows. */
export class HeatLegend {
    readonly element: HTMLElement;
    private readonly sentence = h("span", { class: "legend-step", role: "status" });

    constructor() {
        this.element = h(
            "div",
            { class: "legend", hidden: true },
            this.sentence,
            h("span", { class: "legend-scale" }, h("span", {}, "moved"), h("span", { class: "legend-ramp", "aria-hidden": "true" }), h("span", {}, "new")),
        );
        this.show(undefined);
    }

    /** @param step undefined if there was none */
    show(step: Step | undefined): void {
        const text = stepSentence(step);
        if (this.sentence.textContent !== text) this.sentence.textContent = text;
    }
}

function stepSentence(step: Step | undefined): string {
    if (!step || (step.added === 0 && step.moved === 0)) return "No step yet: choose another budget.";
    const came = step.added > 0 ? `${count(step.added)} new vertices, ` : step.added < 0 ? `${count(-step.added)} vertices gone, ` : "";
    return `Last step: ${came}${count(step.moved)} moved`;
}
