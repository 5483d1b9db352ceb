import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Sphere, Vector3 } from "three";

import type { Model, ModelChanges, ProgressiveMesh, Range } from "../client/index.js";
import type { Step } from "./heat-legend.js";

type Numbers = Float32Array | Int16Array | Uint8Array | Uint32Array;

/** Room for more vertices than there are, so that a growing mesh does not move at every step; so many times at first. */
const firstRoom = 1.5;
/** Later for all that the log has, but for no more than so many times as many as there are. */
const mostRoom = 8;

/** Of what is drawn: one number a vertex and attribute component. */
interface Buffers {
    readonly position: BufferAttribute;
    readonly positionFrom: BufferAttribute;
    readonly normal: BufferAttribute;
    /** r g b, and in the fourth byte how much the last budget step changed the vertex. */
    readonly tint: BufferAttribute;
    readonly faces: BufferAttribute;
    /** Two ends for each halfedge: of the edge if its start is the smaller vertex, else of nothing; once edges are shown. */
    edges: BufferAttribute | undefined;
}

/**
 * A progressive mesh on the graphics card: takes what changed, and lets the surface go from its last shape to the new
 * one (Hoppe's geomorph). Positions are in grid units, exact in 32-bit floats. A new vertex starts at the middle of the
 * edge that it was put on, so that nothing pops.
 */
export class MorphGeometry {
    readonly geometry = new BufferGeometry();
    /** Of the edges, as pairs of vertices; see showEdges(). */
    readonly edgeGeometry = new BufferGeometry();
    private buffers: Buffers | undefined;
    private nVertices = 0;
    private nFaces = 0;
    private hasEdges = false;
    /** Vertices that the current morph moves. */
    private moving: readonly Range[] = [];
    /** Positions before the last budget step, for the heat map. */
    private stepFrom: Int32Array = new Int32Array(0);

    get vertexCount(): number {
        return this.nVertices;
    }

    /** Whatever was there belongs to another log. */
    clear(): void {
        this.nVertices = this.nFaces = 0;
        this.moving = [];
        this.stepFrom = new Int32Array(0);
        this.geometry.setDrawRange(0, 0);
        this.edgeGeometry.setDrawRange(0, 0);
    }

    /**
     * Takes what changed.
     * @param progress how far the last morph has come, 0 to 1: the new one starts from there
     */
    update(model: Model, changes: ModelChanges, progress: number): void {
        const mesh = model.mesh!;
        const known = Math.min(this.nVertices, mesh.nVertices);
        const buffers = this.reserved(mesh, model.rows.at(-1)?.nVertices ?? 0);
        const moved = within(mesh.nVertices, this.moving);
        settleFrom(buffers, moved, progress);
        copyPositions(mesh, buffers.position, changes.vertices);
        copyNormals(model.normals, buffers.normal, changes.normals);
        copyColours(mesh, buffers.tint, changes.colours);
        copyFaces(mesh, buffers.faces, changes.faces);
        if (this.hasEdges && buffers.edges) copyEdges(mesh.triangles, buffers.edges, changes.faces);
        startAtParents(mesh, buffers, known);
        const touched = merged([...moved, ...changes.vertices]);
        uploadRanges(buffers.positionFrom, touched);
        this.moving = progress < 1 ? touched : changes.vertices;
        this.nVertices = mesh.nVertices;
        this.nFaces = mesh.nFaces;
        this.geometry.setDrawRange(0, 3 * this.nFaces);
        this.edgeGeometry.setDrawRange(0, 6 * this.nFaces);
    }

    /** Keeps the edges up to date from now on, or no longer. */
    showEdges(shown: boolean): void {
        if (shown && !this.hasEdges && this.buffers) this.copyAllEdges(this.buffers);
        this.hasEdges = shown;
    }

    /** Remembers the shape from which the heat map of the next step is measured. */
    beginStep(mesh: ProgressiveMesh): void {
        this.stepFrom = mesh.positions.slice();
    }

