import { ByteReader, startsWith } from "./byte-reader.js";
import { crc32c } from "./crc32c.js";
import { DecodeError } from "./decode-error.js";
import { maxLogFaces, maxLogVertices } from "./limits.js";

/** The integer grid that both ends compute on: world = origin + unit * integer, integers in [0, 2^bits). */
export interface Grid {
    readonly origin: readonly [number, number, number];
    /** World units of one grid step. */
    readonly unit: number;
    readonly bits: number;
    /** Base positions are multiples of 2^baseShift. */
    readonly baseShift: number;
}

/** The rules of the operation that a log may choose. */
export interface RefinementRules {
    /** 1: Delaunay; 2: the same, but creases stay (proto/FORMAT.md, "Flip"). */
    readonly flipRule: number;
    /** Of the six vertices around a split face; 1: by a quarter, 2: by a sixteenth. */
    readonly smoothing: number;
    /** A scalar's step is the power of two of grid units nearest to edge / stepRatio. */
    readonly stepRatio: number;
}

/** Quantiser steps of colour residuals, 8-bit units. */
export interface ColourSteps {
    readonly luma: number;
    readonly chroma: number;
}

/** The first bytes of a log (proto/FORMAT.md, "Header"). */
export interface Header {
    readonly major: number;
    readonly minor: number;
    /** More than headerSize in a log of a later minor version. */
    readonly headerBytes: number;
    /** Any value, the same for every form of one model. */
    readonly logId: bigint;
    readonly grid: Grid;
    readonly rules: RefinementRules;
    readonly nBaseVertices: number;
    readonly nBaseFaces: number;
    /** Whether an index frame stands behind the header. */
    readonly sealed: boolean;
    readonly colourSteps: ColourSteps;
}

/** Bytes of the header that this version knows; a log is never shorter. */
export const headerSize = 96;

const magic = [0x89, 0x41, 0x52, 0x4c, 0x0d, 0x0a, 0x1a, 0x0a]; // "\x89ARL\r\n\x1a\n"
const thisMajor = 1;
const maxHeaderSize = 4096;
const crcOffset = 92;
const flagSealed = 1;

/**
 * How many bytes decodeHeader() needs, told by the first 16 of a log.
 * @throws DecodeError if they start no log of this major version
 */
export function headerBytesNeeded(bytes: Uint8Array): number {
    require(startsWith(bytes, magic), "the magic bytes 89 'ARL' of a log");
    const reader = new ByteReader(bytes, "header");
    reader.take(magic.length);
    const major = reader.u16();
    require(major === thisMajor, `major version ${thisMajor}, got ${major}: a newer reader is needed`);
    reader.u16();
    const size = reader.u32();
    require(size >= headerSize && size <= maxHeaderSize, `${headerSize} to ${maxHeaderSize} header bytes, got ${size}`);
    return size;
}

/**
 * @param log a log from its start; what lies behind the header is not looked at
 * @throws DecodeError if the header is not whole, not sound, or of another major version
 */
export function decodeHeader(log: Uint8Array): Header {
    const size = headerBytesNeeded(log);
    require(log.length >= size, `${size} bytes, got ${log.length}`);
    const bytes = log.subarray(0, size);
    checkCrc(bytes);

    const reader = new ByteReader(bytes, "header");
    reader.take(magic.length);
    const header: Header = {
        major: reader.u16(),
        minor: reader.u16(),
        headerBytes: reader.u32(),
        logId: reader.u64(),
        grid: {
            origin: [reader.f64(), reader.f64(), reader.f64()],
            unit: reader.f64(),
            bits: reader.u8(),
            baseShift: reader.u8(),
        },
        rules: takeRules(reader),
        nBaseVertices: reader.u32(),
        nBaseFaces: reader.u32(),
        sealed: (reader.u32() & flagSealed) !== 0,
        colourSteps: { luma: reader.u8(), chroma: reader.u8() },
    };
    checkLimits(header);
    return header;
}

/** The checksum does not cover itself, but the tail that a later minor version may add. */
function checkCrc(header: Uint8Array): void {
    const stored = new ByteReader(header.subarray(crcOffset), "header").u32();
    const computed = crc32c(header.subarray(headerSize), crc32c(header.subarray(0, crcOffset)));
    require(stored === computed, "another checksum: the header is damaged");
}

function takeRules(reader: ByteReader): RefinementRules {
    const takeRule = (rule: string, lastKnown: number): number => {
        const id = reader.u8();
        const known = lastKnown === 1 ? "1" : `1 to ${lastKnown}`;
        require(id >= 1 && id <= lastKnown, `${rule} ${known}, got ${id}`);
        return id;
    };
    takeRule("predictor", 1);
    const flipRule = takeRule("flip rule", 3);
    const smoothing = takeRule("smoothing", 2);
    takeRule("update mode", 1);
    return { flipRule, smoothing, stepRatio: reader.u16() };
}

function checkLimits({ grid, rules, nBaseVertices, nBaseFaces, colourSteps }: Header): void {
    const { bits, baseShift, origin, unit } = grid;
    require(bits >= 1 && bits <= 20, `1 to 20 grid bits, got ${bits}`);
    require(baseShift < bits, `a base shift below the grid bits, got ${baseShift}`);
    require(origin.every(Number.isFinite) && Number.isFinite(unit) && unit > 0, "a finite origin and a positive unit");
    require(rules.stepRatio >= 1, "a step ratio of 1 to 65535");
    require(nBaseVertices >= 4 && nBaseVertices <= maxLogVertices, `4 to 2^24 base vertices, got ${nBaseVertices}`);
    require(
        nBaseFaces >= 4 && nBaseFaces <= maxLogFaces && nBaseFaces % 2 === 0,
        `4 to 2^25 base faces, an even number, got ${nBaseFaces}`,
    );
    require(colourSteps.luma >= 1 && colourSteps.chroma >= 1, "colour steps of 1 to 255");
}

function require(holds: boolean, expectation: string): void {
    if (!holds) throw new DecodeError(`header: expected ${expectation}`);
}
