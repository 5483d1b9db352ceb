import { authorisation, RequestError, sentenceOf } from "./api.js";
import type { ModelInfo } from "./api.js";
import type { CheckedCapture } from "./capture-check.js";
import { zipOf } from "./zip-file.js";

export interface UploadProgress {
    readonly phase: "packing" | "sending";
    /** Of the phase, 0 to 1. */
    readonly share: number;
}

/** Takes a capture to the server. send() may be called again after it failed: it goes on, and makes one model only. */
export interface Uploader {
    /** @throws RequestError the server refuses, TypeError the connection broke */
    send(onProgress: (progress: UploadProgress) => void, signal: AbortSignal): Promise<ModelInfo>;
}

/** The capture as one zip. */
export class ZipUploader implements Uploader {
    private readonly capture: CheckedCapture;
    private readonly query: string;
    private readonly key = crypto.randomUUID();
    private zip: Blob | undefined;

    constructor(capture: CheckedCapture, vertices: number) {
        this.capture = capture;
        this.query = `vertices=${vertices}`;
        this.zip = capture.zip;
    }

    async send(onProgress: (progress: UploadProgress) => void, signal: AbortSignal): Promise<ModelInfo> {
        this.zip ??= await zipOf(this.capture.files, (share) => onProgress({ phase: "packing", share }));
        return post(`/v1/models?${this.query}`, this.zip, this.key, signal, (share) => onProgress({ phase: "sending", share }));
    }
}

/** With fetch, a page is not told how far an upload has come. */
function post(url: string, body: Blob, key: string, signal: AbortSignal, onProgress: (share: number) => void): Promise<ModelInfo> {
    return new Promise((resolve, reject) => {
        const request = new XMLHttpRequest();
        request.open("POST", url);
        request.setRequestHeader("Content-Type", "application/zip");
        request.setRequestHeader("Idempotency-Key", key);
        for (const [name, value] of Object.entries(authorisation())) request.setRequestHeader(name, value);
        request.upload.onprogress = ({ loaded, total }) => onProgress(loaded / total);
        request.onload = () => {
            if (request.status === 202) resolve(JSON.parse(request.responseText) as ModelInfo);
            else reject(new RequestError(request.status, sentenceOf(request.responseText, request.status)));
        };
        request.onerror = () => reject(new TypeError("the connection broke"));
        request.onabort = () => reject(new DOMException("stopped", "AbortError"));
        signal.addEventListener("abort", () => request.abort());
        request.send(body);
    });
}
