import { DecodeError } from "./decode-error.js";
import type { DracoDecoder } from "./draco.js";
import type { Header } from "./header.js";
import type { IntegerMesh } from "./integer-mesh.js";
import { maxBaseFacesPerByte, maxBaseVerticesPerByte } from "./limits.js";

/**
 * The coarse mesh of a base frame, in grid units (proto/FORMAT.md, "Payloads"). Whether it is closed is for
 * RefinableMesh to check.
 * @throws DecodeError if it has not the counts of the header, or leaves the grid
 */
export function decodeBase(payload: Uint8Array, header: Header, draco: DracoDecoder): IntegerMesh {
    const { nBaseVertices, nBaseFaces, grid } = header;
    checkBaseSize(payload, header);
    const base = draco.decodeMesh(payload, nBaseVertices, nBaseFaces);
    const limit = 2 ** (grid.bits - grid.baseShift);
    const positions = base.positions.map((x, i) => {
        if (x < 0 || x >= limit) {
            throw new DecodeError(`base vertex ${Math.floor(i / 3)}: expected 0 to ${limit - 1}, got ${x}`);
        }
        return x << grid.baseShift;
    });
    return { positions, triangles: base.triangles };
}

/** @throws DecodeError if the header promises more than so few bytes can hold */
export function checkBaseSize(payload: Uint8Array, { nBaseVertices, nBaseFaces }: Header): void {
    const nBytes = payload.length;
    if (nBaseVertices > maxBaseVerticesPerByte * nBytes || nBaseFaces > maxBaseFacesPerByte * nBytes) {
        throw new DecodeError(`base: ${nBytes} bytes cannot hold ${nBaseVertices} vertices and ${nBaseFaces} faces`);
    }
}
