import type { IntegerMesh } from "./integer-mesh.js";

/**
 * The seam to Draco: stock bytes in, integers out. What comes back has exactly the layout that was asked for, no
 * integer exceeds 2^25 in magnitude, and whatever Draco throws or reports leaves as DecodeError.
 */
export interface DracoDecoder {
    /**
     * A sequential point cloud of int32 attributes.
     * @param nComponents what each attribute must have, in order
     * @returns one array per attribute, point by point
     */
    decodePointCloud(bytes: Uint8Array, nPoints: number, nComponents: readonly number[]): Int32Array[];

    /** An edgebreaker mesh with int32 positions, numbered as Draco numbers it. */
    decodeMesh(bytes: Uint8Array, nVertices: number, nFaces: number): IntegerMesh;
}
