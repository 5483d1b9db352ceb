import type { Budget, IndexRow } from "../client/index.js";
import { amountOf, budgetOf, budgetScale, kindOf, nextValue, sliderSteps, stepOf, valueAt } from "./budget-scale.js";
import type { BudgetKind, BudgetScale } from "./budget-scale.js";
import { h } from "./dom.js";
import { bytes, count, significant } from "./format.js";
import { Segments } from "./segments.js";

const kinds: readonly (readonly [BudgetKind, string])[] = [
    ["vertices", "Vertices"],
    ["bytes", "Bytes"],
    ["distortion", "Distortion"],
];

/** How much of a model is wanted: a slider and a number, by vertices, bytes or distortion. */
export class BudgetPanel {
    readonly element: HTMLElement;
    onBudget: (budget: Budget) => void = () => {};

    private readonly slider = h("input", {
        type: "range",
        min: 0,
        max: sliderSteps,
        value: 0,
        class: "budget-slider",
        "aria-label": "Budget",
        oninput: () => this.fromSlider(),
        onkeydown: (event) => this.onKey(event as KeyboardEvent),
    });
    private readonly number = h("input", { type: "number", class: "budget-number", "aria-label": "Budget as a number", onchange: () => this.fromNumber() });
    private readonly unit = h("span", { class: "budget-unit" });
    private readonly ends = [h("span"), h("span")] as const;
    private kind: BudgetKind = "vertices";
    private readonly kindChoice = new Segments(kinds, this.kind);
    private rows: readonly IndexRow[] = [];
    private framesBegin = 0;
    private scale: BudgetScale | undefined;
    private current: Budget | undefined;

    constructor() {
        this.kindChoice.onChoose = (kind) => this.setKind(kind);
        this.element = h(
            "section",
            { class: "panel budget", "aria-label": "Budget" },
            this.kindChoice.element,
            h("div", { class: "budget-line" }, this.number, this.unit),
            this.slider,
            h("div", { class: "budget-ends" }, ...this.ends),
        );
    }

    setRows(rows: readonly IndexRow[], framesBegin: number): void {
        this.rows = rows;
        this.framesBegin = framesBegin;
        for (const [kind] of kinds) this.kindChoice.setEnabled(kind, budgetScale(kind, rows, framesBegin) !== undefined);
        this.rescale();
    }

    /** Shows a budget that was asked for elsewhere. */
    show(budget: Budget): void {
        this.current = budget;
        this.kind = kindOf(budget);
        this.kindChoice.press(this.kind);
        this.rescale();
    }

    private setKind(kind: BudgetKind): void {
        const before = this.current && this.verticesOf(this.current);
        this.kind = kind;
        this.current = undefined;
        this.rescale();
        if (before !== undefined) this.write(this.valueFor(before));
    }

    private rescale(): void {
        this.scale = budgetScale(this.kind, this.rows, this.framesBegin);
        this.slider.disabled = this.number.disabled = !this.scale;
        if (!this.scale) return;
        this.unit.textContent = { vertices: "vertices", bytes: "bytes", distortion: "Ψ" }[this.kind];
        const text = { vertices: count, bytes, distortion: significant }[this.kind];
        this.ends[0].textContent = text(this.scale.coarsest);
        this.ends[1].textContent = text(this.scale.finest);
        this.number.step = this.kind === "distortion" ? "any" : "1";
        if (this.current && kindOf(this.current) === this.kind) this.write(amountOf(this.current));
    }

    private write(value: number): void {
        if (!this.scale) return;
        if (document.activeElement !== this.number) this.number.value = String(value);
        this.slider.value = String(stepOf(this.scale, value));
        this.slider.style.setProperty("--share", `${(100 * Number(this.slider.value)) / sliderSteps}%`);
        this.slider.setAttribute("aria-valuetext", `${this.number.value} ${this.unit.textContent}`);
    }

    private fromSlider(): void {
        if (this.scale) this.choose(valueAt(this.scale, Number(this.slider.value)));
    }

    /** Arrow keys reach every budget there is, which steps of the slider do not. */
    private onKey(event: KeyboardEvent): void {
        const direction = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
        if (direction === undefined || !this.scale) return;
        event.preventDefault();
        const value = this.current && kindOf(this.current) === this.kind ? amountOf(this.current) : valueAt(this.scale, Number(this.slider.value));
        this.choose(nextValue(this.scale, this.rows, this.framesBegin, value, direction));
    }

    private fromNumber(): void {
        const value = Number(this.number.value);
        if (Number.isFinite(value) && value > 0) this.choose(value);
    }

    private choose(value: number): void {
        this.current = budgetOf(this.kind, value);
        this.write(value);
        this.onBudget(this.current);
    }

    private valueFor(vertices: number): number {
        const row = this.rows.find(({ nVertices }) => nVertices >= vertices) ?? this.rows.at(-1);
        if (!row || this.kind === "vertices") return vertices;
        return this.kind === "bytes" ? this.framesBegin + row.end : Number(row.meanDistortion.toPrecision(4));
    }

    private verticesOf(budget: Budget): number {
        if ("vertices" in budget) return budget.vertices;
        const isEnough = (row: IndexRow) =>
            "bytes" in budget ? this.framesBegin + row.end >= budget.bytes : row.meanDistortion <= budget.distortion;
        return (this.rows.find(isEnough) ?? this.rows.at(-1))?.nVertices ?? 0;
    }
}
