import type { HalfedgeConnectivity } from "./halfedge-connectivity.js";
import { next, prev } from "./halfedge.js";

/** Puts the sum of the cross products of a vertex's ring into `sum`, for whoever draws the mesh. */
export function sumRingNormal(
    positions: Int32Array,
    { corners, twins, outgoing }: HalfedgeConnectivity,
    vertex: number,
    sum: Float64Array,
): void {
    const x = positions[3 * vertex], y = positions[3 * vertex + 1], z = positions[3 * vertex + 2];
    const first = outgoing[vertex];
    const start = 3 * corners[next(first)];
    let ax = positions[start] - x, ay = positions[start + 1] - y, az = positions[start + 2] - z;
    let nx = 0, ny = 0, nz = 0;
    let spoke = first;
    do {
        const back = prev(spoke);
        const r = 3 * corners[back];
        const bx = positions[r] - x, by = positions[r + 1] - y, bz = positions[r + 2] - z;
        nx += ay * bz - az * by;
        ny += az * bx - ax * bz;
        nz += ax * by - ay * bx;
        ax = bx;
        ay = by;
        az = bz;
        spoke = twins[back];
    } while (spoke !== first);
    sum[0] = nx;
    sum[1] = ny;
    sum[2] = nz;
}
