// Header, frames, their order and the index: what proto/FORMAT.md allows and what it refuses.
import assert from "node:assert/strict";

import { test } from "vitest";

import { crc32c } from "../src/client/crc32c.js";
import { decodeHeader, decodeLog, decodeSideIndex, prefixFor, readLayout } from "../src/client/index.js";
import type { Budget, IndexRow } from "../src/client/index.js";
import { concatenated, draco, found, icosphere, octahedron, rewritten } from "./golden.js";

const header = octahedron.slice(0, 96);

/** The octahedron's header with other bytes somewhere, under a sound checksum. */
function headerWith(change: (view: DataView) => void): Uint8Array {
    return rewritten(header, (_, view) => change(view));
}

/** Frames of the octahedron by number, behind its header, each with what `change` makes of it. */
function logOf(frames: readonly number[], change: (view: DataView, i: number) => void = () => {}): Uint8Array {
    const all = readLayout(octahedron).frames;
    const parts = frames.map((n, i) => {
        const frame = octahedron.slice(all[n].begin, all[n].end);
        const view = new DataView(frame.buffer);
        change(view, i);
        view.setUint32(24, crc32c(frame.subarray(28), crc32c(frame.subarray(0, 24))), true);
        return frame;
    });
    return concatenated(header, ...parts);
}

/** Numbers the frames as they stand. */
const renumbered = (view: DataView, i: number) => view.setUint32(8, i, true);

test("CRC-32C: the check value of the catalogue, in one piece or two", () => {
    const digits = new TextEncoder().encode("123456789");
    assert.equal(crc32c(digits), 0xe3069283);
    assert.equal(crc32c(digits.subarray(4), crc32c(digits.subarray(0, 4))), 0xe3069283);
    assert.equal(crc32c(new Uint8Array(0)), 0);
});

test("Header: the fields of the worked example", () => {
    assert.deepEqual(decodeHeader(octahedron), {
        major: 1,
        minor: 0,
        headerBytes: 96,
        logId: 0x0123456789abcdefn,
        grid: { origin: [-1, -1, -1], unit: 2 / 1024, bits: 10, baseShift: 2 },
        rules: { flipRule: 1, smoothing: 1, stepRatio: 80 },
        nBaseVertices: 6,
        nBaseFaces: 8,
        sealed: false,
        colourSteps: { luma: 4, chroma: 6 },
    });
});

test("Header: what exceeds a limit is refused by name", () => {
    const refused: [RegExp, (view: DataView) => void][] = [
        [/major version 1, got 2: a newer reader is needed/, (view) => view.setUint16(8, 2, true)],
        [/96 to 4096 header bytes, got 95/, (view) => view.setUint32(12, 95, true)],
        [/96 to 4096 header bytes, got 4097/, (view) => view.setUint32(12, 4097, true)],
        [/finite origin/, (view) => view.setFloat64(24, NaN, true)],
        [/positive unit/, (view) => view.setFloat64(48, 0, true)],
        [/positive unit/, (view) => view.setFloat64(48, Infinity, true)],
        [/1 to 20 grid bits, got 0/, (view) => view.setUint8(56, 0)],
        [/1 to 20 grid bits, got 21/, (view) => view.setUint8(56, 21)],
        [/base shift below the grid bits, got 10/, (view) => view.setUint8(57, 10)],
        [/predictor 1, got 2/, (view) => view.setUint8(58, 2)],
        [/flip rule 1 to 3, got 0/, (view) => view.setUint8(59, 0)],
        [/flip rule 1 to 3, got 4/, (view) => view.setUint8(59, 4)],
        [/smoothing 1 to 2, got 9/, (view) => view.setUint8(60, 9)],
        [/update mode 1, got 3/, (view) => view.setUint8(61, 3)],
        [/step ratio/, (view) => view.setUint16(62, 0, true)],
        [/base vertices, got 3/, (view) => view.setUint32(64, 3, true)],
        [/base vertices, got 16777217/, (view) => view.setUint32(64, 2 ** 24 + 1, true)],
        [/base faces, an even number, got 7/, (view) => view.setUint32(68, 7, true)],
        [/base faces, an even number, got 33554434/, (view) => view.setUint32(68, 2 ** 25 + 2, true)],
        [/colour steps/, (view) => view.setUint8(77, 0)],
    ];
    for (const [message, change] of refused) assert.throws(() => decodeHeader(headerWith(change)), message);
    assert.throws(() => decodeHeader(header.subarray(0, 95)), /96 bytes, got 95/);
});

