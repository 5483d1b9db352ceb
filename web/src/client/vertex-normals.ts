import { ChangeMarks } from "./change-marks.js";
import type { Range } from "./change-marks.js";
import type { MeshChanges, ProgressiveMesh } from "./progressive-mesh.js";

const scale = 32767;
/** A normal that need not be computed costs less than a range of its own. */
const mergedGap = 2;

/**
 * Area-weighted normals of a mesh's vertices, for drawing, kept up to date with it. They are sums over the one-ring as
 * in proto/FORMAT.md, "Normal", but the mesh does not depend on them.
 */
export class VertexNormals {
    /** x y z 0 of each vertex as 16-bit fractions of 32767; may be longer than the mesh, is replaced when it grows. */
    values = new Int16Array(0);

    /** What has changed, and whose normals are not marked yet. */
    private readonly changedFaces: Range[] = [];
    private readonly changedVertices: Range[] = [];
    private readonly stale = new ChangeMarks();
    private readonly staleRanges: Range[] = [];
    private readonly fresh = new ChangeMarks();
    /** Vertices from the first that have a normal, if not always the latest. */
    private nComputed = 0;

    /** Notes what changed in the mesh since the last note. */
    note(mesh: ProgressiveMesh, changes: MeshChanges): void {
        const nChanged = changes.vertices.reduce((sum, { count }) => sum + count, 0);
        if (2 * nChanged > mesh.nVertices) {
            this.stale.markRange({ first: 0, count: mesh.nVertices }); // rings of so many hold nearly all
            return;
        }
        for (const range of changes.faces) this.changedFaces.push(range);
        for (const range of changes.vertices) this.changedVertices.push(range);
    }

    /**
     * Finds and computes some of the normals that are out of date.
     * @param most  how many, about
     * @returns whether all are up to date now
     */
    update(mesh: ProgressiveMesh, most: number): boolean {
        const left = this.markStale(mesh, most);
        if (left === 0) return false;
        for (const range of this.stale.take(mesh.nVertices, mergedGap)) this.staleRanges.push(range);
        this.reserve(mesh.nVertices);
        takeSome(this.staleRanges, left, mesh.nVertices, (range) => this.compute(mesh, range));
        if (this.staleRanges.length > 0) return false;
        this.nComputed = Math.max(this.nComputed, mesh.nVertices);
        return true;
    }

    /** Computes the normals of vertices that never had one: what is drawn next cannot do without. */
    updateNew(mesh: ProgressiveMesh): void {
        const first = this.nComputed;
        if (first >= mesh.nVertices) return;
        this.reserve(mesh.nVertices);
        this.compute(mesh, { first, count: mesh.nVertices - first });
        this.nComputed = mesh.nVertices;
    }

    /** Vertices whose normal was computed since the last call. */
    takeChanges(nVertices: number, mergedGap: number): Range[] {
        return this.fresh.take(nVertices, mergedGap);
    }

    /** Marks the normals that some of the changes concern. @returns how many of `most` are left; 0 if there may be more */
    private markStale(mesh: ProgressiveMesh, most: number): number {
        const { triangles } = mesh;
        this.stale.reserve(mesh.nVertices);
        // The faces that have a moved vertex are found through its ring; a changed face has its corners.
        const left = takeSome(this.changedFaces, most, mesh.nFaces, ({ first, count }) => {
            for (let h = 3 * first; h < 3 * (first + count); ++h) this.stale.mark(triangles[h]);
        });
        return takeSome(this.changedVertices, left, mesh.nVertices, ({ first, count }) => {
            for (let v = first; v < first + count; ++v) {
                this.stale.mark(v);
                mesh.forEachNeighbour(v, this.markOne);
            }
        });
    }

    private readonly markOne = (vertex: number): void => this.stale.mark(vertex);

    private compute(mesh: ProgressiveMesh, range: Range): void {
        const { values } = this;
        const sum = new Float64Array(3);
        for (let v = range.first; v < range.first + range.count; ++v) {
            mesh.ringNormal(v, sum);
            const length = Math.sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
            const factor = length > 0 ? scale / length : 0;
            for (let axis = 0; axis < 3; ++axis) values[4 * v + axis] = Math.round(sum[axis] * factor);
        }
        this.fresh.markRange(range);
    }

    /** Makes room for so many vertices. */
    reserve(nVertices: number): void {
        if (4 * nVertices <= this.values.length) return;
        const larger = new Int16Array(Math.max(4 * nVertices, 2 * this.values.length));
        larger.set(this.values);
        this.values = larger;
    }
}

/**
 * Takes elements out of a list of ranges, from its end, and visits them.
 * @param n elements that exist: ranges may tell of more, which a step back has undone
 * @returns how many of `most` are left
 */
function takeSome(ranges: Range[], most: number, n: number, visit: (range: Range) => void): number {
    let left = most;
    while (left > 0 && ranges.length > 0) {
        const { first, count } = ranges.pop()!;
        const existing = Math.min(count, n - first);
        if (existing <= 0) continue;
        const now = Math.min(existing, left);
        visit({ first, count: now });
        if (now < existing) ranges.push({ first: first + now, count: existing - now });
        left -= now;
    }
    return left;
}
