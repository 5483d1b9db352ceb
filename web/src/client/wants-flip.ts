// A step of refinable-mesh.ts: proto/FORMAT.md, "3. Flip"; each rounding is that of "Arithmetic".
import type { CurvatureMetric } from "./curvature-metric.js";
import type { HalfedgeConnectivity } from "./halfedge-connectivity.js";
import { prev } from "./halfedge.js";

/** Rules 2 and 3: edges between faces at more than 14 degrees stay, those between needles (270 degrees) from 36 on. */
const delaunay = 1;
const coplanarCosine = 0.96875;
const needleCosine = 0.8125;
const needleCotangents = 2;

/**
 * Whether the edge of h, from p to q between the corners m and s, gives way to one between m and s.
 * @param metric of the face that is being split, if the rule wants one and there is one
 */
export function wantsFlip(
    positions: Int32Array,
    connectivity: HalfedgeConnectivity,
    h: number,
    flipRule: number,
    metric: CurvatureMetric | null,
): boolean {
    const { corners, twins } = connectivity;
    const t = twins[h];
    const p = 3 * corners[h];
    const q = 3 * corners[t];
    const m = 3 * corners[prev(h)];
    const s = 3 * corners[prev(t)];
    const px = positions[p], py = positions[p + 1], pz = positions[p + 2];
    const qx = positions[q], qy = positions[q + 1], qz = positions[q + 2];
    const mx = positions[m], my = positions[m + 1], mz = positions[m + 2];
    const sx = positions[s], sy = positions[s + 1], sz = positions[s + 2];

    const dotM = (px - mx) * (qx - mx) + (py - my) * (qy - my) + (pz - mz) * (qz - mz);
    const dotS = (px - sx) * (qx - sx) + (py - sy) * (qy - sy) + (pz - sz) * (qz - sz);
    if (!metric && dotM >= 0 && dotS >= 0) return false; // no angle above 90 degrees: the sum cannot be negative

    // a = cross(p - m, q - m), b = cross(p - s, q - s): normals of the two faces, b turned away
    const ax = (py - my) * (qz - mz) - (pz - mz) * (qy - my);
    const ay = (pz - mz) * (qx - mx) - (px - mx) * (qz - mz);
    const az = (px - mx) * (qy - my) - (py - my) * (qx - mx);
    const bx = (py - sy) * (qz - sz) - (pz - sz) * (qy - sy);
    const by = (pz - sz) * (qx - sx) - (px - sx) * (qz - sz);
    const bz = (px - sx) * (qy - sy) - (py - sy) * (qx - sx);
    const sineM = Math.sqrt(ax * ax + ay * ay + az * az);
    const sineS = Math.sqrt(bx * bx + by * by + bz * bz);
    const cotangents = dotM * sineS + dotS * sineM; // cot m + cot s, times the sines
    if (flipRule === delaunay) {
        if (!(cotangents < 0)) return false;
    } else {
        // cross(q - p, m - p) is a, cross(p - q, s - q) is -b: all of them sums of exact integers.
        const sines = sineM * sineS;
        const areNeedles = cotangents < -needleCotangents * sines;
        if (!(-(ax * bx + ay * by + az * bz) >= (areNeedles ? needleCosine : coplanarCosine) * sines)) return false;
        const sum =
            areNeedles || !metric
                ? cotangents
                : metric.innerProduct(px - mx, py - my, pz - mz, qx - mx, qy - my, qz - mz) * sineS +
                  metric.innerProduct(px - sx, py - sy, pz - sz, qx - sx, qy - sy, qz - sz) * sineM;
        if (!(sum < 0)) return false;
    }

    // N = cross(q - p, m - p) + cross(p - q, s - q)
    const nx = ax - bx, ny = ay - by, nz = az - bz;
    // cross(p - m, s - m) and cross(q - s, m - s): normals of the two faces that the flip would make
    const cx = (py - my) * (sz - mz) - (pz - mz) * (sy - my);
    const cy = (pz - mz) * (sx - mx) - (px - mx) * (sz - mz);
    const cz = (px - mx) * (sy - my) - (py - my) * (sx - mx);
    const dx = (qy - sy) * (mz - sz) - (qz - sz) * (my - sy);
    const dy = (qz - sz) * (mx - sx) - (qx - sx) * (mz - sz);
    const dz = (qx - sx) * (my - sy) - (qy - sy) * (mx - sx);
    return cx * nx + cy * ny + cz * nz > 0 && dx * nx + dy * ny + dz * nz > 0 && connectivity.canFlip(h);
}
