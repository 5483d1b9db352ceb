import type { IndexRow } from "../client/index.js";
import { h } from "./dom.js";
import { RatePlot } from "./rate-plot.js";
import type { RateAxis } from "./rate-plot.js";
import { Segments } from "./segments.js";

const axisNames: readonly (readonly [RateAxis, string])[] = [
    ["vertices", "Vertices"],
    ["bytes", "Bytes"],
];

/** The rate-distortion curve with the choice of its axis; hidden while a model has no curve. */
export class RatePanel {
    readonly element: HTMLElement;
    onChoose: (vertices: number) => void = () => {};
    private readonly plot = new RatePlot();

    constructor() {
        this.plot.onChoose = (vertices) => this.onChoose(vertices);
        const axes = new Segments(axisNames, "vertices");
        axes.element.classList.add("small");
        axes.onChoose = (axis) => this.plot.setAxis(axis);
        this.element = h(
            "section",
            { class: "panel plot", "aria-label": "Rate and distortion", hidden: true },
            h("div", { class: "panel-head" }, h("h2", {}, "Distortion Ψ by"), axes.element),
            this.plot.element,
            h("p", { class: "hint" }, "How far the photographs disagree where they see the same surface; lower is better. Click to go there."),
        );
    }

    setRows(rows: readonly IndexRow[], framesBegin: number): void {
        this.plot.setRows(rows, framesBegin);
        this.element.hidden = this.plot.isEmpty;
    }

    /** Moves the point to a mesh of so many vertices. */
    setCurrent(vertices: number): void {
        this.plot.setCurrent(vertices);
    }
}
