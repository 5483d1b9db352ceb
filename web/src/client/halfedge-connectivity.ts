// Who touches whom in the refinement state, without positions: proto/FORMAT.md, "State", "Split" and "Flip".
import { checkCorners, checkFans, matchTwins } from "./base-topology.js";
import { ChangeMarks } from "./change-marks.js";
import { withRoomFor } from "./growing-array.js";
import { next, prev } from "./halfedge.js";
import { maxLogVertices, maxValence } from "./limits.js";
import { UndoJournal } from "./undo-journal.js";

/** A copy of a connectivity's arrays. */
export interface ConnectivityState {
    readonly nVertices: number;
    readonly nFaces: number;
    readonly corners: Int32Array;
    readonly twins: Int32Array;
    readonly outgoing: Int32Array;
    readonly valences: Int32Array;
}

/**
 * A closed, oriented, manifold triangle mesh as typed arrays. They are open to be read by the kernels of RefinableMesh;
 * written they are here only. They may be longer than the mesh, and are replaced by larger ones when it grows.
 * Every change is atomic for the caller that ends it by commit() or rollBack().
 */
export class HalfedgeConnectivity {
    nVertices: number;
    nFaces: number;
    /** The vertex that each half-edge starts from: three corners a face, so also the triangles. */
    corners: Int32Array;
    /** The opposite of each half-edge. */
    twins: Int32Array;
    /** A half-edge that leaves each vertex: where a walk around it starts. */
    outgoing: Int32Array;
    /** Edges at each vertex. */
    valences: Int32Array;
    readonly changedFaces = new ChangeMarks();

    private readonly journal = new UndoJournal();
    private readonly inner = new Int32Array(3);
    private readonly outer = new Int32Array(3);

    /**
     * @param triangles three vertices of each face
     * @throws DecodeError unless they form closed, consistently oriented, manifold fans of valence >= 3 around each of
     *         the nVertices vertices
     */
    constructor(nVertices: number, triangles: Int32Array) {
        checkCorners(nVertices, triangles);
        this.nVertices = nVertices;
        this.nFaces = triangles.length / 3;
        this.corners = triangles.slice();
        this.twins = matchTwins(nVertices, this.corners);
        this.outgoing = new Int32Array(nVertices);
        this.valences = new Int32Array(nVertices);
        for (let h = this.corners.length - 1; h >= 0; --h) {
            this.outgoing[this.corners[h]] = h;
            ++this.valences[this.corners[h]];
        }
        checkFans(this.twins, this.outgoing, this.valences);
        this.changedFaces.reserve(this.nFaces);
        for (let f = 0; f < this.nFaces; ++f) this.changedFaces.mark(f);
    }

    /**
     * Puts the corners c0 c1 c2 and apexes a0 a1 a2 of a face into `site`.
     * @returns false if the face cannot be split (proto/FORMAT.md, "Splittable")
     */
    splitSite(face: number, site: Int32Array): boolean {
        if (face >= this.nFaces || this.nVertices + 3 > maxLogVertices) return false;
        for (let i = 0; i < 3; ++i) {
            const h = 3 * face + i;
            site[i] = this.corners[h];
            site[3 + i] = this.corners[prev(this.twins[h])];
        }
        for (let i = 0; i < 6; ++i) {
            if (this.valences[site[i]] >= maxValence) return false;
            for (let j = 0; j < i; ++j) {
                if (site[i] === site[j]) return false;
            }
        }
        return true;
    }

    /** Splits a face that has this splitSite(): adds three vertices and six faces. */
    split(face: number, site: Int32Array): void {
        const V = this.nVertices;
        const F = this.nFaces;
        this.resize(V + 3, F + 6);
        const { inner, outer, outgoing, twins } = this; // inner and outer are t_i and o_i of FORMAT.md
        for (let i = 0; i < 3; ++i) {
            inner[i] = twins[3 * face + i];
            outer[i] = twins[next(inner[i])];
        }
        for (let i = 0; i < 3; ++i) {
            const c = site[i];
            const a = site[3 + i];
            const t = inner[i];
            const m = V + i;
            const mBefore = V + ((i + 2) % 3);
            const corner = 3 * (F + i);
            const nextCorner = 3 * (F + ((i + 1) % 3));
            const half = 3 * (F + 3 + i);
            this.setFace(corner, c, m, mBefore);
            this.setFace(half, m, c, a);
            this.setOrigin(3 * face + i, m);
            this.setOrigin(next(t), m);

            this.link(3 * face + i, nextCorner + 1);
            this.link(corner, half);
            this.link(t, nextCorner + 2);
            this.link(half + 1, outer[i]);
            this.link(half + 2, next(t));

            this.journal.set(outgoing, m, 3 * face + i);
            this.journal.set(outgoing, c, corner);
            this.journal.set(this.valences, m, 5);
            this.addValence(a, 1);
        }
    }

