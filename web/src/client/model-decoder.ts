import { ByteQueue } from "./byte-queue.js";
import { DecodeError } from "./decode-error.js";
import type { DracoDecoder } from "./draco.js";
import { frameHeaderSize, FrameType, payloadOf, readFrame } from "./frame.js";
import type { Frame } from "./frame.js";
import { decodeHeader, headerBytesNeeded, headerSize } from "./header.js";
import type { Header } from "./header.js";
import { decodeIndexRows } from "./log-index.js";
import type { IndexRow } from "./log-index.js";
import { LogOrder } from "./log-order.js";
import { ProgressiveMesh } from "./progressive-mesh.js";

/** Decodes a log frame by frame as bytes arrive. */
export class ModelDecoder {
    private readonly draco: DracoDecoder;
    private readonly queue = new ByteQueue();
    /** Bytes of the log before the queue. */
    private consumed = 0;
    private order: LogOrder | undefined;
    private maxVertices = Infinity;
    private failure: { readonly error: unknown } | undefined;

    private headerRead: Header | undefined;
    private indexRead: readonly IndexRow[] | undefined;
    private meshRead: ProgressiveMesh | undefined;
    private sequenceRead: number | undefined;

    constructor(draco: DracoDecoder) {
        this.draco = draco;
    }

    /** Undefined before it has arrived. */
    get header(): Header | undefined {
        return this.headerRead;
    }
    /** Of a sealed log. */
    get index(): readonly IndexRow[] | undefined {
        return this.indexRead;
    }
    /** Undefined before the base has arrived; later always the same object. */
    get mesh(): ProgressiveMesh | undefined {
        return this.meshRead;
    }
    /** Of the last whole frame: where a live stream goes on. */
    get lastSequence(): number | undefined {
        return this.sequenceRead;
    }
    /** Bytes of the log up to the end of the last whole header or frame. */
    get wholeBytes(): number {
        return this.consumed;
    }
    /** Whether the end frame has arrived. */
    get ended(): boolean {
        return this.order?.ended ?? false;
    }

    /**
     * Takes the next bytes of a log, of any length, and replays every frame that is whole by then, but no split beyond
     * the vertex budget.
     * @returns the frames that became whole
     * @throws DecodeError: the mesh stays as before the split or frame at fault, and every later call throws the same
     */
    feed(bytes: Uint8Array): Frame[] {
        return this.guarded(() => {
            this.queue.push(bytes);
            return this.takeWholeParts();
        });
    }

    /** As ProgressiveMesh.setMaxVertices(); the base need not be there yet. @throws DecodeError as feed() */
    setMaxVertices(maxVertices: number): void {
        this.guarded(() => {
            this.maxVertices = maxVertices;
            this.meshRead?.setMaxVertices(maxVertices);
        });
    }

    /** Runs a step that may throw; what was thrown once is thrown again by every later step. */
    private guarded<T>(step: () => T): T {
        if (this.failure) throw this.failure.error;
        try {
            return step();
        } catch (error) {
            this.failure = { error };
            throw error;
        }
    }

    private takeWholeParts(): Frame[] {
        const frames: Frame[] = [];
        this.takeHeader();
        while (this.order) {
            const bytes = this.queue.bytes;
            if (this.order.ended && bytes.length > 0) throw new DecodeError("bytes behind the end frame of the log");
            const frame = readFrame(bytes, this.consumed);
            if (!frame) break;
            this.takeFrame(this.order, frame, payloadOf(bytes, frame));
            this.drop(frameHeaderSize + frame.payloadBytes);
            frames.push(frame);
        }
        return frames;
    }

    private takeHeader(): void {
        const bytes = this.queue.bytes;
        if (this.order || bytes.length < headerSize || bytes.length < headerBytesNeeded(bytes)) return;
        this.headerRead = decodeHeader(bytes);
        this.order = new LogOrder(this.headerRead);
        this.drop(this.headerRead.headerBytes);
    }

    private takeFrame(order: LogOrder, frame: Frame, payload: Uint8Array): void {
        order.accept(frame);
        if (frame.type === FrameType.index) {
            this.indexRead = decodeIndexRows(payload);
            return;
        }
        if (frame.type === FrameType.base) {
            this.meshRead = new ProgressiveMesh(this.headerRead!, frame, payload, this.draco);
            this.meshRead.setMaxVertices(this.maxVertices);
        } else {
            this.meshRead!.apply(frame, payload);
        }
        this.sequenceRead = frame.sequence;
    }

    private drop(nBytes: number): void {
        this.queue.drop(nBytes);
        this.consumed += nBytes;
    }
}
