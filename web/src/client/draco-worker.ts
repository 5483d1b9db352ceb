// The script of the worker behind dracoInWorker(): answers requests one after the other.
import { DecodeError } from "./decode-error.js";
import { loadDraco3d } from "./draco3d.js";
import type { DracoDecoder } from "./draco.js";
import type { DracoReply, DracoRequest } from "./draco-worker-protocol.js";
import type { IntegerMesh } from "./integer-mesh.js";

/** Of the worker itself, seen from inside. */
interface WorkerScope {
    onmessage: ((event: { readonly data: DracoRequest }) => void) | null;
    postMessage(reply: DracoReply, transferred: ArrayBufferLike[]): void;
    readonly performance: { now(): number };
}

const scope = globalThis as unknown as WorkerScope;
let draco: Promise<DracoDecoder> | undefined;

scope.onmessage = ({ data }) => {
    if (data.type === "start") {
        const { wasm } = data;
        draco = loadDraco3d(wasm === undefined ? {} : { locateFile: () => wasm });
        draco.catch(() => {}); // every request says it
    } else {
        void reply(data);
    }
};

async function reply(request: Exclude<DracoRequest, { type: "start" }>): Promise<void> {
    const { id } = request;
    try {
        const decoder = await draco!;
        const begin = scope.performance.now();
        const answer = decoded(request, decoder);
        const milliseconds = scope.performance.now() - begin;
        scope.postMessage({ id, answer, milliseconds }, arraysOf(answer).map((array) => array.buffer));
    } catch (error) {
        const sentence = error instanceof Error ? error.message : String(error);
        scope.postMessage({ id, error: sentence, isDecodeError: error instanceof DecodeError }, []);
    }
}

function decoded(request: Exclude<DracoRequest, { type: "start" }>, decoder: DracoDecoder): Int32Array[] | IntegerMesh {
    return request.type === "cloud"
        ? decoder.decodePointCloud(request.bytes, request.nPoints, request.nComponents)
        : decoder.decodeMesh(request.bytes, request.nVertices, request.nFaces);
}

function arraysOf(answer: Int32Array[] | IntegerMesh): Int32Array[] {
    return Array.isArray(answer) ? answer : [answer.positions, answer.triangles];
}
