import { DecodeError } from "./decode-error.js";
import type { DracoDecoder } from "./draco.js";
import { maxLogVertices } from "./limits.js";
import type { SplitRecords } from "./refinable-mesh.js";

/** What the face gaps of a batch start from. */
export const noPreviousFace = -1;

const maxFaces = 4 * maxLogVertices;

/**
 * The payload of a refine frame (proto/FORMAT.md, "Payloads").
 * @param previousFace last face of the batch's packet before; noPreviousFace if the batch starts here
 * @throws DecodeError if the payload is not such a packet of exactly nSplits records
 */
export function decodeRefine(
    payload: Uint8Array,
    nSplits: number,
    previousFace: number,
    draco: DracoDecoder,
): SplitRecords {
    const [gaps, residuals, updates] = draco.decodePointCloud(payload, nSplits, [1, 3, 6]) as [
        Int32Array,
        Int32Array,
        Int32Array,
    ];
    let face = previousFace;
    const faces = gaps.map((symbol) => {
        face += unfolded(symbol) + 1;
        if (face >= maxFaces) throw new DecodeError(`refine packet: face ${face} is beyond every log`);
        return face;
    });
    return { faces, residuals, updates };
}

/** A gap is stored as the number whose zigzag code it is. */
function unfolded(symbol: number): number {
    return symbol >= 0 ? 2 * symbol : -2 * symbol - 1;
}
