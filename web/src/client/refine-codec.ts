import { DecodeError } from "./decode-error.js";
import type { DracoDecoder } from "./draco.js";
import type { SplitRecords } from "./refinable-mesh.js";

/** What the face gaps of a batch start from. */
export const noPreviousFace = -1;

const facesPerSplit = 6;
/** Of its attributes: face gaps, residuals, updates. */
export const refineComponents = [1, 3, 6] as const;

/**
 * The payload of a refine frame (proto/FORMAT.md, "Payloads").
 * @param previousFace last face of the packet before; noPreviousFace if a batch starts here
 * @param nFaces of the mesh before the first record
 * @throws DecodeError if the payload is not such a packet of exactly nSplits records of faces that are there at their turn
 */
export function decodeRefine(
    payload: Uint8Array,
    nSplits: number,
    previousFace: number,
    nFaces: number,
    draco: DracoDecoder,
): SplitRecords {
    const [gaps, residuals, updates] = draco.decodePointCloud(payload, nSplits, refineComponents) as [
        Int32Array,
        Int32Array,
        Int32Array,
    ];
    let face = previousFace;
    const faces = gaps.map((symbol, i) => {
        const nFacesNow = nFaces + facesPerSplit * i;
        face += unfolded(symbol) + 1;
        if (face >= nFacesNow) face -= nFacesNow; // the next batch starts inside the packet
        if (face >= nFacesNow) {
            throw new DecodeError(`refine packet: record ${i} names a face beyond the ${nFacesNow} that are there`);
        }
        return face;
    });
    return { faces, residuals, updates };
}

/** A gap is stored as the number whose zigzag code it is. */
function unfolded(symbol: number): number {
    return symbol >= 0 ? 2 * symbol : -2 * symbol - 1;
}
