import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Sphere, Vector3 } from "three";

import type { Model, ModelChanges, ProgressiveMesh, Range } from "../client/index.js";

/** Of what is drawn: one number a vertex and attribute component. */
interface Buffers {
    readonly position: BufferAttribute;
    readonly positionFrom: BufferAttribute;
    readonly normal: BufferAttribute;
    /** r g b, and in the fourth byte how much the last budget step changed the vertex. */
    readonly tint: BufferAttribute;
    readonly faces: BufferAttribute;
}

/**
 * A progressive mesh on the graphics card: takes what changed, and lets the surface go from its last shape to the new
 * one (Hoppe's geomorph). Positions are in grid units, exact in 32-bit floats. A new vertex starts at the middle of the
 * edge that it was put on, so that nothing pops.
 */
export class MorphGeometry {
    readonly geometry = new BufferGeometry();
    private buffers: Buffers | undefined;
    private nVertices = 0;
    private nFaces = 0;
    /** Positions before the last budget step, for the heat map. */
    private stepFrom: Int32Array = new Int32Array(0);

    get vertexCount(): number {
        return this.nVertices;
    }

    /** Whatever was there belongs to another log. */
    clear(): void {
        this.nVertices = this.nFaces = 0;
        this.stepFrom = new Int32Array(0);
        this.geometry.setDrawRange(0, 0);
    }

    /**
     * Takes what changed.
     * @param progress how far the last morph has come, 0 to 1: the new one starts from there
     */
    update(model: Model, changes: ModelChanges, progress: number): void {
        const mesh = model.mesh!;
        const known = Math.min(this.nVertices, mesh.nVertices);
        const buffers = this.reserved(mesh);
        settleFrom(buffers, known, progress);
        copyPositions(mesh, buffers.position, changes.vertices);
        copyNormals(model.normals, buffers.normal, changes.normals);
        copyColours(mesh, buffers.tint, changes.colours);
        copyFaces(mesh, buffers.faces, changes.faces);
        startAtParents(mesh, buffers, known);
        this.nVertices = mesh.nVertices;
        this.nFaces = mesh.nFaces;
        this.geometry.setDrawRange(0, 3 * this.nFaces);
    }

    /** Remembers the shape from which the heat map of the next step is measured. */
    beginStep(mesh: ProgressiveMesh): void {
        this.stepFrom = mesh.positions.slice();
    }

    /** Fills the heat of every vertex: how far it moved since beginStep(), new ones full. */
    measureHeat(mesh: ProgressiveMesh): void {
        if (!this.buffers) return;
        const { array } = this.buffers.tint;
        const { positions } = mesh;
        const moved = new Float32Array(mesh.nVertices);
        let most = 1;
        const nBefore = Math.min(this.stepFrom.length / 3, mesh.nVertices);
        for (let v = 0; v < nBefore; ++v) {
            let sum = 0;
            for (let i = 3 * v; i < 3 * v + 3; ++i) sum += (positions[i] - this.stepFrom[i]) ** 2;
            moved[v] = Math.sqrt(sum);
            if (moved[v] > most) most = moved[v];
        }
        for (let v = 0; v < mesh.nVertices; ++v) {
            array[4 * v + 3] = v < nBefore ? Math.round(200 * Math.sqrt(moved[v] / most)) : 255;
        }
        uploadAll(this.buffers.tint, 4 * mesh.nVertices);
    }

    /** An index of the edges, each once. */
    edges(mesh: ProgressiveMesh): Uint32Array {
        const { triangles } = mesh;
        const edges = new Uint32Array(triangles.length);
        let n = 0;
        for (let h = 0; h < triangles.length; ++h) {
            const [a, b] = [triangles[h], triangles[h % 3 === 2 ? h - 2 : h + 1]];
            if (a > b) continue;
            edges[n++] = a;
            edges[n++] = b;
        }
        return edges.subarray(0, n);
    }

    dispose(): void {
        this.geometry.dispose();
    }

