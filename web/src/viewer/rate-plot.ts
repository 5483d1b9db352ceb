import type { IndexRow } from "../client/index.js";
import { svg } from "./dom.js";
import { bytes, count, significant } from "./format.js";

export type RateAxis = "vertices" | "bytes";

/** A point of a model's rate-distortion curve. */
interface RatePoint {
    readonly vertices: number;
    readonly bytes: number;
    readonly distortion: number;
}

const [width, height] = [328, 172];
const margin = { left: 38, right: 12, top: 12, bottom: 26 };

/** The rate-distortion curve of a model: click it, or use the arrow keys, to go to a point. */
export class RatePlot {
    readonly element: SVGSVGElement;
    onChoose: (vertices: number) => void = () => {};
    private readonly drawing = svg("g");
    private readonly marker = svg("g", { class: "marker" });
    private points: RatePoint[] = [];
    private axis: RateAxis = "vertices";
    private current = 0;

    constructor() {
        this.element = svg("svg", {
            class: "rate-plot",
            viewBox: `0 0 ${width} ${height}`,
            tabindex: 0,
            role: "slider",
            "aria-label": "Rate-distortion curve",
            onclick: (event) => this.choose(event as MouseEvent),
            onkeydown: (event) => this.onKey(event as KeyboardEvent),
        });
        this.element.append(this.drawing, this.marker);
    }

    get isEmpty(): boolean {
        return this.points.length < 2;
    }

    setRows(rows: readonly IndexRow[], framesBegin: number): void {
        this.points = pointsOf(rows, framesBegin);
        this.draw();
    }

    setAxis(axis: RateAxis): void {
        this.axis = axis;
        this.draw();
    }

    /** Moves the point to a mesh of so many vertices. */
    setCurrent(vertices: number): void {
        if (vertices === this.current) return;
        this.current = vertices;
        this.drawMarker();
    }

    private draw(): void {
        this.drawing.replaceChildren();
        if (this.isEmpty) {
            this.marker.replaceChildren();
            return;
        }
        const path = this.points.map((point) => `${this.x(point[this.axis]).toFixed(1)},${this.y(point.distortion).toFixed(1)}`);
        const bottom = height - margin.bottom;
        const area = `M${path[0].split(",")[0]},${bottom} L${path.join(" L")} L${path.at(-1)!.split(",")[0]},${bottom} Z`;
        this.drawing.append(...this.grid(), svg("path", { class: "area", d: area }), svg("path", { class: "curve", d: `M${path.join(" L")}` }));
        for (const point of this.points) {
            this.drawing.append(svg("circle", { class: "dot", cx: this.x(point[this.axis]), cy: this.y(point.distortion), r: 2 }));
        }
        this.drawMarker();
    }

    private grid(): Node[] {
        const [low, high] = this.rangeY();
        const nodes: Node[] = [];
        for (const share of [0, 0.5, 1]) {
            const value = low + share * (high - low);
            const y = this.y(value);
            nodes.push(svg("line", { class: "grid", x1: margin.left, x2: width - margin.right, y1: y, y2: y }));
            nodes.push(svg("text", { class: "tick", x: margin.left - 6, y: y + 3.5, "text-anchor": "end" }, significant(value)));
        }
        const [first, last] = [this.points[0][this.axis], this.points.at(-1)![this.axis]];
        const text = this.axis === "bytes" ? bytes : count;
        const middle = Math.sqrt(first * last);
        for (const [value, anchor] of [[first, "start"], [middle, "middle"], [last, "end"]] as const) {
            const label = value === middle && this.axis === "vertices" ? count(Number(middle.toPrecision(2))) : text(value);
            nodes.push(svg("text", { class: "tick", x: this.x(value), y: height - 8, "text-anchor": anchor }, label));
        }
        return nodes;
    }