    /** Fills the heat of every vertex: how far it moved since beginStep(), new ones full. @returns what the step did */
    measureHeat(mesh: ProgressiveMesh): Step | undefined {
        if (!this.buffers || this.stepFrom.length === 0) return undefined;
        const { array } = this.buffers.tint;
        const { positions } = mesh;
        const moved = new Float32Array(mesh.nVertices);
        let most = 1;
        let nMoved = 0;
        const nBefore = Math.min(this.stepFrom.length / 3, mesh.nVertices);
        for (let v = 0; v < nBefore; ++v) {
            let sum = 0;
            for (let i = 3 * v; i < 3 * v + 3; ++i) sum += (positions[i] - this.stepFrom[i]) ** 2;
            moved[v] = Math.sqrt(sum);
            if (sum > 0) ++nMoved;
            if (moved[v] > most) most = moved[v];
        }
        for (let v = 0; v < mesh.nVertices; ++v) {
            array[4 * v + 3] = v < nBefore ? Math.round(200 * Math.sqrt(moved[v] / most)) : 255;
        }
        uploadAll(this.buffers.tint, 4 * mesh.nVertices);
        return { added: mesh.nVertices - this.stepFrom.length / 3, moved: nMoved };
    }

    dispose(): void {
        this.geometry.dispose();
        this.edgeGeometry.dispose();
    }

    /** @param nInLog vertices that the log has in the end, if it is known */
    private reserved(mesh: ProgressiveMesh, nInLog: number): Buffers {
        const old = this.buffers;
        if (old && old.position.count >= mesh.nVertices && old.faces.count >= 3 * mesh.nFaces) return old;
        const room = old ? Math.min(Math.max(nInLog / mesh.nVertices, firstRoom), mostRoom) : firstRoom;
        const nVertices = Math.ceil(room * mesh.nVertices);
        const nCorners = Math.ceil(room * 3 * mesh.nFaces);
        const grown = (array: Numbers, before: BufferAttribute | undefined, size: number, normalized = false): BufferAttribute => {
            if (before) array.set(before.array as never);
            const attribute = new BufferAttribute(array, size, normalized);
            attribute.setUsage(DynamicDrawUsage);
            return attribute;
        };
        this.buffers = {
            position: grown(new Float32Array(3 * nVertices), old?.position, 3),
            positionFrom: grown(new Float32Array(3 * nVertices), old?.positionFrom, 3),
            normal: grown(new Int16Array(4 * nVertices), old?.normal, 4, true),
            tint: grown(new Uint8Array(4 * nVertices), old?.tint, 4, true),
            faces: grown(new Uint32Array(nCorners), old?.faces, 1),
            edges: undefined,
        };
        const { position, positionFrom, normal, tint, faces } = this.buffers;
        for (const geometry of [this.geometry, this.edgeGeometry]) {
            geometry.dispose();
            geometry.setAttribute("position", position);
            geometry.setAttribute("positionFrom", positionFrom);
            geometry.setAttribute("normal", normal);
            geometry.setAttribute("tint", tint);
            geometry.boundingSphere = new Sphere(new Vector3(), Infinity); // one object, always in view
        }
        this.geometry.setIndex(faces);
        this.edgeGeometry.setIndex(null);
        if (this.hasEdges) this.copyAllEdges(this.buffers);
        return this.buffers;
    }

    /** Those of the faces that are there. */
    private copyAllEdges(buffers: Buffers): void {
        const { array } = buffers.faces;
        buffers.edges ??= new BufferAttribute(new Uint32Array(2 * array.length), 1).setUsage(DynamicDrawUsage);
        copyEdges(array, buffers.edges, [{ first: 0, count: this.nFaces }]);
        this.edgeGeometry.setIndex(buffers.edges);
    }
}

/** Puts the start of the next morph where the surface is drawn now. */
function settleFrom({ position, positionFrom }: Buffers, moving: readonly Range[], progress: number): void {
    const [to, from] = [position.array as Float32Array, positionFrom.array as Float32Array];
    for (const { first, count } of moving) {
        const end = 3 * (first + count);
        if (progress >= 1) from.set(to.subarray(3 * first, end), 3 * first);
        else for (let i = 3 * first; i < end; ++i) from[i] += progress * (to[i] - from[i]);
    }
}

