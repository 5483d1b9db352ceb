import { ChangeMarks } from "./change-marks.js";
import type { Range } from "./change-marks.js";
import type { MeshChanges, ProgressiveMesh } from "./progressive-mesh.js";

const scale = 32767;

/**
 * Area-weighted normals of a mesh's vertices, for drawing, kept up to date with it. They are sums over the one-ring as
 * in proto/FORMAT.md, "Normal", but the mesh does not depend on them.
 */
export class VertexNormals {
    /** x y z 0 of each vertex as 16-bit fractions of 32767; may be longer than the mesh, is replaced when it grows. */
    values = new Int16Array(0);

    private readonly stale = new ChangeMarks();
    private readonly fresh = new ChangeMarks();
    private ranges: Range[] = [];
    /** Vertices from the first that have a normal, if not always the latest. */
    private nComputed = 0;

    /** Notes what changed in the mesh since the last note; what was noted before is up to date. */
    note(mesh: ProgressiveMesh, changes: MeshChanges): void {
        this.stale.reserve(mesh.nVertices);
        const nChanged = changes.vertices.reduce((sum, { count }) => sum + count, 0);
        if (2 * nChanged > mesh.nVertices) {
            this.stale.markRange({ first: 0, count: mesh.nVertices }); // rings of so many hold nearly all
            return;
        }
        // The faces that have a moved vertex are found through its ring; a changed face has its corners.
        const { triangles } = mesh;
        for (const { first, count } of changes.faces) {
            for (let h = 3 * first; h < 3 * (first + count); ++h) this.stale.mark(triangles[h]);
        }
        for (const { first, count } of changes.vertices) {
            for (let v = first; v < first + count; ++v) {
                this.stale.mark(v);
                mesh.forEachNeighbour(v, (neighbour) => this.stale.mark(neighbour));
            }
        }
    }

    /**
     * Computes some of the normals that are out of date.
     * @param most  how many, about
     * @returns whether all are up to date now
     */
    update(mesh: ProgressiveMesh, most: number): boolean {
        this.ranges.push(...this.stale.take(mesh.nVertices, 0));
        this.reserve(mesh.nVertices);
        for (let left = most; left > 0 && this.ranges.length > 0; ) {
            const { first, count } = this.ranges.pop()!;
            const now = Math.min(count, left);
            this.compute(mesh, { first, count: now });
            if (now < count) this.ranges.push({ first: first + now, count: count - now });
            left -= now;
        }
        if (this.ranges.length > 0) return false;
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
