import type { Platform, SocketLike } from "./platform.js";

/** Where a follower of a log stands. */
export interface LivePosition {
    /** Of the log that it has a beginning of, as "hello" tells it; undefined if it has none. */
    readonly logId: string | undefined;
    /** Sequence number of the first frame that it lacks. */
    readonly next: number;
}

export interface LiveFollower {
    position(): LivePosition;
    /** A log with this id follows from its start: what came before goes. */
    begin(logId: string): void;
    /** Whole frames, in front of the first the header. */
    frames(bytes: Uint8Array): void;
    status(status: LiveStatus): void;
}

export type LiveStatus =
    | { readonly type: "connecting"; readonly attempt: number }
    | { readonly type: "open" }
    /** Lost; the next attempt follows after some milliseconds. */
    | { readonly type: "lost"; readonly retryIn: number }
    /** The server has sent all; of a failed model with its sentence. */
    | { readonly type: "ended"; readonly state: string; readonly error: string | undefined }
    /** The server could not be reached so often that it is tried no more, or the connection was closed from here. */
    | { readonly type: "gone" };

export interface LiveOptions {
    /** Attempts in a row that brought nothing, after which it gives up. */
    readonly maxAttempts: number;
    /** Milliseconds before the second attempt in a row; twice as long before each later one. */
    readonly firstDelay: number;
    readonly maxDelay: number;
}

export const defaultLiveOptions: LiveOptions = { maxAttempts: Infinity, firstDelay: 250, maxDelay: 8000 };

/** Follows a log over WebSockets: connects again when one breaks, and goes on at the frame that it lacks. */
export class LiveConnection {
    private readonly url: string;
    private readonly platform: Platform;
    private readonly follower: LiveFollower;
    private readonly options: LiveOptions;
    private readonly protocols: string[];
    private socket: SocketLike | undefined;
    private closed = false;
    private ended = false;
    private skipWait: (() => void) | undefined;

    /**
     * @param url   of the model's WebSocket, without a query
     * @param token as ModelOptions.token
     */
    constructor(url: string, platform: Platform, follower: LiveFollower, options: LiveOptions, token?: string) {
        this.url = url;
        this.platform = platform;
        this.follower = follower;
        this.options = options;
        // A browser sends no Authorization with a WebSocket: proto/openapi.yaml, /live.
        this.protocols = token === undefined ? [] : ["anyrate.live", `anyrate.bearer.${token}`];
    }

    /** Follows until the server has sent all, gives up, or is closed. Rejects if a follower's call throws. */
    async run(): Promise<void> {
        for (let attempt = 1; !this.closed && attempt <= this.options.maxAttempts; ++attempt) {
            this.follower.status({ type: "connecting", attempt });
            if (await this.followOnce()) attempt = 0;
            if (this.ended) return;
            if (!this.closed) await this.wait(Math.max(attempt, 1));
        }
        this.follower.status({ type: "gone" });
    }

    /** Does not wait for the next attempt. */
    retryNow(): void {
        this.skipWait?.();
    }

    close(): void {
        this.closed = true;
        this.socket?.close();
        this.skipWait?.();
    }

    private async wait(attempt: number): Promise<void> {
        const { firstDelay, maxDelay } = this.options;
        // Up to half as long again by chance, so that the clients of a server that starts again do not all come at once.
        const delay = Math.min(firstDelay * 2 ** (attempt - 1), maxDelay) * (1 + 0.5 * Math.random());
        this.follower.status({ type: "lost", retryIn: delay });
        const skipped = new Promise<void>((resolve) => (this.skipWait = resolve));
        await Promise.race([skipped, this.platform.sleep(delay)]);
        this.skipWait = undefined;
    }

    /** One connection, to its end. @returns whether it brought anything */
    private followOnce(): Promise<boolean> {
        const { next } = this.follower.position();
        const socket = new this.platform.WebSocket(`${this.url}?from=${next}`, this.protocols);
        this.socket = socket;
        socket.binaryType = "arraybuffer";
        return new Promise((resolve, reject) => {
            let broughtAnything = false;
            socket.onopen = () => this.follower.status({ type: "open" });
            socket.onerror = () => {}; // a close follows
            socket.onclose = () => resolve(broughtAnything);
            socket.onmessage = ({ data }) => {
                if (this.closed) return;
                try {
                    broughtAnything ||= typeof data !== "string";
                    if (!this.take(data, next)) socket.close();
                } catch (error) {
                    socket.close();
                    reject(error);
                }
            };
        });
    }

    /** @returns whether this connection is of further use */
    private take(data: unknown, from: number): boolean {
        if (typeof data !== "string") {
            this.follower.frames(new Uint8Array(data as ArrayBuffer));
            return true;
        }
        const message = JSON.parse(data) as Record<string, unknown>;
        if (message["type"] === "hello") return this.hello(String(message["log_id"]), from, Number(message["next_sequence"]));
        if (message["type"] === "end") {
            this.ended = true;
            const error = message["error"];
            this.follower.status({
                type: "ended",
                state: String(message["state"]),
                error: typeof error === "string" ? error : undefined,
            });
        }
        return true;
    }

    private hello(logId: string, from: number, nextSequence: number): boolean {
        if (logId === this.follower.position().logId) return true;
        this.follower.begin(logId);
        // The log was begun anew while we were away, and its frames would come from where we stood in the old one.
        return from === 0 || nextSequence === 0;
    }
}