    private reserved(mesh: ProgressiveMesh): Buffers {
        const old = this.buffers;
        if (old && old.position.count >= mesh.nVertices && old.faces.count >= 3 * mesh.nFaces) return old;
        const nVertices = Math.ceil(1.5 * mesh.nVertices);
        const nCorners = Math.ceil(1.5 * 3 * mesh.nFaces);
        const grown = <T extends Float32Array | Int16Array | Uint8Array | Uint32Array>(
            array: T,
            before: BufferAttribute | undefined,
            size: number,
            normalized = false,
        ): BufferAttribute => {
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
        };
        this.geometry.dispose();
        const { position, positionFrom, normal, tint, faces } = this.buffers;
        this.geometry.setAttribute("position", position);
        this.geometry.setAttribute("positionFrom", positionFrom);
        this.geometry.setAttribute("normal", normal);
        this.geometry.setAttribute("tint", tint);
        this.geometry.setIndex(faces);
        this.geometry.boundingSphere = new Sphere(new Vector3(), Infinity); // one object, always in view
        return this.buffers;
    }
}

/** Puts the start of the next morph where the surface is drawn now. */
function settleFrom({ position, positionFrom }: Buffers, nVertices: number, progress: number): void {
    const [to, from] = [position.array, positionFrom.array];
    if (progress >= 1) {
        from.set(to.subarray(0, 3 * nVertices) as never);
    } else {
        for (let i = 0; i < 3 * nVertices; ++i) from[i] += progress * (to[i] - from[i]);
    }
}

/** Vertices are in the order in which they came, so the ends of a new vertex's edge are placed before it. */
function startAtParents(mesh: ProgressiveMesh, { positionFrom }: Buffers, known: number): void {
    const from = positionFrom.array;
    const { parents, nVertices } = mesh;
    for (let v = known; v < nVertices; ++v) {
        const [p, q] = [3 * parents[2 * v], 3 * parents[2 * v + 1]];
        for (let axis = 0; axis < 3; ++axis) {
            from[3 * v + axis] = p === 3 * v ? mesh.positions[p + axis] : 0.5 * (from[p + axis] + from[q + axis]);
        }
    }
    uploadAll(positionFrom, 3 * nVertices);
}

function copyPositions({ positions }: ProgressiveMesh, position: BufferAttribute, ranges: readonly Range[]): void {
    for (const { first, count } of ranges) {
        position.array.set(positions.subarray(3 * first, 3 * (first + count)) as never, 3 * first);
        position.addUpdateRange(3 * first, 3 * count);
    }
    position.needsUpdate = true;
}

function copyNormals(normals: Int16Array, normal: BufferAttribute, ranges: readonly Range[]): void {
    for (const { first, count } of ranges) {
        normal.array.set(normals.subarray(4 * first, 4 * (first + count)) as never, 4 * first);
        normal.addUpdateRange(4 * first, 4 * count);
    }
    normal.needsUpdate = true;
}

function copyColours(mesh: ProgressiveMesh, tint: BufferAttribute, ranges: readonly Range[]): void {
    const { colours } = mesh;
    for (const { first, count } of ranges) {
        for (let v = first; v < first + count; ++v) {
            for (let channel = 0; channel < 3; ++channel) tint.array[4 * v + channel] = colours[3 * v + channel];
        }
        tint.addUpdateRange(4 * first, 4 * count);
    }
    tint.needsUpdate = true;
}

function copyFaces(mesh: ProgressiveMesh, faces: BufferAttribute, ranges: readonly Range[]): void {
    const { triangles } = mesh;
    for (const { first, count } of ranges) {
        faces.array.set(triangles.subarray(3 * first, 3 * (first + count)) as never, 3 * first);
        faces.addUpdateRange(3 * first, 3 * count);
    }
    faces.needsUpdate = true;
}

function uploadAll(attribute: BufferAttribute, n: number): void {
    attribute.clearUpdateRanges();
    attribute.addUpdateRange(0, n);
    attribute.needsUpdate = true;
}
