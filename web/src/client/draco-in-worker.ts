import { DecodeError } from "./decode-error.js";
import type { DracoService } from "./draco-service.js";
import type { DracoReply, DracoRequest } from "./draco-worker-protocol.js";
import type { IntegerMesh } from "./integer-mesh.js";
import type { WorkerLike } from "./platform.js";

interface Waiting {
    resolve(answer: unknown): void;
    reject(error: Error): void;
}

export interface DracoWorkerOptions {
    /** Address of `draco_decoder.wasm`, if it is not beside the worker's script. */
    readonly wasm?: string;
}

/**
 * Draco in a worker that runs draco-worker.ts. One serves any number of logs; it ends with dispose(), which also
 * refuses what is not answered yet.
 */
export function dracoInWorker(worker: WorkerLike, options: DracoWorkerOptions = {}): DracoService {
    const waiting = new Map<number, Waiting>();
    let lastId = 0;
    let milliseconds = 0;
    let stopped: Error | undefined;

    const stop = (error: Error) => {
        stopped = error;
        for (const { reject } of waiting.values()) reject(error);
        waiting.clear();
    };
    const post = (request: DracoRequest, transferred: ArrayBuffer[]) => worker.postMessage(request, transferred);
    const ask = <T>(request: (id: number, copy: Uint8Array) => DracoRequest, bytes: Uint8Array): Promise<T> => {
        if (stopped) return Promise.reject(stopped);
        const id = ++lastId;
        const copy = bytes.slice(); // the caller keeps its bytes
        return new Promise<T>((resolve, reject) => {
            waiting.set(id, { resolve: resolve as (answer: unknown) => void, reject });
            post(request(id, copy), [copy.buffer]);
        });
    };

    worker.onmessage = ({ data }) => {
        const reply = data as DracoReply;
        const caller = waiting.get(reply.id);
        waiting.delete(reply.id);
        if ("error" in reply) {
            caller?.reject(reply.isDecodeError ? new DecodeError(reply.error) : new Error(reply.error));
            return;
        }
        milliseconds += reply.milliseconds;
        caller?.resolve(reply.answer);
    };
    worker.onerror = ({ message }) => stop(new Error(`the Draco worker stopped: ${message ?? "it did not start"}`));
    post({ type: "start", wasm: options.wasm }, []);

    return {
        decodePointCloud: (bytes, nPoints, nComponents) =>
            ask<Int32Array[]>((id, copy) => ({ type: "cloud", id, bytes: copy, nPoints, nComponents }), bytes),
        decodeMesh: (bytes, nVertices, nFaces) =>
            ask<IntegerMesh>((id, copy) => ({ type: "mesh", id, bytes: copy, nVertices, nFaces }), bytes),
        get milliseconds() {
            return milliseconds;
        },
        dispose: () => {
            stop(new Error("the Draco worker was disposed of"));
            worker.terminate();
        },
    };
}
