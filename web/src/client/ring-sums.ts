import type { HalfedgeConnectivity } from "./halfedge-connectivity.js";
import { next, prev } from "./halfedge.js";

/**
 * Walks the ring of a vertex. All sums are of integers below 2^53: exact, so the ring's order does not matter.
 * @param normal gets the sum of the ring's cross products, twice the area-weighted sum of its face normals
 * @param offset gets the sum of the neighbours less the vertex
 */
export function sumRing(
    positions: Int32Array,
    { corners, twins, outgoing }: HalfedgeConnectivity,
    vertex: number,
    normal: Float64Array,
    offset: Float64Array,
): void {
    const x = positions[3 * vertex], y = positions[3 * vertex + 1], z = positions[3 * vertex + 2];
    const first = outgoing[vertex];
    const start = 3 * corners[next(first)];
    let ax = positions[start] - x, ay = positions[start + 1] - y, az = positions[start + 2] - z;
    let nx = 0, ny = 0, nz = 0;
    let sumX = 0, sumY = 0, sumZ = 0;
    let spoke = first;
    do {
        const back = prev(spoke);
        const r = 3 * corners[back];
        const bx = positions[r] - x, by = positions[r + 1] - y, bz = positions[r + 2] - z;
        nx += ay * bz - az * by;
        ny += az * bx - ax * bz;
        nz += ax * by - ay * bx;
        sumX += bx;
        sumY += by;
        sumZ += bz;
        ax = bx;
        ay = by;
        az = bz;
        spoke = twins[back];
    } while (spoke !== first);
    normal[0] = nx;
    normal[1] = ny;
    normal[2] = nz;
    offset[0] = sumX;
    offset[1] = sumY;
    offset[2] = sumZ;
}
