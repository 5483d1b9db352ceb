import { DecodeError } from "./decode-error.js";
import type { DracoDecoder } from "./draco.js";
import { maxColourResidual } from "./limits.js";

/** Differences of colours from their predictions in YCoCg-R, in quantiser steps. */
export interface ColourResiduals {
    /** Y, one a vertex. */
    readonly luma: Int32Array;
    /** Co and Cg of each vertex. */
    readonly chroma: Int32Array;
}

/** Of its attributes: luma, chroma. */
export const colourComponents = [1, 2] as const;

/**
 * The payload of a colour frame (proto/FORMAT.md, "Payloads").
 * @throws DecodeError if it is not a packet of exactly nVertices residuals, or one exceeds 511 in magnitude
 */
export function decodeColour(payload: Uint8Array, nVertices: number, draco: DracoDecoder): ColourResiduals {
    const decoded = draco.decodePointCloud(payload, nVertices, colourComponents);
    const [luma, chroma] = decoded as [Int32Array, Int32Array];
    for (const values of [luma, chroma]) {
        const beyond = values.find((value) => Math.abs(value) > maxColourResidual);
        if (beyond !== undefined) {
            throw new DecodeError(`colour packet: expected residuals of at most ${maxColourResidual}, got ${beyond}`);
        }
    }
    return { luma, chroma };
}
