import { DecodeError } from "./decode-error.js";
import { FrameType, hasIndexRow, payloadOf, readFrame } from "./frame.js";
import type { Frame } from "./frame.js";
import { decodeHeader } from "./header.js";
import type { Header } from "./header.js";
import { decodeIndexRows } from "./log-index.js";
import type { IndexRow } from "./log-index.js";
import { LogOrder } from "./log-order.js";

/** A frame and what its place in the log says about it. */
export interface LogFrame extends Frame {
    /** Of index frames 0. */
    readonly nVerticesAfter: number;
}

/** What a log's framing says, without decoding a payload. */
export interface LogLayout {
    readonly header: Header;
    /** Of a sealed log; rebuilt from the frames (NaN distortion) where there is none. */
    readonly index: readonly IndexRow[];
    /** Offset of the base frame in the file. */
    readonly framesBegin: number;
    /** Whole frames only, in file order (index and end frames too). */
    readonly frames: readonly LogFrame[];
    /** The file is sound up to here; less than its size if it was cut. */
    readonly wholeBytes: number;
    /** Whether an end frame was there. */
    readonly ended: boolean;
    /** If the file was cut inside a frame, a sentence that says where. */
    readonly cut: string | undefined;
}

/**
 * Walks header and frames and checks every checksum. A log that is cut inside a frame gives the frames before it.
 * @throws DecodeError if the header is not whole and sound, a whole frame's checksum or order is wrong, or a sealed
 *         log's index does not tell what its frames are
 */
export function readLayout(log: Uint8Array): LogLayout {
    const header = decodeHeader(log);
    const order = new LogOrder(header);
    const frames: LogFrame[] = [];
    let indexRead: IndexRow[] | undefined;
    let framesBegin = header.headerBytes;
    let wholeBytes = header.headerBytes;
    for (;;) {
        const rest = log.subarray(wholeBytes);
        if (order.ended && rest.length > 0) throw new DecodeError("bytes behind the end frame of the log");
        const frame = readFrame(rest, wholeBytes);
        if (!frame) break;
        frames.push({ ...frame, nVerticesAfter: order.accept(frame) });
        wholeBytes = frame.end;
        if (frame.type === FrameType.index) {
            indexRead = decodeIndexRows(payloadOf(rest, frame));
            framesBegin = frame.end;
        }
    }
    const rows = rowsOf(frames, framesBegin);
    if (indexRead) checkIndex(indexRead, rows, order.ended);
    return {
        header,
        index: indexRead ?? rows,
        framesBegin,
        frames,
        wholeBytes,
        ended: order.ended,
        cut:
            wholeBytes < log.length
                ? `cut inside the frame at offset ${wholeBytes}, behind ${frames.length} whole frames`
                : undefined,
    };
}

function rowsOf(frames: readonly LogFrame[], framesBegin: number): IndexRow[] {
    return frames
        .filter((frame) => hasIndexRow(frame.type))
        .map((frame) => ({
            nVertices: frame.nVerticesAfter,
            end: frame.end - framesBegin,
            meanDistortion: NaN,
            maxDistortion: NaN,
        }));
}

/** A sealed log's index must tell what its frames are; it may know more of them than a cut file has. */
function checkIndex(index: readonly IndexRow[], found: readonly IndexRow[], ended: boolean): void {
    const fits = ended ? index.length === found.length : index.length >= found.length;
    const differs = (row: IndexRow, i: number) => row.nVertices !== index[i].nVertices || row.end !== index[i].end;
    if (!fits || found.some(differs)) throw new DecodeError("index: its rows are not those of the frames behind it");
}
