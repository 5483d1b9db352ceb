// The operation of proto/FORMAT.md, step by step; the numbers in the comments are its headings. Formulas are written out
// component by component: each rounding is that of FORMAT.md, "Arithmetic", and nothing is allocated.
// PN triangles: Vlachos, Peters, Boyd, Mitchell, "Curved PN Triangles", 2001.
import { ChangeMarks } from "./change-marks.js";
import { CurvatureMetric } from "./curvature-metric.js";
import { DecodeError } from "./decode-error.js";
import { withRoomFor } from "./growing-array.js";
import { HalfedgeConnectivity } from "./halfedge-connectivity.js";
import type { ConnectivityState } from "./halfedge-connectivity.js";
import { next, prev } from "./halfedge.js";
import type { RefinementRules } from "./header.js";
import type { IntegerMesh } from "./integer-mesh.js";
import { sumRing } from "./ring-sums.js";
import { RollingHash } from "./rolling-hash.js";
import { UndoJournal } from "./undo-journal.js";
import { wantsFlip } from "./wants-flip.js";

/** The flip rule that wants a metric. */
const curvatureAligned = 3;
const flipMark = 0x80000000;
const newVertexSmoothing = 0.5;
/** By the header's smoothing. */
const ringVertexSmoothing = [NaN, 0.25, 0.0625];

/** Refinements in order: each splits a face and moves the three new vertices and six around it along their normals. */
export interface SplitRecords {
    /** One a split. */
    readonly faces: Int32Array;
    /** Three a split, in steps: the new vertices on edges c0c1, c1c2, c2c0. */
    readonly residuals: Int32Array;
    /** Six a split, in steps: corners c0 c1 c2, apexes a0 a1 a2. */
    readonly updates: Int32Array;
}

/** A copy of all that later splits depend on. */
export interface RefinableMeshState {
    readonly connectivity: ConnectivityState;
    readonly positions: Int32Array;
    readonly parents: Int32Array;
    readonly hash: number;
}

/**
 * A closed manifold triangle mesh on integer positions that only grows, by splits; vertex and face numbers never die.
 * Both ends of the stream compute it bit for bit. Arrays may be longer than the mesh, and are replaced when it grows.
 */
export class RefinableMesh {
    readonly connectivity: HalfedgeConnectivity;
    /** x y z of each vertex, grid units. */
    positions: Int32Array;
    /** The two ends of the edge that each vertex was put on; of the base's vertices, twice the vertex itself. */
    parents: Int32Array;
    readonly changedVertices = new ChangeMarks();

    private readonly gridSize: number;
    private readonly rules: RefinementRules;
    private readonly ringWeight: number;
    private readonly hash = new RollingHash();
    private readonly moves = new UndoJournal();
    private readonly site = new Int32Array(6);
    /** Of the vertex that measureRing() was last called with: centroid of its neighbours minus itself, unit normal. */
    private readonly centroidOffset = new Float64Array(3);
    private readonly normal = new Float64Array(3);
    /** Unit normals of three vertices. */
    private readonly normals = new Float64Array(9);
    private readonly metric = new CurvatureMetric();

    /**
     * @param base on a grid of 2^gridBits positions an axis
     * @throws DecodeError if it is not a closed consistently oriented manifold
     */
    constructor(base: IntegerMesh, gridBits: number, rules: RefinementRules) {
        const nVertices = base.positions.length / 3;
        this.connectivity = new HalfedgeConnectivity(nVertices, base.triangles);
        this.positions = base.positions.slice();
        this.parents = new Int32Array(2 * nVertices).map((_, i) => i >> 1);
        this.gridSize = 2 ** gridBits;
        this.rules = rules;
        this.ringWeight = ringVertexSmoothing[rules.smoothing];
        for (const x of base.positions) this.hash.mix(x);
        for (const v of base.triangles) this.hash.mix(v);
        this.changedVertices.reserve(nVertices);
        for (let v = 0; v < nVertices; ++v) this.changedVertices.mark(v);
    }

    get nVertices(): number {
        return this.connectivity.nVertices;
    }
    get nFaces(): number {
        return this.connectivity.nFaces;
    }
    /** Rolling hash over the base and every split, vertex write and flip since (proto/FORMAT.md, "State hash"). */
    get stateHash(): number {
        return this.hash.value;
    }

