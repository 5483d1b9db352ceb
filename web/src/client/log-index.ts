import { ByteReader, startsWith } from "./byte-reader.js";
import { crc32c } from "./crc32c.js";
import { DecodeError } from "./decode-error.js";

/** One row per base, refine and colour frame, in file order. */
export interface IndexRow {
    /** After the frame. */
    readonly nVertices: number;
    /** End of the frame, counted from the first byte of the base frame. */
    readonly end: number;
    /** After the frame; NaN: unknown. */
    readonly meanDistortion: number;
    /** Of one face, alike. */
    readonly maxDistortion: number;
}

/** The rows of a live log, as a file of their own. */
export interface SideIndex {
    readonly logId: bigint;
    readonly rows: IndexRow[];
}

const rowSize = 16;
const crcSize = 4;
const sideIndexMagic = [0x89, 0x41, 0x52, 0x49, 0x0d, 0x0a, 0x1a, 0x0a]; // "\x89ARI\r\n\x1a\n"

/** The rows of an index frame. @throws DecodeError if the payload is no whole number of rows, or they decrease */
export function decodeIndexRows(payload: Uint8Array): IndexRow[] {
    if (payload.length % rowSize !== 0) {
        throw new DecodeError(`index: expected rows of ${rowSize} bytes, got ${payload.length} bytes`);
    }
    const reader = new ByteReader(payload, "index");
    const rows: IndexRow[] = [];
    while (reader.remaining > 0) {
        const row: IndexRow = {
            nVertices: reader.u32(),
            end: reader.u32(),
            meanDistortion: reader.f32(),
            maxDistortion: reader.f32(),
        };
        const before = rows.at(-1);
        if (before && (row.nVertices < before.nVertices || row.end < before.end)) {
            throw new DecodeError(`index row ${rows.length}: expected vertices and ends that never decrease`);
        }
        rows.push(row);
    }
    return rows;
}

/** The bytes of `<log>.idx` (proto/FORMAT.md, "Side index"). @throws DecodeError */
export function decodeSideIndex(bytes: Uint8Array): SideIndex {
    if (!startsWith(bytes, sideIndexMagic)) throw new DecodeError("side index: expected the magic bytes 89 'ARI'");
    const reader = new ByteReader(bytes, "side index");
    reader.take(sideIndexMagic.length);
    const logId = reader.u64();
    const nRows = reader.u32();
    reader.u32();
    const expected = nRows * rowSize + crcSize;
    if (reader.remaining !== expected) {
        throw new DecodeError(
            `side index: expected ${expected} bytes for ${nRows} rows, got ${reader.remaining}`,
        );
    }
    const rows = reader.take(nRows * rowSize);
    if (reader.u32() !== crc32c(bytes.subarray(0, bytes.length - crcSize))) {
        throw new DecodeError("side index: expected another checksum: the index is damaged");
    }
    return { logId, rows: decodeIndexRows(rows) };
}
