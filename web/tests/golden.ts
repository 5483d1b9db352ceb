// The files of tests/golden, which the C++ and the TypeScript reader have in common, and what the tests do with them.
import { readFileSync } from "node:fs";

import { crc32c } from "../src/client/crc32c.js";
import { frameHeaderSize } from "../src/client/frame.js";
import { loadDraco3d, readLayout } from "../src/client/index.js";
import type { ProgressiveMesh } from "../src/client/index.js";

/** The root of the repository. */
export const repository = new URL("../../", import.meta.url);

export const draco = await loadDraco3d();

/** Live form, the worked example of proto/FORMAT.md. */
export const octahedron = readGolden("octahedron.arl");
/** Sealed form, some hundred splits with colours. */
export const icosphere = readGolden("icosphere.arl");

/** The same refinements in packets of several batches. */
export const icospherePacked = readGolden("icosphere-packed.arl");

/** A cube that is rounded off, by flip rule 2 and smoothing 2. */
export const cube = readGolden("cube.arl");

/** A bumpy sphere, by flip rule 3 and smoothing 2. */
export const sphere = readGolden("sphere.arl");

/** What every reader must find at a vertex budget. */
export interface Expectation {
    readonly budget: number;
    readonly vertices: number;
    readonly faces: number;
    readonly stateHash: number;
    readonly positionsCrc: number;
    readonly trianglesCrc: number;
    readonly coloursCrc: number;
}

/** Of the icosphere in both forms. */
export const icosphereExpectations = readExpectations("icosphere.json");
export const cubeExpectations = readExpectations("cube.json");
export const sphereExpectations = readExpectations("sphere.json");

/** The same of a mesh. */
export function found(budget: number, mesh: ProgressiveMesh): Expectation {
    return {
        budget,
        vertices: mesh.nVertices,
        faces: mesh.nFaces,
        stateHash: mesh.stateHash,
        positionsCrc: crcOfWords(mesh.positions),
        trianglesCrc: crcOfWords(mesh.triangles),
        coloursCrc: crc32c(mesh.colours),
    };
}

/** A copy in which `change` has had its way, with checksums that hold again: what a hostile writer can send. */
export function rewritten(log: Uint8Array, change: (copy: Uint8Array, view: DataView) => void): Uint8Array {
    const { frames, header } = readLayout(log);
    const copy = log.slice();
    const view = new DataView(copy.buffer);
    change(copy, view);
    const tail = copy.subarray(96, header.headerBytes);
    view.setUint32(92, crc32c(tail, crc32c(copy.subarray(0, 92))), true);
    for (const { begin, end } of frames) {
        const crc = crc32c(copy.subarray(begin + frameHeaderSize, end), crc32c(copy.subarray(begin, begin + 24)));
        view.setUint32(begin + 24, crc, true);
    }
    return copy;
}

export function concatenated(...parts: readonly Uint8Array[]): Uint8Array {
    return Uint8Array.from(parts.flatMap((part) => [...part]));
}

function readGolden(name: string): Uint8Array {
    return new Uint8Array(readFileSync(new URL(`tests/golden/${name}`, repository)));
}

function readExpectations(name: string): readonly Expectation[] {
    return JSON.parse(new TextDecoder().decode(readGolden(name))) as readonly Expectation[];
}

function crcOfWords(words: Int32Array | Uint32Array): number {
    return crc32c(new Uint8Array(words.buffer, words.byteOffset, words.byteLength)); // little endian, as on the wire
}