    /** Makes room for so many vertices. */
    reserve(nVertices: number): void {
        this.resize(nVertices);
        const nFaces = this.nFaces + 2 * Math.max(nVertices - this.nVertices, 0);
        this.connectivity.reserve(nVertices, nFaces);
    }

    snapshot(): RefinableMeshState {
        return {
            connectivity: this.connectivity.snapshot(),
            positions: this.positions.slice(0, 3 * this.nVertices),
            parents: this.parents.slice(0, 2 * this.nVertices),
            hash: this.hash.value,
        };
    }

    /** Goes back to an earlier state of this mesh; every vertex and face counts as changed. */
    restore(state: RefinableMeshState): void {
        this.connectivity.restore(state.connectivity);
        this.positions.set(state.positions);
        this.parents.set(state.parents);
        this.hash.value = state.hash;
        for (let v = 0; v < this.nVertices; ++v) this.changedVertices.mark(v);
    }

    /**
     * Replays record i.
     * @throws DecodeError if the face cannot be split or a vertex would leave the grid: the mesh is then as before
     */
    apply(records: SplitRecords, i: number): void {
        const { connectivity, site } = this;
        const { nVertices, nFaces } = connectivity;
        const face = records.faces[i];
        if (!connectivity.splitSite(face, site)) throw new DecodeError(`face ${face} of ${nFaces} cannot be split`);
        const hashBefore = this.hash.value;
        this.resize(nVertices + 3);
        try {
            this.refine(face, records, i);
        } catch (error) {
            this.moves.undo();
            connectivity.rollBack(nVertices, nFaces);
            this.hash.value = hashBefore;
            throw error;
        }
        this.moves.clear();
        connectivity.commit();
    }

    private refine(face: number, { residuals, updates }: SplitRecords, record: number): void {
        const { connectivity, site } = this;
        const V = connectivity.nVertices;
        const step = this.scalarStep();
        this.hash.mix(face);
        this.predict(V); // 1
        const hasMetric =
            this.rules.flipRule === curvatureAligned && this.metric.measure(this.positions, site, this.normals);
        const metric = hasMetric ? this.metric : null;
        connectivity.split(face, site); // 2
        for (let pass = 0; pass < 2; ++pass) {
            for (let i = 0; i < 3; ++i) this.flipAround(V + i, metric); // 3
        }
        for (let i = 0; i < 3; ++i) this.smooth(V + i, newVertexSmoothing); // 4

        for (let i = 0; i < 3; ++i) {
            if (residuals[3 * record + i] !== 0) this.measureNormal(V + i, i); // 5: all three before any moves
        }
        for (let i = 0; i < 3; ++i) this.move(V + i, residuals[3 * record + i], step, i);

        for (let i = 0; i < 6; ++i) {
            const update = updates[6 * record + i];
            this.smooth(site[i], this.ringWeight); // 6
            if (update !== 0) this.measureNormal(site[i], 0);
            this.move(site[i], update, step, 0);
        }
    }

    /** The step of the face's scalars, grid units (proto/FORMAT.md, "Step"). Only integers are compared. */
    private scalarStep(): number {
        const { positions, site } = this;
        const { stepRatio } = this.rules;
        let sum = 0;
        for (let i = 0; i < 3; ++i) {
            const p = 3 * site[i];
            const q = 3 * site[(i + 1) % 3];
            for (let axis = 0; axis < 3; ++axis) {
                const d = positions[q + axis] - positions[p + axis];
                sum += d * d;
            }
        }
        let step = 1;
        for (let limit = 6 * stepRatio * stepRatio; sum >= limit; limit *= 4) step *= 2;
        return step;
    }

    /** Puts vertices V, V + 1, V + 2 on the edge curves of the PN triangle of the site's corners. */
    private predict(V: number): void {
        const { positions, site, normals, parents } = this;
        for (let i = 0; i < 3; ++i) this.measureNormal(site[i], i);
        for (let i = 0; i < 3; ++i) {
            const j = (i + 1) % 3;
            const p = 3 * site[i];
            const q = 3 * site[j];
            const along = (n: number) =>
                (positions[q] - positions[p]) * normals[n] +
                (positions[q + 1] - positions[p + 1]) * normals[n + 1] +
                (positions[q + 2] - positions[p + 2]) * normals[n + 2];
            const atP = along(3 * i);
            const atQ = along(3 * j);
            const coordinate = (axis: number) =>
                this.clamped(
                    (positions[p + axis] + positions[q + axis]) * 0.5 -
                        (atP * normals[3 * i + axis] - atQ * normals[3 * j + axis]) * 0.125,
                );
            this.write(V + i, coordinate(0), coordinate(1), coordinate(2));
            parents[2 * (V + i)] = site[i];
            parents[2 * (V + i) + 1] = site[j];
        }
    }

