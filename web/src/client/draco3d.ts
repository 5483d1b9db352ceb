import { DecodeError } from "./decode-error.js";
import { checkMeshLayout, checkPointCloudLayout } from "./draco-layout.js";
import { createDraco3dModule } from "./draco3d-module.js";
import type { Decoder, Draco3dModule, Draco3dOptions, PointCloud, Status } from "./draco3d-module.js";
import type { DracoDecoder } from "./draco.js";
import type { IntegerMesh } from "./integer-mesh.js";
import { maxDracoMagnitude } from "./limits.js";

/** Starts Draco. One decoder serves any number of logs. */
export async function loadDraco3d(options: Draco3dOptions = {}): Promise<DracoDecoder> {
    return new Draco3dDecoder(await createDraco3dModule({ ...options, printErr: () => {} })); // errors say the same
}

/**
 * Draco's memory is bounded by what the checked counts need, or else by the 2 GiB at which its WebAssembly ends: it
 * then stops for good, and every later call says so.
 */
class Draco3dDecoder implements DracoDecoder {
    private readonly draco: Draco3dModule;
    private stopped = false;

    constructor(draco: Draco3dModule) {
        this.draco = draco;
    }

    decodePointCloud(bytes: Uint8Array, nPoints: number, nComponents: readonly number[]): Int32Array[] {
        checkPointCloudLayout(bytes, nPoints, nComponents);
        return this.contained(() => {
            const cloud = new this.draco.PointCloud();
            try {
                this.decode(bytes, (decoder, address) => decoder.DecodeArrayToPointCloud(address, bytes.length, cloud));
                checkCounts(cloud, nPoints, nComponents.length);
                return nComponents.map((n, id) => this.values(cloud, id, nPoints, n));
            } finally {
                this.draco.destroy(cloud);
            }
        });
    }

    decodeMesh(bytes: Uint8Array, nVertices: number, nFaces: number): IntegerMesh {
        checkMeshLayout(bytes, nVertices, nFaces);
        return this.contained(() => {
            const mesh = new this.draco.Mesh();
            try {
                this.decode(bytes, (decoder, address) => decoder.DecodeArrayToMesh(address, bytes.length, mesh));
                checkCounts(mesh, nVertices, 1);
                if (mesh.num_faces() !== nFaces) fail(`expected ${nFaces} faces, got ${mesh.num_faces()}`);
                const triangles = this.copied(3 * nFaces, (decoder, address, nBytes) =>
                    decoder.GetTrianglesUInt32Array(mesh, nBytes, address),
                );
                return { positions: this.values(mesh, 0, nVertices, 3), triangles };
            } finally {
                this.draco.destroy(mesh);
            }
        });
    }

    /** Runs what calls into WebAssembly: whatever is thrown there, it has stopped. */
    private contained<T>(call: () => T): T {
        if (this.stopped) fail("an earlier payload has stopped this decoder; load another");
        try {
            return call();
        } catch (error) {
            if (error instanceof DecodeError) throw error;
            this.stopped = true;
            return fail(`the decoder stopped: ${String(error)}`);
        }
    }

    private decode(bytes: Uint8Array, decode: (decoder: Decoder, address: number) => Status): void {
        this.withMemory(bytes.length, (decoder, address) => {
            this.draco.HEAPU8.set(bytes, address);
            const status = decode(decoder, address);
            if (!status.ok()) fail(status.error_msg());
        });
    }

    private values(cloud: PointCloud, id: number, nPoints: number, nComponents: number): Int32Array {
        const values = this.copied(nPoints * nComponents, (decoder, address, nBytes) => {
            const attribute = decoder.GetAttribute(cloud, id);
            if (attribute.num_components() !== nComponents || attribute.data_type() !== this.draco.DT_INT32) {
                fail(`expected attribute ${id} to have ${nComponents} int32 components`);
            }
            return decoder.GetAttributeDataArrayForAllPoints(cloud, attribute, this.draco.DT_INT32, nBytes, address);
        });
        const beyond = values.find((value) => Math.abs(value) > maxDracoMagnitude);
        if (beyond !== undefined) fail(`expected integers of at most 2^25 in magnitude, got ${beyond}`);
        return values;
    }

    /** n 32-bit integers that `write` puts into Draco's memory. */
    private copied(n: number, write: (decoder: Decoder, address: number, nBytes: number) => boolean): Int32Array {
        return this.withMemory(4 * n, (decoder, address) => {
            if (!write(decoder, address, 4 * n)) fail("the decoder does not give its values");
            // The memory may have grown meanwhile, which detaches every view taken before.
            return new Int32Array(this.draco.HEAPU8.slice(address, address + 4 * n).buffer);
        });
    }

    private withMemory<T>(nBytes: number, use: (decoder: Decoder, address: number) => T): T {
        const decoder = new this.draco.Decoder();
        const address = this.draco._malloc(nBytes);
        try {
            if (address === 0) throw new RangeError(`no memory for ${nBytes} bytes`);
            return use(decoder, address);
        } finally {
            this.draco._free(address);
            this.draco.destroy(decoder);
        }
    }
}

function checkCounts(cloud: PointCloud, nPoints: number, nAttributes: number): void {
    if (cloud.num_points() === nPoints && cloud.num_attributes() === nAttributes) return;
    const found = `${cloud.num_points()} points with ${cloud.num_attributes()} attributes`;
    fail(`expected ${nPoints} points with ${nAttributes} attributes, got ${found}`);
}

function fail(what: string): never {
    throw new DecodeError(`Draco payload: ${what}`);
}
