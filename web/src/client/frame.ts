import { ByteReader } from "./byte-reader.js";
import { crc32c } from "./crc32c.js";
import { DecodeError } from "./decode-error.js";
import { maxPayloadBytes, maxRefinePayloadBytes, maxSplitsPerFrame } from "./limits.js";

export const FrameType = { base: 0, refine: 1, index: 2, end: 3, colour: 4 } as const;

/** The 28 bytes in front of every payload (proto/FORMAT.md, "Frame"), and where they stand. */
export interface Frame {
    /** A value of FrameType, or what a later minor version adds. */
    readonly type: number;
    readonly flags: number;
    readonly payloadBytes: number;
    readonly sequence: number;
    readonly nVerticesBefore: number;
    readonly nSplits: number;
    /** State hash after the frame; of a colour frame the colour hash. */
    readonly hash: number;
    /** Offset of the frame header in the file. */
    readonly begin: number;
    /** Offset of the first byte behind the payload. */
    readonly end: number;
}

export const frameHeaderSize = 28;
/** Refine: the face gaps start again. */
export const flagNewBatch = 0x01;
/** The geometry does not need this frame. */
export const flagAncillary = 0x80;
/** Of an index frame, which is outside of the sequence. */
export const indexSequence = 0xffffffff;

const syncWord = 0x4c50;
const crcOffset = 24;

export function frameTypeName(type: number): string {
    return ["base", "refine", "index", "end", "colour"][type] ?? `unknown (${type})`;
}

/** Whether the index has a row for frames of this type. */
export function hasIndexRow(type: number): boolean {
    return type === FrameType.base || type === FrameType.refine || type === FrameType.colour;
}

/**
 * The frame that starts at bytes[0]; undefined while it is not whole.
 * @param begin offset of bytes[0] in the file
 * @throws DecodeError if no frame can start there, or its checksum is wrong
 */
export function readFrame(bytes: Uint8Array, begin: number): Frame | undefined {
    if (bytes.length < frameHeaderSize) return undefined;
    const reader = new ByteReader(bytes, "frame");
    const sync = reader.u16();
    if (sync !== syncWord) fail(begin, `the sync bytes 50 4c, got ${hex(sync & 0xff)} ${hex(sync >> 8)}`);
    const type = reader.u8();
    const flags = reader.u8();
    const payloadBytes = reader.u32();
    const frame: Frame = {
        type,
        flags,
        payloadBytes,
        sequence: reader.u32(),
        nVerticesBefore: reader.u32(),
        nSplits: reader.u32(),
        hash: reader.u32(),
        begin,
        end: begin + frameHeaderSize + payloadBytes,
    };
    const storedCrc = reader.u32();
    checkLimits(frame);
    if (payloadBytes > reader.remaining) return undefined;
    if (storedCrc !== crc32c(payloadOf(bytes, frame), crc32c(bytes.subarray(0, crcOffset)))) {
        fail(begin, "another checksum: the frame is damaged");
    }
    return frame;
}

/** The payload of the whole frame that starts at bytes[0]: a view, not a copy. */
export function payloadOf(bytes: Uint8Array, frame: Frame): Uint8Array {
    return bytes.subarray(frameHeaderSize, frameHeaderSize + frame.payloadBytes);
}

function checkLimits(frame: Frame): void {
    const isRefine = frame.type === FrameType.refine;
    const limit = isRefine ? maxRefinePayloadBytes : maxPayloadBytes;
    if (frame.payloadBytes > limit) fail(frame.begin, `at most ${limit} payload bytes, got ${frame.payloadBytes}`);
    if (isRefine && (frame.nSplits < 1 || frame.nSplits > maxSplitsPerFrame)) {
        fail(frame.begin, `1 to ${maxSplitsPerFrame} splits, got ${frame.nSplits}`);
    }
}

function hex(byte: number): string {
    return byte.toString(16).padStart(2, "0");
}

function fail(begin: number, expectation: string): never {
    throw new DecodeError(`frame at offset ${begin}: expected ${expectation}`);
}
