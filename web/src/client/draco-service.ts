import type { DracoDecoder } from "./draco.js";
import type { IntegerMesh } from "./integer-mesh.js";
import { platformWith } from "./platform.js";

/** Draco in another thread, or in this one: DracoDecoder with answers that come later. */
export interface DracoService {
    decodePointCloud(bytes: Uint8Array, nPoints: number, nComponents: readonly number[]): Promise<Int32Array[]>;
    decodeMesh(bytes: Uint8Array, nVertices: number, nFaces: number): Promise<IntegerMesh>;
    /** Milliseconds that decoding has taken so far. */
    readonly milliseconds: number;
    dispose(): void;
}

/** Draco in this thread. */
export function dracoInThread(draco: DracoDecoder): DracoService {
    const { now } = platformWith({});
    let milliseconds = 0;
    const timed = async <T>(decode: () => T): Promise<T> => {
        const begin = now();
        try {
            return decode();
        } finally {
            milliseconds += now() - begin;
        }
    };
    return {
        decodePointCloud: (...call) => timed(() => draco.decodePointCloud(...call)),
        decodeMesh: (...call) => timed(() => draco.decodeMesh(...call)),
        get milliseconds() {
            return milliseconds;
        },
        dispose: () => {},
    };
}
