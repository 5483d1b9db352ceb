// A step of refinable-mesh.ts: proto/FORMAT.md, "Metric"; each rounding is that of "Arithmetic".
// D'Azevedo and Simpson 1989, "On optimal interpolation triangle incidences"; Rusinkiewicz 2004, "Estimating
// curvatures and their derivatives on triangle meshes".

/** Part of the mean curvature that lengths count for in all directions. */
const allDirections = 0.3125;

/** Lengths in a face's plane that count for more the more the surface bends along them; made once, measured often. */
export class CurvatureMetric {
    /** An orthonormal basis of the plane. */
    private readonly u = new Float64Array(3);
    private readonly v = new Float64Array(3);
    /** The symmetric tensor in that basis. */
    private xx = 0;
    private xy = 0;
    private yy = 0;

    /**
     * Takes the metric of a face.
     * @param corners three vertices
     * @param normals their unit normals, x y z each
     * @returns whether there is one: not if the face has no area or the surface does not bend
     */
    measure(positions: Int32Array, corners: Int32Array, normals: Float64Array): boolean {
        const { u, v } = this;
        const p = 3 * corners[0];
        const q = 3 * corners[1];
        const r = 3 * corners[2];
        const firstX = positions[q] - positions[p];
        const firstY = positions[q + 1] - positions[p + 1];
        const firstZ = positions[q + 2] - positions[p + 2];
        const thirdX = positions[r] - positions[p];
        const thirdY = positions[r + 1] - positions[p + 1];
        const thirdZ = positions[r + 2] - positions[p + 2];
        const areaX = firstY * thirdZ - firstZ * thirdY;
        const areaY = firstZ * thirdX - firstX * thirdZ;
        const areaZ = firstX * thirdY - firstY * thirdX;
        const area = Math.sqrt(areaX * areaX + areaY * areaY + areaZ * areaZ);
        const base = Math.sqrt(firstX * firstX + firstY * firstY + firstZ * firstZ);
        if (!(area > 0)) return false;
        u[0] = firstX / base;
        u[1] = firstY / base;
        u[2] = firstZ / base;
        const nX = areaX / area, nY = areaY / area, nZ = areaZ / area;
        v[0] = nY * u[2] - nZ * u[1];
        v[1] = nZ * u[0] - nX * u[2];
        v[2] = nX * u[1] - nY * u[0];

        // Curvature along an edge times its squared length: how far its ends' normals turn.
        const bend = (i: number, j: number) => {
            const a = 3 * corners[i];
            const b = 3 * corners[j];
            const x = positions[b] - positions[a];
            const y = positions[b + 1] - positions[a + 1];
            const z = positions[b + 2] - positions[a + 2];
            const along = (n: number) => x * normals[n] + y * normals[n + 1] + z * normals[n + 2];
            return along(3 * i) - along(3 * j);
        };
        // a xx + 2 b xy + c yy, at the edges (base, 0), (x - base, y) and (-x, -y).
        const bend0 = bend(0, 1);
        const bend1 = bend(1, 2);
        const bend2 = bend(2, 0);
        const x = thirdX * u[0] + thirdY * u[1] + thirdZ * u[2];
        const y = area / base;
        const a = bend0 / (base * base);
        const b = (bend2 - bend1 - a * (base * (2 * x - base))) / (2 * (base * y));
        const c = (bend2 - a * (x * x) - 2 * (b * (x * y))) / (y * y);

        // The square root of the tensor's square, in closed form.
        const determinant = a * c - b * b;
        const size = determinant < 0 ? -determinant : determinant;
        const root = Math.sqrt(a * a + c * c + 2 * (b * b) + 2 * size);
        if (!(root > 0)) return false;
        const xx = (a * a + b * b + size) / root;
        const yy = (b * b + c * c + size) / root;
        const more = allDirections * ((xx + yy) * 0.5);
        this.xx = xx + more;
        this.xy = (b * (a + c)) / root;
        this.yy = yy + more;
        return true;
    }

    innerProduct(aX: number, aY: number, aZ: number, bX: number, bY: number, bZ: number): number {
        const { u, v } = this;
        const au = aX * u[0] + aY * u[1] + aZ * u[2];
        const av = aX * v[0] + aY * v[1] + aZ * v[2];
        const bu = bX * u[0] + bY * u[1] + bZ * u[2];
        const bv = bX * v[0] + bY * v[1] + bZ * v[2];
        return this.xx * (au * bu) + this.xy * (au * bv + av * bu) + this.yy * (av * bv);
    }
}
