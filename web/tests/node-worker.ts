// A browser's Worker, as much of it as the client uses, on a thread of Node.
import { Worker } from "node:worker_threads";

import type { WorkerLike } from "../src/client/platform.js";
import { repository } from "./golden.js";

const script = new URL("web/dist/src/client/draco-worker.js", repository);
const shim = `
const { parentPort } = require("node:worker_threads");
globalThis.postMessage = (message, transferred) => parentPort.postMessage(message, transferred);
const early = [];
parentPort.on("message", (data) => (globalThis.onmessage ? globalThis.onmessage({ data }) : early.push(data)));
import(${JSON.stringify(script.href)}).then(() => early.forEach((data) => globalThis.onmessage({ data })));
`;

export function nodeWorker(): WorkerLike {
    const worker = new Worker(shim, { eval: true });
    const like: WorkerLike = {
        onmessage: null,
        onerror: null,
        postMessage: (message, transferred) => worker.postMessage(message, transferred),
        terminate: () => worker.terminate(),
    };
    worker.on("message", (data: unknown) => like.onmessage?.({ data }));
    worker.on("error", (error) => like.onerror?.({ message: error.message }));
    return like;
}
