import { h, icon, icons } from "./dom.js";
import { Segments } from "./segments.js";
import type { Shading } from "./shading.js";

const shadingNames: readonly (readonly [Shading, string])[] = [
    ["colour", "Colour"],
    ["plain", "Plain"],
    ["normals", "Normals"],
    ["heat", "Last step"],
];

/** How a model is drawn: its shading, with edges or without, and all of it in view. */
export class ShadingBar {
    readonly element: HTMLElement;
    onShading: (shading: Shading) => void = () => {};
    onEdges: (shown: boolean) => void = () => {};
    onFit: () => void = () => {};
    private readonly edgesButton = h("button", { class: "segment", onclick: () => this.toggleEdges() }, "Edges");
    private chosen: Shading;
    private edgesShown: boolean;

    constructor(shading: Shading, edges: boolean) {
        this.chosen = shading;
        this.edgesShown = edges;
        this.edgesButton.setAttribute("aria-pressed", String(edges));
        const shadings = new Segments(shadingNames, shading, "Shading");
        shadings.onChoose = (now) => {
            this.chosen = now;
            this.onShading(now);
        };
        this.element = h(
            "div",
            { class: "toolbar" },
            shadings.element,
            h("div", { class: "segments" }, this.edgesButton),
            h("button", { class: "icon-button", title: "Fit (F)", "aria-label": "Fit the model", onclick: () => this.onFit() }, icon(icons.fit)),
        );
    }

    get shading(): Shading {
        return this.chosen;
    }
    get edges(): boolean {
        return this.edgesShown;
    }

    private toggleEdges(): void {
        this.edgesShown = !this.edgesShown;
        this.edgesButton.setAttribute("aria-pressed", String(this.edgesShown));
        this.onEdges(this.edgesShown);
    }
}
