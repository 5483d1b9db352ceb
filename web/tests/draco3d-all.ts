// The whole of draco3d, for tests: its package brings no types.
// @ts-expect-error no types
import draco3d from "draco3d";

const module = await draco3d.createDecoderModule({});

/** What a reader of GLB files finds in a Draco string. */
export interface DecodedGeometry {
    readonly nVertices: number;
    readonly triangles: Uint32Array;
    /** The three floats of each vertex. */
    readonly vectors: ReadonlyMap<string, Float32Array>;
}

/** @param ids number of each attribute by its name, as KHR_draco_mesh_compression lists them */
export function decodeGeometry(bytes: Uint8Array, ids: Readonly<Record<string, number>>): DecodedGeometry {
    const decoder = new module.Decoder();
    const mesh = new module.Mesh();
    const status = decoder.DecodeArrayToMesh(bytes, bytes.length, mesh);
    if (!status.ok()) throw new Error(status.error_msg());
    const copied = <T>(nBytes: number, read: (address: number) => boolean, copy: (address: number) => T): T => {
        const address = module._malloc(nBytes);
        if (!read(address)) throw new Error("Draco gives no such data");
        const result = copy(address);
        module._free(address);
        return result;
    };
    const nIndices = 3 * mesh.num_faces();
    const triangles = copied(
        4 * nIndices,
        (address) => decoder.GetTrianglesUInt32Array(mesh, 4 * nIndices, address),
        (address) => module.HEAPU8.slice(address, address + 4 * nIndices),
    );
    const nBytes = 12 * mesh.num_points();
    const vectors = new Map<string, Float32Array>();
    for (const [name, id] of Object.entries(ids)) {
        const attribute = decoder.GetAttributeByUniqueId(mesh, id);
        const data = copied(
            nBytes,
            (address) =>
                decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, module.DT_FLOAT32, nBytes, address),
            (address) => module.HEAPU8.slice(address, address + nBytes),
        );
        vectors.set(name, new Float32Array(data.buffer));
    }
    const nVertices: number = mesh.num_points();
    for (const object of [mesh, decoder]) module.destroy(object);
    return { nVertices, triangles: new Uint32Array(triangles.buffer), vectors };
}
