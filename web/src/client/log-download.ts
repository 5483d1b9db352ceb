import type { AbortSignalLike, BodyReader, Fetch, ResponseLike } from "./platform.js";
import { ServerError, serverError } from "./server-problem.js";

/** Who takes the bytes of a log, in order and each once. */
export interface LogSink {
    bytes(bytes: Uint8Array): void;
    /** The server has another log in place of the one whose beginning it sent: its bytes follow, from the first. */
    begunAnew(): void;
}

interface AskedAhead {
    readonly begin: number;
    readonly end: number;
    readonly response: Promise<ResponseLike>;
}

/**
 * Fetches a log from its start as far as is asked for, each byte once: by Range requests, or, where the server answers
 * the whole log instead (200), from that one answer, which is read no further than it has to be.
 */
export class LogDownload {
    private readonly url: string;
    private readonly fetch: Fetch;
    private readonly signal: AbortSignalLike;
    private readonly sink: LogSink;
    private etag: string | undefined;
    private whole: BodyReader | undefined;
    private have = 0;
    private total: number | undefined;
    private requestsMade = 0;
    private ahead: AskedAhead | undefined;

    constructor(url: string, fetch: Fetch, signal: AbortSignalLike, sink: LogSink) {
        this.url = url;
        this.fetch = fetch;
        this.signal = signal;
        this.sink = sink;
    }

    /** Bytes of the log that have arrived. */
    get nBytes(): number {
        return this.have;
    }
    get nRequests(): number {
        return this.requestsMade;
    }

    /**
     * Reads on until `end` bytes of the log have arrived, or all that there are: at most one request, or what was asked
     * for ahead.
     * @throws ServerError, or whatever fetch throws (TypeError in browsers) if the connection breaks; what has arrived
     *         stays, and the next call goes on behind it
     */
    async readTo(end: number): Promise<void> {
        if (this.have >= end || this.have === this.total) return;
        if (this.whole) await this.readWhole(this.whole, end);
        else await this.request(end);
    }

    /**
     * Asks for bytes that readTo() will want once those before them have arrived: a caller who knows that saves the
     * time of a request's way. They are read when it is their turn, and not at all if the log is another by then.
     */
    askAhead(begin: number, end: number): void {
        if (this.ahead || begin >= end) return;
        ++this.requestsMade;
        const headers = { Range: `bytes=${begin}-${end - 1}` };
        const response = this.fetch(this.url, { headers, signal: this.signal });
        response.catch(() => {}); // readTo() asks again
        this.ahead = { begin, end, response };
    }

    /** Lets go of answers that are not read to their end. */
    async dispose(): Promise<void> {
        this.dropAhead();
        await this.whole?.cancel().catch(() => {}); // it is over either way
        this.whole = undefined;
    }

    private async request(end: number): Promise<void> {
        if (this.ahead?.begin === this.have && (await this.readAhead(this.ahead))) return this.readTo(end);
        const headers: Record<string, string> = { Range: `bytes=${this.have}-${end - 1}` };
        if (this.etag !== undefined && this.have > 0) headers["If-Range"] = this.etag;
        ++this.requestsMade;
        const response = await this.fetch(this.url, { headers, signal: this.signal });
        if (response.status === 206) await this.readPart(response, end);
        else if (response.status === 200) await this.beginWhole(response, end);
        else throw await serverError(response, this.url);
    }

    /** @returns whether what was asked for ahead belongs to the same log, and has been read */
    private async readAhead(ahead: AskedAhead): Promise<boolean> {
        const response = await ahead.response.catch(() => undefined);
        if (response?.status === 206 && (response.headers.get("ETag") ?? undefined) === this.etag) {
            this.ahead = undefined;
            await this.readPart(response, ahead.end);
            return true;
        }
        this.dropAhead();
        return false;
    }

    private dropAhead(): void {
        void this.ahead?.response.then(({ body }) => body?.getReader().cancel()).catch(() => {});
        this.ahead = undefined;
    }

    private async readPart(response: ResponseLike, end: number): Promise<void> {
        const range = /^bytes (\d+)-(\d+)\/(\d+|\*)$/.exec(response.headers.get("Content-Range") ?? "");
        if (!range || Number(range[1]) !== this.have || Number(range[2]) >= end) {
            const got = response.headers.get("Content-Range") ?? "no Content-Range";
            throw new ServerError(206, `${this.url}: expected bytes ${this.have} to ${end - 1}, got ${got}`);
        }
        this.etag = response.headers.get("ETag") ?? undefined;
        if (range[3] !== "*") this.total = Number(range[3]);
        await this.readBody(readerOf(response), Infinity);
    }

    private async beginWhole(response: ResponseLike, end: number): Promise<void> {
        const etag = response.headers.get("ETag") ?? undefined;
        const length = response.headers.get("Content-Length");
        this.total = length === null ? undefined : Number(length);
        this.whole = readerOf(response);
        this.dropAhead();
        let known = this.have;
        if (known > 0 && etag !== this.etag) {
            this.have = known = 0;
            this.sink.begunAnew();
        }
        this.etag = etag;
        await this.readWhole(this.whole, end, known);
    }

    /** @param known bytes at the start of the answer that have arrived before */
    private async readWhole(reader: BodyReader, end: number, known = 0): Promise<void> {
        try {
            if (!(await this.readBody(reader, end, known))) return;
        } catch (error) {
            this.whole = undefined; // it is broken: the next call asks anew
            throw error;
        }
        this.whole = undefined;
        this.total = this.have;
    }

    /** @returns whether the body has ended */
    private async readBody(reader: BodyReader, end: number, known = 0): Promise<boolean> {
        let skipped = 0;
        while (this.have < end) {
            const { done, value } = await reader.read();
            if (done) return true;
            if (!value) continue;
            const bytes = value.subarray(Math.min(known - skipped, value.length));
            skipped += value.length - bytes.length;
            this.have += bytes.length;
            if (bytes.length > 0) this.sink.bytes(bytes);
        }
        return false;
    }
}

function readerOf(response: ResponseLike): BodyReader {
    if (!response.body) throw new ServerError(response.status, "the answer has no body");
    return response.body.getReader();
}
