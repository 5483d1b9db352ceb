// A web server of one log, as stubborn as a test wants it, that counts what it sends.
import { createServer } from "node:http";
import type { IncomingMessage, ServerResponse } from "node:http";
import type { AddressInfo } from "node:net";

import { WebSocketServer } from "ws";
import type { WebSocket } from "ws";

import { crc32c } from "../src/client/crc32c.js";
import { readLayout } from "../src/client/index.js";
import { concatenated } from "./golden.js";

export interface LogServerOptions {
    /** Answers every request with the whole log. */
    readonly ignoresRange?: boolean;
    /** Called with every WebSocket and the frame that it asks for first. */
    readonly onLive?: (socket: WebSocket, from: number) => void;
}

export class LogServer {
    /** May be replaced by another log, which gets another ETag. */
    log: Uint8Array;
    /** Range fields of the requests for the log. */
    readonly ranges: string[] = [];
    nBytesSent = 0;
    /** Field Authorization of each request for the log, and protocols that each WebSocket offered. */
    readonly credentials: (string | undefined)[] = [];
    /** Called with the Range of a request for the log, before it is answered. */
    onRequest: (range: string) => void = () => {};
    /** Of the log, as far as answers were read. */
    sideIndex: Uint8Array | undefined;
    private readonly options: LogServerOptions;
    private readonly server = createServer((request, response) => this.answer(request, response));
    private readonly sockets = new WebSocketServer({ server: this.server });

    constructor(log: Uint8Array, options: LogServerOptions = {}) {
        this.log = log;
        this.options = options;
        this.sockets.on("connection", (socket, request) => {
            const from = new URL(request.url!, "http://localhost").searchParams.get("from");
            this.credentials.push(request.headers["sec-websocket-protocol"]);
            this.options.onLive?.(socket, Number(from));
        });
    }

    async start(): Promise<string> {
        await new Promise<void>((resolve) => this.server.listen(0, "127.0.0.1", resolve));
        const { port } = this.server.address() as AddressInfo;
        return `http://127.0.0.1:${port}/v1/models/${"a".repeat(26)}`;
    }

    stop(): void {
        this.sockets.close();
        this.server.close();
        this.server.closeAllConnections();
    }

    private get etag(): string {
        return `"${crc32c(this.log)}"`;
    }

    private answer(request: IncomingMessage, response: ServerResponse): void {
        if (request.url!.includes("/index")) {
            if (this.sideIndex) response.writeHead(200).end(this.sideIndex);
            else response.writeHead(404).end();
            return;
        }
        if (!request.url!.endsWith("/log")) {
            response.writeHead(404, { "Content-Type": "application/problem+json" });
            response.end(JSON.stringify({ detail: "there is no such model" }));
            return;
        }
        const { range = "" } = request.headers;
        this.onRequest(range);
        this.ranges.push(range);
        this.credentials.push(request.headers.authorization);
        const condition = request.headers["if-range"];
        const asked = /^bytes=(\d+)-(\d*)$/.exec(range);
        if (!asked || this.options.ignoresRange || (condition !== undefined && condition !== this.etag)) {
            response.writeHead(200, { ETag: this.etag, "Content-Length": this.log.length });
            this.send(response, this.log);
            return;
        }
        const begin = Number(asked[1]);
        const end = Math.min(asked[2] === "" ? Infinity : Number(asked[2]) + 1, this.log.length);
        const bytes = this.log.subarray(begin, end);
        response.writeHead(206, {
            ETag: this.etag,
            "Content-Length": bytes.length,
            "Content-Range": `bytes ${begin}-${end - 1}/${this.log.length}`,
        });
        this.send(response, bytes);
    }

    private send(response: ServerResponse, bytes: Uint8Array): void {
        this.nBytesSent += bytes.length;
        response.end(bytes);
    }
}

/** The live form of a sealed log: the header says so, and there is no index. */
export function liveForm(sealed: Uint8Array, logId?: bigint): Uint8Array {
    const { frames } = readLayout(sealed);
    const header = sealed.slice(0, 96);
    const view = new DataView(header.buffer);
    view.setUint32(72, 0, true);
    if (logId !== undefined) view.setBigUint64(16, logId, true);
    view.setUint32(92, crc32c(header.subarray(0, 92)), true);
    return concatenated(header, sealed.subarray(frames[0].end));
}

/** Header, then whole frames, as messages of a live stream. */
export function messagesOf(live: Uint8Array): Uint8Array[] {
    return [live.subarray(0, 96), ...readLayout(live).frames.map(({ begin, end }) => live.subarray(begin, end))];
}

/** The bytes of a side index of a log's frames. */
export function sideIndexOf(log: Uint8Array): Uint8Array {
    const { header, index } = readLayout(log);
    const bytes = new Uint8Array(24 + 16 * index.length + 4);
    const view = new DataView(bytes.buffer);
    bytes.set([0x89, 0x41, 0x52, 0x49, 0x0d, 0x0a, 0x1a, 0x0a]);
    view.setBigUint64(8, header.logId, true);
    view.setUint32(16, index.length, true);
    index.forEach(({ nVertices, end }, i) => {
        view.setUint32(24 + 16 * i, nVertices, true);
        view.setUint32(28 + 16 * i, end, true);
        view.setFloat32(32 + 16 * i, 1000 - nVertices / 2, true);
        view.setFloat32(36 + 16 * i, NaN, true);
    });
    view.setUint32(bytes.length - 4, crc32c(bytes.subarray(0, -4)), true);
    return bytes;
}

