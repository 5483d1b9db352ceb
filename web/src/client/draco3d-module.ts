// The only file that imports the npm package draco3d, Google's stock Draco decoder compiled to WebAssembly, and the
// types of the part that is used: the package brings none.

// @ts-expect-error no types
import untyped from "draco3d/draco_decoder_nodejs.js";

/** Where a browser finds `draco_decoder.wasm`; Node finds it by itself. */
export interface Draco3dOptions {
    /** The file's bytes. */
    readonly wasmBinary?: ArrayBuffer;
    /** Gives the file's address. */
    readonly locateFile?: (name: string) => string;
}

/** An object in Draco's memory: it lives until destroy(). */
export interface DracoObject {
    readonly ptr: number;
}

export interface PointCloud extends DracoObject {
    num_points(): number;
    num_attributes(): number;
}

export interface Mesh extends PointCloud {
    num_faces(): number;
}

export interface Attribute {
    num_components(): number;
    data_type(): number;
}

export interface Status {
    ok(): boolean;
    error_msg(): string;
}

export interface Decoder extends DracoObject {
    DecodeArrayToPointCloud(address: number, nBytes: number, into: PointCloud): Status;
    DecodeArrayToMesh(address: number, nBytes: number, into: Mesh): Status;
    GetAttribute(cloud: PointCloud, id: number): Attribute;
    GetAttributeDataArrayForAllPoints(
        cloud: PointCloud,
        attribute: Attribute,
        type: number,
        nBytes: number,
        address: number,
    ): boolean;
    GetTrianglesUInt32Array(mesh: Mesh, nBytes: number, address: number): boolean;
}

export interface Draco3dModule {
    readonly PointCloud: new () => PointCloud;
    readonly Mesh: new () => Mesh;
    readonly Decoder: new () => Decoder;
    readonly DT_INT32: number;
    /** All of Draco's memory; another array after it has grown. */
    readonly HEAPU8: Uint8Array;
    _malloc(nBytes: number): number;
    _free(address: number): void;
    destroy(object: DracoObject): void;
}

export const createDraco3dModule = untyped as (
    options: Draco3dOptions & { printErr: (line: string) => void },
) => Promise<Draco3dModule>;
