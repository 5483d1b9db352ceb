// What the viewer asks of the server, besides logs. The types are those of proto/openapi.yaml.
import type { components } from "../client/index.js";
import { readEvents } from "./event-stream.js";
import { authorisation, wantsToken } from "./token.js";

export type ModelInfo = components["schemas"]["Model"];
export type Cameras = components["schemas"]["Cameras"];
export type CameraInfo = Cameras["cameras"][number];

/** What the server said in place of what was asked for. */
export class RequestError extends Error {
    readonly status: number;
    /** Of files that were sent, one by one. */
    readonly faults: readonly Fault[];

    constructor(status: number, sentence: string, faults: readonly Fault[] = []) {
        super(sentence);
        this.status = status;
        this.faults = faults;
    }
}

/** What is wrong with a file. */
export interface Fault {
    readonly file: string;
    readonly sentence: string;
}

/** The address of a model, whole, as the client library and WebSockets want it. */
export function modelUrl(id: string): string {
    return `${location.origin}/v1/models/${id}`;
}

export async function listModels(after?: string): Promise<{ models: ModelInfo[]; next?: string }> {
    const response = await ask(after ?? "/v1/models?limit=60");
    const page = (await (await answer(response)).json()) as { models: ModelInfo[]; next?: string };
    page.models.forEach(remember);
    return page;
}

const known = new Map<string, ModelInfo>();

/** Keeps what the server said of a model, so that its page need not wait to hear it again. */
export function remember(model: ModelInfo): void {
    known.set(model.id, model);
}

/** What the server said last. */
export function knownModel(id: string): ModelInfo | undefined {
    return known.get(id);
}

export async function getModel(id: string): Promise<ModelInfo> {
    return (await answer(await ask(`/v1/models/${id}`))).json() as Promise<ModelInfo>;
}

export async function deleteModel(id: string): Promise<void> {
    await answer(await ask(`/v1/models/${id}`, "DELETE"));
}

/** Ends a reconstruction that waits or runs. */
export async function cancelModel(id: string): Promise<void> {
    await answer(await ask(`/v1/models/${id}/cancel`, "POST"));
}

/** The cameras of a model's photographs; undefined if the server has none. */
export async function getCameras(id: string): Promise<Cameras | undefined> {
    const response = await ask(`/v1/models/${id}/cameras`);
    return response.ok ? ((await response.json()) as Cameras) : undefined;
}

/** Follows a model's state until it is final. @returns how to stop */
export function watchModel(id: string, onState: (model: ModelInfo) => void, onDeleted: () => void): () => void {
    const stop = new AbortController();
    const take = (name: string, data: string): boolean => {
        if (name === "deleted") onDeleted();
        if (name !== "state") return name !== "deleted";
        const model = JSON.parse(data) as ModelInfo;
        remember(model);
        onState(model);
        return !isFinal(model);
    };
    void readEvents(`/v1/models/${id}/events`, stop.signal, take, onDeleted);
    return () => stop.abort();
}

export function isFinal({ state }: Pick<ModelInfo, "state">): boolean {
    return state === "done" || state === "failed" || state === "cancelled";
}

/** Whether a worker has made them, if it ever will. */
export function hasThumbnails({ state, stage }: ModelInfo): boolean {
    return isFinal({ state }) || (state === "running" && stage !== "" && stage !== "load");
}

function ask(url: string, method = "GET"): Promise<Response> {
    return fetch(url, { method, headers: authorisation() });
}

/** @throws RequestError with the server's own sentence */
async function answer(response: Response): Promise<Response> {
    if (response.ok) return response;
    wantsToken(response.status);
    throw problemOf(await response.text(), response.status);
}

/** Of a problem document (RFC 9457), or of the bare status. */
export function problemOf(body: string, status: number): RequestError {
    try {
        const { detail, faults = [] } = JSON.parse(body) as components["schemas"]["Problem"];
        const named = faults.map(({ path, fault }) => ({ file: path, sentence: fault }));
        if (typeof detail === "string") return new RequestError(status, detail, named);
    } catch {
        // not a problem document: the status says it
    }
    return new RequestError(status, `The server answered ${status}.`);
}
