import { ByteQueue } from "./byte-queue.js";
import { DecodeError } from "./decode-error.js";
import { frameHeaderSize, FrameType, hasIndexRow, payloadOf, readFrame } from "./frame.js";
import type { Frame } from "./frame.js";
import { decodeHeader, headerBytesNeeded, headerSize } from "./header.js";
import type { Header } from "./header.js";
import { decodeIndexRows } from "./log-index.js";
import type { IndexRow } from "./log-index.js";
import { LogOrder } from "./log-order.js";

/** A frame that is whole, in order, and has the checksum it should have. */
export interface ScannedFrame {
    readonly frame: Frame;
    /** A view, valid until the next push(). */
    readonly payload: Uint8Array;
}

/** Finds the header and the frames of a log in bytes that arrive in pieces of any length. Decodes no payload. */
export class LogScanner {
    private readonly queue = new ByteQueue();
    private order: LogOrder | undefined;
    private consumed = 0;
    private framesBegin: number | undefined;
    private headerRead: Header | undefined;
    private indexRead: readonly IndexRow[] | undefined;
    private sequenceRead: number | undefined;
    private readonly rowsSeen: IndexRow[] = [];

    /** Undefined before it has arrived. */
    get header(): Header | undefined {
        return this.headerRead;
    }
    /** Of a sealed log. */
    get index(): readonly IndexRow[] | undefined {
        return this.indexRead;
    }
    /** One row per base, refine and colour frame that has arrived, as an index has them, without distortions. */
    get rows(): readonly IndexRow[] {
        return this.rowsSeen;
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

    push(bytes: Uint8Array): void {
        this.queue.push(bytes);
    }

    /** Forgets the beginning of a frame that is not whole: the frame is going to be sent again from its start. */
    dropPartialFrame(): void {
        this.queue.drop(this.queue.bytes.length);
    }

    /**
     * The next frame, index and end frames too; undefined while it is not whole.
     * @throws DecodeError if the bytes are no sound log; the scanner is then of no more use
     */
    next(): ScannedFrame | undefined {
        this.takeHeader();
        if (!this.order) return undefined;
        const bytes = this.queue.bytes;
        if (this.order.ended && bytes.length > 0) throw new DecodeError("bytes behind the end frame of the log");
        const frame = readFrame(bytes, this.consumed);
        if (!frame) return undefined;
        const payload = payloadOf(bytes, frame);
        const nVertices = this.order.accept(frame);
        if (frame.type === FrameType.index) this.indexRead = decodeIndexRows(payload);
        else this.note(frame, nVertices);
        this.drop(frameHeaderSize + frame.payloadBytes);
        return { frame, payload };
    }

    private takeHeader(): void {
        const bytes = this.queue.bytes;
        if (this.order || bytes.length < headerSize || bytes.length < headerBytesNeeded(bytes)) return;
        this.headerRead = decodeHeader(bytes);
        this.order = new LogOrder(this.headerRead);
        this.drop(this.headerRead.headerBytes);
    }

    private note(frame: Frame, nVertices: number): void {
        this.sequenceRead = frame.sequence;
        this.framesBegin ??= frame.begin;
        if (!hasIndexRow(frame.type)) return;
        const end = frame.end - this.framesBegin;
        this.rowsSeen.push({ nVertices, end, meanDistortion: NaN, maxDistortion: NaN });
    }

    private drop(nBytes: number): void {
        this.queue.drop(nBytes);
        this.consumed += nBytes;
    }
}
