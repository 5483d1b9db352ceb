import { problemOf, RequestError } from "./api.js";
import type { Fault, ModelInfo } from "./api.js";
import type { CheckedCapture } from "./capture-check.js";
import { sendBody } from "./send-body.js";
import { zipOf } from "./zip-file.js";
import type { NamedFile } from "./zip-file.js";

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

export function newUploader(capture: CheckedCapture, vertices: number): Uploader {
    return capture.zip ? new ZipUploader(capture, vertices) : new FilesUploader(capture, vertices);
}

/** The capture as one zip. */
class ZipUploader implements Uploader {
    private readonly capture: CheckedCapture;
    private readonly query: string;
    private readonly key = randomKey();
    private zip: Blob | undefined;

    constructor(capture: CheckedCapture, vertices: number) {
        this.capture = capture;
        this.query = `vertices=${vertices}`;
        this.zip = capture.zip;
    }

    async send(onProgress: (progress: UploadProgress) => void, signal: AbortSignal): Promise<ModelInfo> {
        this.zip ??= await zipOf(this.capture.files, (share) => onProgress({ phase: "packing", share }));
        const headers = { "Content-Type": "application/zip", "Idempotency-Key": this.key };
        const sent = await sendBody("POST", `/v1/models?${this.query}`, this.zip, headers, signal, (nBytes) =>
            onProgress({ phase: "sending", share: nBytes / this.zip!.size }),
        );
        return expectJson<ModelInfo>(sent);
    }
}

/** What a server says of a capture that arrives file by file. */
interface ArrivedCapture {
    readonly id: string;
    readonly files: readonly { readonly path: string; readonly bytes: number; readonly sha256: string; readonly accepted: boolean }[];
}

/** Times that a file is sent again, a second, two, four ... after its connection broke. */
const maxRetries = 4;

/** File by file: what has arrived is not sent again, also if the page was closed meanwhile. */
class FilesUploader implements Uploader {
    private readonly capture: CheckedCapture;
    private readonly vertices: number;
    private readonly key = randomKey();

    constructor(capture: CheckedCapture, vertices: number) {
        this.capture = capture;
        this.vertices = vertices;
    }

    async send(onProgress: (progress: UploadProgress) => void, signal: AbortSignal): Promise<ModelInfo> {
        const arrived = await this.begin(signal);
        if (!arrived) return new ZipUploader(this.capture, this.vertices).send(onProgress, signal); // an older server
        const known = new Map(arrived.files.map((file) => [file.path, file]));
        const faults: Fault[] = [];
        let nBytes = 0;
        for (const { name, file } of this.capture.files) {
            const tell = (n: number) => onProgress({ phase: "sending", share: (nBytes + n) / this.capture.nBytes });
            tell(0);
            const there = known.get(name);
            const digest = await sha256(file);
            const isThere = there?.accepted && there.bytes === file.size && (!digest || hexOf(digest) === there.sha256);
            if (!isThere) await this.put(arrived.id, { name, file }, digest, signal, tell, faults);
            nBytes += file.size;
        }
        onProgress({ phase: "sending", share: 1 });
        if (faults.length > 0) throw new RequestError(422, "The server refuses some of the files.", faults);
        const headers = { "Idempotency-Key": this.key };
        const url = `/v1/models?capture=${arrived.id}&vertices=${this.vertices}`;
        return expectJson<ModelInfo>(await sendBody("POST", url, undefined, headers, signal));
    }

    /** @returns undefined if the server takes no files one by one */
    private async begin(signal: AbortSignal): Promise<ArrivedCapture | undefined> {
        const headers = { "Idempotency-Key": await this.captureKey() };
        const sent = await sendBody("POST", "/v1/captures", undefined, headers, signal);
        if (sent.status === 404 || sent.status === 405) return undefined;
        return expectJson<ArrivedCapture>(sent);
    }

    private async put(
        id: string,
        { name, file }: NamedFile,
        digest: Uint8Array | undefined,
        signal: AbortSignal,
        tell: (nBytes: number) => void,
        faults: Fault[],
    ): Promise<void> {
        const url = `/v1/captures/${id}/files/${name.split("/").map(encodeURIComponent).join("/")}`;
        const headers: Record<string, string> = { "Content-Type": "application/octet-stream" };
        if (digest) headers["Content-Digest"] = `sha-256=:${btoa(String.fromCharCode(...digest))}:`;
        for (let attempt = 0; ; ++attempt) {
            try {
                const sent = await sendBody("PUT", url, file, headers, signal, tell);
                const { accepted, fault } = expectJson<{ accepted: boolean; fault?: string }>(sent);
                if (!accepted) faults.push({ file: name, sentence: fault ?? "is refused" });
                return;
            } catch (error) {
                if (!(error instanceof TypeError) || attempt === maxRetries) throw error;
                await new Promise((resolve) => setTimeout(resolve, 1000 * 2 ** attempt));
            }
        }
    }

    /** The same for the same files, so that they go on from another page or day. */
    private async captureKey(): Promise<string> {
        const list = this.capture.files.map(({ name, file }) => `${name} ${file.size}`).join("\n");
        const cameras = this.capture.files.find(({ name }) => name === "cameras.json")!.file;
        const digest = await sha256(new Blob([list, "\n", cameras]));
        return digest ? hexOf(digest) : this.key;
    }
}

interface Answer {
    readonly status: number;
    readonly body: string;
}

function expectJson<T>({ status, body }: Answer): T {
    if (status >= 200 && status < 300) return JSON.parse(body) as T;
    throw problemOf(body, status);
}

/** Undefined where a page is not trusted with it: neither HTTPS nor this machine. */
async function sha256(blob: Blob): Promise<Uint8Array | undefined> {
    if (!globalThis.crypto.subtle) return undefined;
    return new Uint8Array(await crypto.subtle.digest("SHA-256", await blob.arrayBuffer()));
}

function hexOf(bytes: Uint8Array): string {
    return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

function randomKey(): string {
    return hexOf(crypto.getRandomValues(new Uint8Array(16)));
}