/** Vertices are in the order in which they came, so the ends of a new vertex's edge are placed before it. */
function startAtParents(mesh: ProgressiveMesh, { positionFrom }: Buffers, known: number): void {
    const from = positionFrom.array as Float32Array;
    const { parents, nVertices, positions } = mesh;
    for (let v = known; v < nVertices; ++v) {
        const p = 3 * parents[2 * v];
        const q = 3 * parents[2 * v + 1];
        const isOfBase = p === 3 * v;
        for (let axis = 0; axis < 3; ++axis) {
            from[3 * v + axis] = isOfBase ? positions[p + axis] : 0.5 * (from[p + axis] + from[q + axis]);
        }
    }
}

function copyPositions({ positions }: ProgressiveMesh, position: BufferAttribute, ranges: readonly Range[]): void {
    for (const { first, count } of ranges) {
        position.array.set(positions.subarray(3 * first, 3 * (first + count)) as never, 3 * first);
        changed(position, 3 * first, 3 * count);
    }
}

function copyNormals(normals: Int16Array, normal: BufferAttribute, ranges: readonly Range[]): void {
    for (const { first, count } of ranges) {
        normal.array.set(normals.subarray(4 * first, 4 * (first + count)) as never, 4 * first);
        changed(normal, 4 * first, 4 * count);
    }
}

function copyColours(mesh: ProgressiveMesh, tint: BufferAttribute, ranges: readonly Range[]): void {
    const { colours } = mesh;
    const into = tint.array as Uint8Array;
    for (const { first, count } of ranges) {
        for (let v = first; v < first + count; ++v) {
            into[4 * v] = colours[3 * v];
            into[4 * v + 1] = colours[3 * v + 1];
            into[4 * v + 2] = colours[3 * v + 2];
        }
        changed(tint, 4 * first, 4 * count);
    }
}

function copyFaces(mesh: ProgressiveMesh, faces: BufferAttribute, ranges: readonly Range[]): void {
    const { triangles } = mesh;
    for (const { first, count } of ranges) {
        faces.array.set(triangles.subarray(3 * first, 3 * (first + count)) as never, 3 * first);
        changed(faces, 3 * first, 3 * count);
    }
}

function copyEdges(triangles: ArrayLike<number>, edges: BufferAttribute, ranges: readonly Range[]): void {
    const { array } = edges;
    for (const { first, count } of ranges) {
        for (let h = 3 * first; h < 3 * (first + count); ++h) {
            const [a, b] = [triangles[h], triangles[h % 3 === 2 ? h - 2 : h + 1]];
            array[2 * h] = a;
            array[2 * h + 1] = a < b ? b : a;
        }
        changed(edges, 6 * first, 6 * count);
    }
}

function uploadRanges(attribute: BufferAttribute, vertices: readonly Range[]): void {
    for (const { first, count } of vertices) changed(attribute, attribute.itemSize * first, attribute.itemSize * count);
}

/** What of the ranges is below n. */
function within(n: number, ranges: readonly Range[]): Range[] {
    return ranges.filter(({ first }) => first < n).map(({ first, count }) => ({ first, count: Math.min(count, n - first) }));
}

/** Ascending and apart from each other. */
function merged(ranges: Range[]): Range[] {
    const result: Range[] = [];
    for (const { first, count } of ranges.sort((a, b) => a.first - b.first)) {
        const last = result.at(-1);
        if (last && first <= last.first + last.count) {
            const end = Math.max(last.first + last.count, first + count);
            result[result.length - 1] = { first: last.first, count: end - last.first };
        } else {
            result.push({ first, count });
        }
    }
    return result;
}

/** Nobody draws a page that is not seen, and then its ranges stay: rather all than too many. */
const mostRanges = 2000;

/** Notes numbers of an attribute that the graphics card lacks. */
function changed(attribute: BufferAttribute, first: number, n: number): void {
    if (attribute.updateRanges.length > mostRanges) {
        attribute.clearUpdateRanges();
        attribute.addUpdateRange(0, attribute.array.length);
    } else {
        attribute.addUpdateRange(first, n);
    }
    attribute.needsUpdate = true;
}

function uploadAll(attribute: BufferAttribute, n: number): void {
    attribute.clearUpdateRanges();
    changed(attribute, 0, n);
}
