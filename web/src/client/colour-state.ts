// The colours of a log and how they are predicted: proto/FORMAT.md, "Colours". The colour space is YCoCg-R (Malvar and
// Sullivan, "YCoCg-R: A Color Space with RGB Reversibility and Low Dynamic Range", 2003).
import type { ColourResiduals } from "./colour-codec.js";
import { prev } from "./halfedge.js";
import type { ColourSteps } from "./header.js";
import type { RefinableMesh } from "./refinable-mesh.js";
import { RollingHash } from "./rolling-hash.js";

const grey = 128;

/** A copy of the colours of a mesh and their hash. */
export interface ColourSnapshot {
    readonly colours: Uint8Array;
    readonly hash: number;
}

/** One 8-bit RGB triple a vertex, the same at both ends of the stream. */
export class ColourState {
    /** r g b of each vertex; may be longer than the mesh, and is replaced when it grows. */
    colours: Uint8Array;

    private readonly steps: ColourSteps;
    private readonly rolling = new RollingHash();

    /** The vertices of a base without colours are grey. */
    constructor(steps: ColourSteps, nBaseVertices: number) {
        this.steps = steps;
        this.colours = new Uint8Array(3 * nBaseVertices).fill(grey);
    }

    /** Rolling hash over all corrected colours. */
    get hash(): number {
        return this.rolling.value;
    }

    snapshot(nVertices: number): ColourSnapshot {
        return { colours: this.colours.slice(0, 3 * nVertices), hash: this.rolling.value };
    }

    /** Goes back to a state of fewer vertices. */
    restore({ colours, hash }: ColourSnapshot): void {
        this.colours.set(colours);
        this.rolling.value = hash;
    }

    /** The vertices of the base, each at the rounded mean of its lower-numbered neighbours, then corrected. */
    correctBase(base: RefinableMesh, residuals: ColourResiduals): void {
        const { corners, twins, outgoing, nVertices } = base.connectivity;
        for (let v = 0; v < nVertices; ++v) {
            let k = 0;
            let r = 0;
            let g = 0;
            let b = 0;
            let spoke = outgoing[v];
            do {
                const back = prev(spoke);
                const neighbour = corners[back];
                if (neighbour < v) {
                    ++k;
                    r += this.colours[3 * neighbour];
                    g += this.colours[3 * neighbour + 1];
                    b += this.colours[3 * neighbour + 2];
                }
                spoke = twins[back];
            } while (spoke !== outgoing[v]);
            const mean = (sum: number) => (k === 0 ? grey : Math.floor((sum + (k >> 1)) / k));
            this.write(v, mean(r), mean(g), mean(b));
            this.correct(v, residuals, v);
        }
    }

    /** Puts vertices first .. end - 1 at the mean of their edge's ends. */
    predict(first: number, end: number, parents: Int32Array): void {
        this.reserve(end);
        const { colours } = this;
        for (let v = first; v < end; ++v) {
            const p = 3 * parents[2 * v];
            const q = 3 * parents[2 * v + 1];
            for (let channel = 0; channel < 3; ++channel) {
                colours[3 * v + channel] = (colours[p + channel] + colours[q + channel] + 1) >> 1;
            }
        }
    }

    /** Predicts vertices first .. end - 1 anew, in order, and corrects each by its residual, from firstResidual on. */
    predictAndCorrect(
        first: number,
        end: number,
        parents: Int32Array,
        residuals: ColourResiduals,
        firstResidual: number,
    ): void {
        for (let v = first; v < end; ++v) {
            this.predict(v, v + 1, parents);
            this.correct(v, residuals, firstResidual + v - first);
        }
    }

    /** Takes a predicted colour to the corrected one. */
    private correct(vertex: number, { luma, chroma }: ColourResiduals, residual: number): void {
        const { colours, steps } = this;
        const red = colours[3 * vertex];
        const blue = colours[3 * vertex + 2];
        let co = red - blue;
        let t = blue + (co >> 1);
        let cg = colours[3 * vertex + 1] - t;
        const y = t + (cg >> 1) + luma[residual] * steps.luma;
        co += chroma[2 * residual] * steps.chroma;
        cg += chroma[2 * residual + 1] * steps.chroma;
        t = y - (cg >> 1);
        const newBlue = t - (co >> 1);
        this.write(vertex, clamped(newBlue + co), clamped(cg + t), clamped(newBlue));
        this.rolling.mix(vertex);
        this.rolling.mix(colours[3 * vertex] | (colours[3 * vertex + 1] << 8) | (colours[3 * vertex + 2] << 16));
    }

    private write(vertex: number, r: number, g: number, b: number): void {
        this.colours[3 * vertex] = r;
        this.colours[3 * vertex + 1] = g;
        this.colours[3 * vertex + 2] = b;
    }

    /** Makes room for so many vertices. */
    reserve(nVertices: number): void {
        if (3 * nVertices <= this.colours.length) return;
        const larger = new Uint8Array(Math.max(3 * nVertices, 2 * this.colours.length));
        larger.set(this.colours);
        this.colours = larger;
    }
}

function clamped(channel: number): number {
    return Math.min(Math.max(channel, 0), 255);
}
