// Checks that the base is what every later operation relies on: closed, consistently oriented, manifold, valences >= 3
// (proto/FORMAT.md, "State").
import { DecodeError } from "./decode-error.js";
import { next, prev } from "./halfedge.js";

/** @throws DecodeError unless every corner is one of nVertices vertices, and the three of a face differ */
export function checkCorners(nVertices: number, corners: Int32Array): void {
    for (let h = 0; h < corners.length; ++h) {
        const v = corners[h];
        const face = Math.floor(h / 3);
        if (v < 0 || v >= nVertices) throw new DecodeError(`base face ${face}: vertex ${v} of only ${nVertices}`);
        if (v === corners[next(h)]) throw new DecodeError(`base face ${face}: expected three different corners`);
    }
}

/**
 * The opposite of every half-edge, in time proportional to their number.
 * @throws DecodeError unless each directed edge occurs once and its reverse once
 */
export function matchTwins(nVertices: number, corners: Int32Array): Int32Array {
    const lower = corners.map((v, h) => Math.min(v, corners[next(h)]));
    const upper = corners.map((v, h) => Math.max(v, corners[next(h)]));
    // Sorted by both ends, the half-edges along one edge stand side by side.
    const byUpper = sortedBy(upper, nVertices, corners.keys());
    const sorted = sortedBy(lower, nVertices, byUpper);

    const twins = new Int32Array(corners.length);
    for (let i = 0; i < sorted.length; i += 2) {
        const [h, t] = [sorted[i], sorted[i + 1]];
        const alongSameEdge = (other: number | undefined) =>
            other !== undefined && lower[other] === lower[h] && upper[other] === upper[h];
        const edge = `edge ${corners[h]} -> ${corners[next(h)]}`;
        if (!alongSameEdge(t)) {
            throw new DecodeError(`base: ${edge} has no face on its other side; expected a closed mesh`);
        }
        if (corners[h] === corners[t] || alongSameEdge(sorted[i + 2])) {
            throw new DecodeError(
                `base: ${edge} occurs in two faces of one side; expected a consistently oriented manifold`,
            );
        }
        twins[h] = t;
        twins[t] = h;
    }
    return twins;
}

/** @throws DecodeError unless the faces at every vertex form one fan of at least three */
export function checkFans(twins: Int32Array, outgoing: Int32Array, valences: Int32Array): void {
    for (let v = 0; v < outgoing.length; ++v) {
        if (valences[v] < 3) {
            throw new DecodeError(`base vertex ${v}: expected at least three edges, got ${valences[v]}`);
        }
        let walked = 0;
        let h = outgoing[v];
        do {
            ++walked;
            h = twins[prev(h)];
        } while (h !== outgoing[v]);
        if (walked !== valences[v]) {
            throw new DecodeError(`base vertex ${v}: its faces form more than one fan; expected a manifold`);
        }
    }
}

/** Stable counting sort of half-edges by a key below nKeys. */
function sortedBy(keys: Int32Array, nKeys: number, halfedges: Iterable<number>): Int32Array {
    const begin = new Int32Array(nKeys + 1);
    for (const key of keys) ++begin[key + 1];
    for (let key = 0; key < nKeys; ++key) begin[key + 1] += begin[key];
    const sorted = new Int32Array(keys.length);
    for (const h of halfedges) sorted[begin[keys[h]]++] = h;
    return sorted;
}
