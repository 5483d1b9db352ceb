// What browsers and Node both have and the language's own library does not describe: as much of it as is used here, so
// that neither of them need be named. Everything can be replaced, by tests and by engines that lack it.

export interface AbortSignalLike {
    readonly aborted: boolean;
    readonly reason: unknown;
    addEventListener(type: "abort", listener: () => void): void;
    removeEventListener(type: "abort", listener: () => void): void;
}

export interface BodyReader {
    read(): Promise<{ readonly done: boolean; readonly value?: Uint8Array | undefined }>;
    cancel(): Promise<void>;
}

export interface ResponseLike {
    readonly status: number;
    readonly headers: { get(name: string): string | null };
    readonly body: { getReader(): BodyReader } | null;
    text(): Promise<string>;
    arrayBuffer(): Promise<ArrayBuffer>;
}

export type Fetch = (
    url: string,
    options: { headers: Record<string, string>; signal: AbortSignalLike },
) => Promise<ResponseLike>;

export interface SocketLike {
    binaryType: string;
    onopen: (() => void) | null;
    onmessage: ((event: { readonly data: unknown }) => void) | null;
    onclose: ((event: { readonly code: number; readonly reason: string }) => void) | null;
    onerror: (() => void) | null;
    send(text: string): void;
    close(): void;
}

export type SocketConstructor = new (url: string, protocols?: string[]) => SocketLike;

export interface WorkerLike {
    onmessage: ((event: { readonly data: unknown }) => void) | null;
    onerror: ((event: { readonly message?: string }) => void) | null;
    postMessage(message: unknown, transferred: ArrayBuffer[]): void;
    terminate(): unknown;
}

export interface Platform {
    readonly fetch: Fetch;
    readonly WebSocket: SocketConstructor;
    /** Milliseconds that only grow. */
    readonly now: () => number;
    /** Gives way to other tasks: input, drawing. */
    readonly pause: () => Promise<void>;
    readonly sleep: (milliseconds: number) => Promise<void>;
}

interface Timeouts {
    setTimeout(call: () => void, milliseconds: number): unknown;
}

interface MessagePorts {
    readonly port1: { onmessage: (() => void) | null; close(): void };
    readonly port2: { postMessage(message: unknown): void };
}

interface Engine extends Timeouts {
    readonly fetch: Fetch;
    readonly WebSocket?: SocketConstructor;
    readonly performance: { now(): number };
    readonly MessageChannel: new () => MessagePorts;
    readonly AbortController: new () => AbortControllerLike;
}

export interface AbortControllerLike {
    readonly signal: AbortSignalLike;
    abort(reason?: unknown): void;
}

const engine = globalThis as unknown as Engine;

/** What the engine offers, with some of it replaced. */
export function platformWith(replaced: Partial<Platform>): Platform {
    return {
        fetch: (url, options) => engine.fetch(url, options),
        WebSocket: engine.WebSocket ?? noWebSocket,
        now: () => engine.performance.now(),
        pause,
        sleep: (milliseconds) => new Promise((resolve) => void engine.setTimeout(resolve, milliseconds)),
        ...replaced,
    };
}

/** The engine's fetch, or the one in its place, with a bearer token in every request. */
export function fetchWith(token: string, replaced: Partial<Platform>): Fetch {
    const { fetch } = platformWith(replaced);
    return (url, { headers, signal }) => fetch(url, { headers: { ...headers, Authorization: `Bearer ${token}` }, signal });
}

export function newAbortController(): AbortControllerLike {
    return new engine.AbortController();
}

const noWebSocket = class {
    constructor() {
        throw new Error("this engine has no WebSocket: pass one in the options");
    }
} as unknown as SocketConstructor;

/** A timer of 0 ms would wait 4 ms in browsers; a message does not, and unlike scheduler.yield() it lets timers go first. */
function pause(): Promise<void> {
    return new Promise((resolve) => {
        const { port1, port2 } = new engine.MessageChannel();
        port1.onmessage = () => {
            port1.close();
            resolve();
        };
        port2.postMessage(undefined);
    });
}