    private flipAround(vertex: number, metric: CurvatureMetric | null): void {
        const { connectivity, positions } = this;
        const { flipRule } = this.rules;
        const first = connectivity.outgoing[vertex];
        let spoke = first;
        do {
            const link = next(spoke);
            if (wantsFlip(positions, connectivity, link, flipRule, metric)) {
                connectivity.flip(link);
                this.hash.mix(flipMark + link);
            }
            spoke = connectivity.twins[prev(spoke)];
        } while (spoke !== first);
    }

    /** Fills centroidOffset and normal. */
    private measureRing(vertex: number): void {
        const { positions, centroidOffset: d, normal: n } = this;
        sumRing(positions, this.connectivity, vertex, n, d);
        const k = this.connectivity.valences[vertex];
        for (let axis = 0; axis < 3; ++axis) {
            const at = positions[3 * vertex + axis];
            d[axis] = (d[axis] + k * at) / k - at;
        }
        if (n[0] === 0 && n[1] === 0 && n[2] === 0) {
            n[2] = 1;
            return;
        }
        const length = Math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (let axis = 0; axis < 3; ++axis) n[axis] /= length;
    }

    /** Puts the unit normal of a vertex into slot 0, 1 or 2 of `normals`. */
    private measureNormal(vertex: number, slot: number): void {
        this.measureRing(vertex);
        this.normals.set(this.normal, 3 * slot);
    }

    private smooth(vertex: number, weight: number): void {
        this.measureRing(vertex);
        const { positions, centroidOffset: d, normal: n } = this;
        const height = d[0] * n[0] + d[1] * n[1] + d[2] * n[2];
        const coordinate = (axis: number) =>
            this.clamped(positions[3 * vertex + axis] + weight * (d[axis] - height * n[axis]));
        this.write(vertex, coordinate(0), coordinate(1), coordinate(2));
    }

    /** Moves a vertex along the normal in a slot. @throws DecodeError if it would leave the grid */
    private move(vertex: number, scalar: number, step: number, slot: number): void {
        const { positions, normals, gridSize } = this;
        const p = 3 * vertex;
        if (scalar === 0) {
            this.write(vertex, positions[p], positions[p + 1], positions[p + 2]);
            return;
        }
        const distance = scalar * step;
        const x = round(positions[p] + distance * normals[3 * slot]);
        const y = round(positions[p + 1] + distance * normals[3 * slot + 1]);
        const z = round(positions[p + 2] + distance * normals[3 * slot + 2]);
        if (!(x >= 0 && x < gridSize && y >= 0 && y < gridSize && z >= 0 && z < gridSize)) {
            throw new DecodeError(`a split: expected vertex ${vertex} on the grid, the scalar ${scalar} takes it off`);
        }
        this.write(vertex, x, y, z);
    }

    /** Rounded to the grid. */
    private clamped(x: number): number {
        return Math.min(Math.max(round(x), 0), this.gridSize - 1);
    }

    private write(vertex: number, x: number, y: number, z: number): void {
        const { positions, moves, hash } = this;
        moves.set(positions, 3 * vertex, x);
        moves.set(positions, 3 * vertex + 1, y);
        moves.set(positions, 3 * vertex + 2, z);
        hash.mix(vertex);
        hash.mix(x);
        hash.mix(y);
        hash.mix(z);
        this.changedVertices.mark(vertex);
    }

    private resize(nVertices: number): void {
        if (3 * nVertices > this.positions.length) this.moves.release();
        this.positions = withRoomFor(3 * nVertices, this.positions);
        this.parents = withRoomFor(2 * nVertices, this.parents);
        this.changedVertices.reserve(nVertices);
    }
}

/** The nearest integer, halves up. */
function round(x: number): number {
    return Math.floor(x + 0.5);
}