    private drawMarker(): void {
        this.marker.replaceChildren();
        if (this.isEmpty) return;
        const point = this.at(this.current);
        const [x, y] = [this.x(point[this.axis]), this.y(point.distortion)];
        this.marker.append(
            svg("line", { class: "drop", x1: x, x2: x, y1: y, y2: height - margin.bottom }),
            svg("circle", { class: "halo", cx: x, cy: y, r: 9 }),
            svg("circle", { class: "point", cx: x, cy: y, r: 4.5 }),
        );
        this.element.setAttribute("aria-valuenow", String(point.vertices));
        this.element.setAttribute("aria-valuetext", `${count(point.vertices)} vertices, distortion ${significant(point.distortion)}`);
    }

    /** On the line between two frames, for a budget that ends inside of one. */
    private at(vertices: number): RatePoint {
        const i = this.points.findIndex((point) => point.vertices >= vertices);
        if (i < 0) return this.points.at(-1)!;
        if (i === 0) return this.points[0];
        const [a, b] = [this.points[i - 1], this.points[i]];
        const share = (vertices - a.vertices) / (b.vertices - a.vertices);
        const between = (p: number, q: number) => p + share * (q - p);
        return { vertices, bytes: between(a.bytes, b.bytes), distortion: between(a.distortion, b.distortion) };
    }

    private choose(event: MouseEvent): void {
        const box = this.element.getBoundingClientRect();
        const x = ((event.clientX - box.left) / box.width) * width;
        if (!this.isEmpty) this.onChoose(this.verticesAt(x));
    }

    private verticesAt(x: number): number {
        const share = Math.min(Math.max((x - margin.left) / (width - margin.left - margin.right), 0), 1);
        const [first, last] = [this.points[0], this.points.at(-1)!];
        const value = first[this.axis] * (last[this.axis] / first[this.axis]) ** share;
        if (this.axis === "vertices") return Math.round(value);
        const i = this.points.findIndex((point) => point.bytes >= value);
        if (i <= 0) return (i === 0 ? first : last).vertices;
        const [a, b] = [this.points[i - 1], this.points[i]];
        return Math.round(a.vertices + ((value - a.bytes) / (b.bytes - a.bytes)) * (b.vertices - a.vertices));
    }

    private onKey(event: KeyboardEvent): void {
        const i = this.points.findIndex((point) => point.vertices >= this.current);
        const at = i < 0 ? this.points.length - 1 : i;
        const next = { ArrowRight: at + 1, ArrowUp: at + 1, ArrowLeft: at - 1, ArrowDown: at - 1 }[event.key];
        if (next === undefined) return;
        event.preventDefault();
        this.onChoose(this.points[Math.min(Math.max(next, 0), this.points.length - 1)].vertices);
    }

    private rangeY(): [number, number] {
        const values = this.points.map(({ distortion }) => distortion);
        const [low, high] = [Math.min(...values), Math.max(...values)];
        return [low - 0.06 * (high - low), high];
    }

    private x(value: number): number {
        const [first, last] = [this.points[0][this.axis], this.points.at(-1)![this.axis]];
        const share = last > first ? Math.log(value / first) / Math.log(last / first) : 0;
        return margin.left + share * (width - margin.left - margin.right);
    }

    private y(value: number): number {
        const [low, high] = this.rangeY();
        const share = high > low ? (value - low) / (high - low) : 0.5;
        return height - margin.bottom - share * (height - margin.top - margin.bottom);
    }
}

/** One point a number of vertices: of the last frame that has it. */
function pointsOf(rows: readonly IndexRow[], framesBegin: number): RatePoint[] {
    const byVertices = new Map<number, RatePoint>();
    for (const { nVertices, end, meanDistortion } of rows) {
        if (!Number.isFinite(meanDistortion)) continue;
        byVertices.set(nVertices, { vertices: nVertices, bytes: framesBegin + end, distortion: meanDistortion });
    }
    return [...byVertices.values()];
}