test("Header: a later minor version may lengthen it and set what is reserved", () => {
    const longer = concatenated(header, Uint8Array.of(1, 2, 3, 4));
    const view = new DataView(longer.buffer);
    view.setUint16(10, 7, true);
    view.setUint32(12, 100, true);
    view.setUint32(72, 0xfffffffe, true);
    view.setUint8(80, 99);
    view.setUint32(92, crc32c(longer.subarray(96), crc32c(longer.subarray(0, 92))), true);
    const { mesh } = decodeLog(concatenated(longer, octahedron.subarray(96)), draco);
    assert.deepEqual(found(0, mesh), found(0, decodeLog(octahedron, draco).mesh));
    longer[99] = 5;
    assert.throws(() => decodeHeader(longer), /another checksum/);
});

test("Order: frames that miss, repeat, or stand where they may not are refused", () => {
    const refused: [RegExp, Uint8Array][] = [
        [/expected sequence number 1/, logOf([0, 2])],
        [/the base first, and once/, logOf([2, 3], renumbered)],
        [/the base first, and once/, logOf([0, 0], renumbered)],
        [/expected 12 vertices before, got 6/, logOf([0, 2, 2], renumbered)],
        [/the base or refine frame that it colours directly before/, logOf([0, 1, 1], renumbered)],
        [/the base or refine frame that it colours directly before/, logOf([0, 3], renumbered)],
        [/the vertices and the hash of the log/, logOf([0, 4], renumbered)],
        [/an index exactly behind the header of a sealed log/, logOf([0], (view) => {
            view.setUint8(2, 2);
            view.setUint32(8, 0xffffffff, true);
        })],
        [/the first packet to start a batch/, logOf([0, 2], (view, i) => {
            renumbered(view, i);
            view.setUint8(3, 0);
        })],
        [/no flag that this version does not know/, logOf([0], (view) => view.setUint8(3, 2))],
        [/the ancillary flag on colour frames only/, logOf([0], (view) => view.setUint8(3, 0x80))],
        [/no vertices before and no splits/, logOf([0], (view) => view.setUint32(12, 1, true))],
        [/1 to 2048 splits, got 2049/, logOf([0, 2], (view, i) => i === 1 && view.setUint32(16, 2049, true))],
        [/the sync bytes 50 4c, got 51 4c/, logOf([0], (view) => view.setUint8(0, 0x51))],
        [/a known frame type, or one that geometry does not need/, logOf([0, 1], (view, i) => {
            if (i === 1) view.setUint16(2, 5, true);
        })],
    ];
    for (const [message, log] of refused) assert.throws(() => decodeLog(log, draco), message);
});

test("Order: a frame of unknown type that geometry does not need is skipped, and counts", () => {
    const log = logOf([0, 1, 1, 2, 3, 4], (view, i) => {
        renumbered(view, i);
        if (i === 2) view.setUint8(2, 77);
    });
    assert.deepEqual(found(0, decodeLog(log, draco).mesh), found(0, decodeLog(octahedron, draco).mesh));
});

test("Order: a log without colours has none, and one with later colours only predicts the rest", () => {
    const { mesh } = decodeLog(logOf([0, 2, 4], renumbered), draco);
    assert.equal(mesh.hasColours, false);
    assert.equal(mesh.stateHash, 0x1cc5311a);
});