    /** Whether the connectivity allows to replace the edge of h by the one between the two opposite corners. */
    canFlip(h: number): boolean {
        const { corners, twins, valences } = this;
        const t = twins[h];
        const m = corners[prev(h)];
        const s = corners[prev(t)];
        return (
            valences[corners[h]] >= 4 &&
            valences[corners[t]] >= 4 &&
            valences[m] < maxValence &&
            valences[s] < maxValence &&
            m !== s &&
            !this.areNeighbours(m, s)
        );
    }

    flip(h: number): void {
        const { corners, twins, outgoing } = this;
        const t = twins[h];
        const hNext = next(h);
        const tNext = next(t);
        const p = corners[h];
        const q = corners[t];
        const m = corners[prev(h)];
        const s = corners[prev(t)];
        const beyondPs = twins[tNext];
        const beyondQm = twins[hNext];

        this.setOrigin(hNext, s); // face of h: m p s
        this.setOrigin(tNext, m); // face of t: s q m
        this.link(h, beyondPs);
        this.link(t, beyondQm);
        this.link(hNext, tNext);

        this.journal.set(outgoing, p, h);
        this.journal.set(outgoing, q, t);
        this.addValence(p, -1);
        this.addValence(q, -1);
        this.addValence(m, 1);
        this.addValence(s, 1);
    }

    snapshot(): ConnectivityState {
        const { nVertices, nFaces } = this;
        return {
            nVertices,
            nFaces,
            corners: this.corners.slice(0, 3 * nFaces),
            twins: this.twins.slice(0, 3 * nFaces),
            outgoing: this.outgoing.slice(0, nVertices),
            valences: this.valences.slice(0, nVertices),
        };
    }

    /** Goes back to a state of fewer vertices and faces; every face counts as changed. */
    restore(state: ConnectivityState): void {
        this.nVertices = state.nVertices;
        this.nFaces = state.nFaces;
        this.corners.set(state.corners);
        this.twins.set(state.twins);
        this.outgoing.set(state.outgoing);
        this.valences.set(state.valences);
        for (let f = 0; f < this.nFaces; ++f) this.changedFaces.mark(f);
    }

    commit(): void {
        this.journal.clear();
    }

    /** Undoes everything since the last commit, back to so many vertices and faces. */
    rollBack(nVertices: number, nFaces: number): void {
        this.journal.undo();
        this.nVertices = nVertices;
        this.nFaces = nFaces;
    }

    private areNeighbours(a: number, b: number): boolean {
        const { corners, twins, outgoing } = this;
        const first = outgoing[a];
        let spoke = first;
        do {
            const back = prev(spoke);
            if (corners[back] === b) return true; // the target of the next spoke
            spoke = twins[back];
        } while (spoke !== first);
        return false;
    }

    /** Makes room for so many vertices and faces, so that growing to them copies nothing more. */
    reserve(nVertices: number, nFaces: number): void {
        // All arrays grow before the first journalled write: the journal keeps the arrays.
        if (3 * nFaces > this.corners.length || nVertices > this.valences.length) this.journal.release();
        this.corners = withRoomFor(3 * nFaces, this.corners);
        this.twins = withRoomFor(3 * nFaces, this.twins);
        this.outgoing = withRoomFor(nVertices, this.outgoing);
        this.valences = withRoomFor(nVertices, this.valences);
        this.changedFaces.reserve(nFaces);
    }

    private resize(nVertices: number, nFaces: number): void {
        this.reserve(nVertices, nFaces);
        this.nVertices = nVertices;
        this.nFaces = nFaces;
    }

    private setFace(h: number, a: number, b: number, c: number): void {
        this.setOrigin(h, a);
        this.setOrigin(h + 1, b);
        this.setOrigin(h + 2, c);
    }

    private setOrigin(h: number, vertex: number): void {
        this.journal.set(this.corners, h, vertex);
        this.changedFaces.mark(Math.floor(h / 3));
    }

    private link(h: number, t: number): void {
        this.journal.set(this.twins, h, t);
        this.journal.set(this.twins, t, h);
    }

    private addValence(vertex: number, change: number): void {
        this.journal.set(this.valences, vertex, this.valences[vertex] + change);
    }
}