test("Index: a sealed log's rows must be those of its frames", () => {
    const { frames } = readLayout(icosphere);
    const lying = rewritten(icosphere, (_, view) => view.setUint32(frames[0].begin + 28, 41, true));
    assert.throws(() => readLayout(lying), /its rows are not those of the frames behind it/);
    const decreasing = rewritten(icosphere, (_, view) => view.setUint32(frames[0].begin + 28 + 16, 41, true));
    assert.throws(() => readLayout(decreasing), /index row 1: expected vertices and ends that never decrease/);
});

test("Index: a log without an index gets its rows from its frames", () => {
    const rows = readLayout(octahedron).index.map(({ nVertices, end }) => [nVertices, end]);
    assert.deepEqual(rows, [[6, 0xbe - 0x60], [6, 0x123 - 0x60], [12, 0x191 - 0x60], [12, 0x1fd - 0x60]]);
});

test("Side index: rows as in the log, refused if it is cut, lengthened or damaged", () => {
    const { frames, index } = readLayout(icosphere);
    const rows = icosphere.subarray(frames[0].begin + 28, frames[0].end);
    const side = new Uint8Array(24 + rows.length + 4);
    side.set([0x89, 0x41, 0x52, 0x49, 0x0d, 0x0a, 0x1a, 0x0a, 0xef, 0xcd]);
    const view = new DataView(side.buffer);
    view.setUint32(16, index.length, true);
    side.set(rows, 24);
    view.setUint32(24 + rows.length, crc32c(side.subarray(0, 24 + rows.length)), true);
    assert.deepEqual(decodeSideIndex(side), { logId: 0xcdefn, rows: index });

    for (let nBytes = 0; nBytes < side.length; ++nBytes) {
        assert.throws(() => decodeSideIndex(side.subarray(0, nBytes)), /side index: expected/);
    }
    assert.throws(() => decodeSideIndex(concatenated(side, Uint8Array.of(0))), /side index: expected/);
    for (let i = 0; i < side.length; ++i) {
        const damaged = side.slice();
        damaged[i] ^= 4;
        assert.throws(() => decodeSideIndex(damaged), /side index: expected/);
    }
});

test("Budget: the prefix ends at the frame that the rule names, with its colours", () => {
    const row = (nVertices: number, end: number, meanDistortion: number): IndexRow => ({
        nVertices,
        end,
        meanDistortion,
        maxDistortion: NaN,
    });
    // base, its colours, a batch of two packets with colours, one packet without
    const rows = [
        ...[row(100, 10, 9), row(100, 20, 9)],
        ...[row(130, 30, 9), row(130, 40, 9), row(160, 50, 5), row(160, 60, 5)],
        row(190, 70, 3),
    ];
    /** Number of rows for each of some amounts. */
    const nRows = (amounts: number[], budget: (amount: number) => Budget) =>
        amounts.map((amount) => prefixFor(budget(amount), rows, 1000).nRows);
    const counts = [0, 100, 102, 103, 132, 133, 162, 163, 192, 1e9];
    assert.deepEqual(nRows(counts, (vertices) => ({ vertices })), [2, 2, 2, 4, 4, 6, 6, 7, 7, 7]);
    const sizes = [0, 1020, 1029, 1030, 1059, 1069, 1070, 1e9];
    assert.deepEqual(nRows(sizes, (bytes) => ({ bytes })), [2, 2, 2, 3, 5, 6, 7, 7]);
    const distortions = [100, 9, 8.9, 5, 4, 3, 0];
    assert.deepEqual(nRows(distortions, (distortion) => ({ distortion })), [2, 2, 6, 6, 7, 7, 7]);
    assert.deepEqual(prefixFor({ vertices: 130 }, rows, 1000), { nRows: 4, nBytes: 1040 });
    assert.deepEqual(prefixFor({ vertices: 130 }, [], 1000), { nRows: 0, nBytes: 1000 });
    const unknown = rows.map(({ nVertices, end }) => row(nVertices, end, NaN));
    assert.equal(prefixFor({ distortion: 5 }, unknown, 1000).nRows, 7);
});
