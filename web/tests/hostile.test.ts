// Damaged logs end in a DecodeError or in the mesh of an undamaged prefix; hostile ones, whose checksums hold, in a
// DecodeError or in a mesh that has the hash its log states.
import assert from "node:assert/strict";
import { setImmediate as tick } from "node:timers/promises"; // lets the runner hear that a long test goes on

import { test } from "vitest";

import { frameHeaderSize, hasIndexRow } from "../src/client/frame.js";
import { DecodeError, decodeLog, FrameType, loadDraco3d, ModelDecoder, readLayout } from "../src/client/index.js";
import type { DecodedLog, DracoDecoder } from "../src/client/index.js";
import { concatenated, cube, draco, found, icosphere, icospherePacked, octahedron, rewritten, sphere } from "./golden.js";

/** The mesh of a log; undefined if it was refused as it should be. */
function decodedOrRefused(log: Uint8Array, decoder: DracoDecoder = draco): DecodedLog | undefined {
    try {
        return decodeLog(log, decoder);
    } catch (error) {
        if (error instanceof DecodeError) return undefined;
        throw error;
    }
}

/** Decodes a log that was cut, and checks that this is known and that the mesh is the one of the last whole frame. */
function checkCut(log: Uint8Array, nBytes: number): void {
    const whole = readLayout(log);
    const before = whole.frames.filter((frame) => frame.end <= nBytes);
    const result = decodedOrRefused(log.subarray(0, nBytes));
    const hasBase = before.some((frame) => frame.type === FrameType.base);
    assert.equal(result !== undefined, hasBase, `cut at ${nBytes}`);
    if (!result) return;
    const last = before[before.length - 1];
    assert.equal(result.mesh.nVertices, last.nVerticesAfter);
    assert.equal(result.layout.wholeBytes, last.end);
    assert.equal(result.layout.cut !== undefined, last.end < nBytes);
    assert.equal(result.layout.ended, nBytes === log.length);
    const geometry = before.filter((frame) => frame.type <= FrameType.refine).pop()!;
    assert.equal(result.mesh.stateHash, geometry.hash);
}

test("Hostile bytes: the octahedron cut anywhere is refused or decodes to its last whole frame, and says so", async () => {
    for (let nBytes = 0; nBytes <= octahedron.length; ++nBytes, await tick()) checkCut(octahedron, nBytes);
});

test("Hostile bytes: an icosphere cut anywhere is refused or known to be cut behind its whole frames", async () => {
    for (const log of [icosphere, icospherePacked]) await checkEveryCut(log);
});

async function checkEveryCut(log: Uint8Array): Promise<void> {
    const { frames, header } = readLayout(log);
    for (let nBytes = 0; nBytes < log.length; ++nBytes, await tick()) {
        const cut = log.subarray(0, nBytes);
        if (nBytes < header.headerBytes) {
            assert.throws(() => readLayout(cut), DecodeError);
            continue;
        }
        const layout = readLayout(cut);
        assert.deepEqual(layout.frames, frames.filter((frame) => frame.end <= nBytes));
        assert.equal(layout.cut !== undefined, layout.wholeBytes < nBytes);
        assert.equal(layout.ended, false);
    }
}

test("Hostile bytes: an icosphere cut at and around its last frames decodes to its last whole frame", async () => {
    for (const log of [icosphere, icospherePacked]) {
        const ends = readLayout(log).frames.map((frame) => frame.end);
        for (const end of ends.slice(-20)) {
            for (const nBytes of [end - 1, end, end + 27]) checkCut(log, Math.min(nBytes, log.length));
            await tick();
        }
    }
});

test("Hostile bytes: a cut is described by its offset and the frames before", () => {
    const { layout } = decodeLog(octahedron.subarray(0, 300), draco);
    assert.equal(layout.cut, "cut inside the frame at offset 291, behind 2 whole frames");
    assert.throws(() => decodeLog(octahedron.subarray(0, 150), draco), /no base; cut inside the frame at offset 96/);
});

test("Hostile bytes: no flipped bit of the octahedron goes unnoticed", async () => {
    const expected = readLayout(octahedron);
    let refused = 0;
    for (let bit = 0; bit < 8 * octahedron.length; ++bit, await tick()) {
        const damaged = octahedron.slice();
        damaged[bit >> 3] ^= 1 << (bit & 7);
        const result = decodedOrRefused(damaged);
        if (!result) {
            ++refused;
            continue;
        }
        // A length that leads beyond the file looks like a cut: the frames before are sound.
        assert.ok(result.layout.cut !== undefined, `bit ${bit}`);
        const last = result.layout.frames[result.layout.frames.length - 1];
        assert.deepEqual(last, expected.frames[result.layout.frames.length - 1]);
    }
    assert.ok(refused > 8 * octahedron.length * 0.95);
});

test("Hostile bytes: no flipped bit of a larger log goes unnoticed by its framing", async () => {
    for (const log of [icosphere, icospherePacked, cube, sphere]) {
        const damaged = log.slice();
        for (let bit = 0; bit < 8 * log.length; ++bit) {
            if (bit % 64 === 0) await tick();
            damaged[bit >> 3] ^= 1 << (bit & 7);
            try {
                const layout = readLayout(damaged); // decodeLog() starts with it
                assert.ok(layout.cut !== undefined, `bit ${bit}`);
            } catch (error) {
                assert.ok(error instanceof DecodeError, `bit ${bit}: ${String(error)}`);
            }
            damaged[bit >> 3] ^= 1 << (bit & 7);
        }
    }
});

test("Hostile bytes: a payload's flipped bit under sound checksums is refused or changes nothing", async () => {
    const sound = found(0, decodeLog(octahedron, draco).mesh);
    const { frames } = readLayout(octahedron);
    let decoder = await loadDraco3d();
    for (const { begin, end } of frames) {
        for (let bit = 8 * (begin + frameHeaderSize); bit < 8 * end; ++bit, await tick()) {
            const hostile = rewritten(octahedron, (bytes) => (bytes[bit >> 3] ^= 1 << (bit & 7)));
            const result = decodedOrRefused(hostile, decoder);
            if (result) assert.deepEqual(found(0, result.mesh), sound, `bit ${bit}`);
            else if (!decodedOrRefused(octahedron, decoder)) decoder = await loadDraco3d(); // it was stopped
        }
    }
});

/** Numbers 0 .. n - 1 without a pattern, the same in every run. */
function pseudorandom(seed: number): (n: number) => number {
    return (n) => Math.floor(((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 32) * n);
}

test("Hostile bytes: random payloads under sound checksums are refused", async () => {
    const random = pseudorandom(1);
    const { frames } = readLayout(icosphere);
    const firstBehindDracoHeader = frameHeaderSize + 11;
    for (const frame of frames.filter(({ type }) => hasIndexRow(type)).slice(0, 40)) {
        const hostile = rewritten(icosphere, (bytes) => {
            for (let i = frame.begin + firstBehindDracoHeader; i < frame.end; ++i) bytes[i] = random(256);
        });
        assert.equal(decodedOrRefused(hostile), undefined, `frame ${frame.sequence}`);
        await tick();
    }
});

/** What is left when a log has been fed in pieces of so many bytes, as far as it was not refused. */
function stateAfter(log: Uint8Array, piece: number): unknown {
    const decoder = new ModelDecoder(draco);
    let refused: string | undefined;
    try {
        for (let i = 0; i < log.length; i += piece) decoder.feed(log.subarray(i, i + piece));
    } catch (error) {
        assert.ok(error instanceof DecodeError, String(error));
        refused = error.message;
        assert.throws(() => decoder.feed(new Uint8Array(0)), error, "every later call throws the same");
    }
    return { refused, ended: decoder.ended, mesh: decoder.mesh && found(0, decoder.mesh) };
}

test("Hostile bytes: a changed byte anywhere under sound checksums ends alike, fed at once or in pieces", async () => {
    const random = pseudorandom(2);
    for (const [log, times] of [[octahedron, 500], [icosphere, 100], [icospherePacked, 100]] as const) {
        for (let i = 0; i < times; ++i, await tick()) {
            const [at, change] = [random(log.length), 1 + random(255)];
            const hostile = rewritten(log, (bytes) => (bytes[at] ^= change));
            const piece = 1 + random(400);
            assert.deepEqual(stateAfter(hostile, piece), stateAfter(hostile, hostile.length), `byte ${at} ^ ${change}`);
        }
    }
    decodeLog(octahedron, draco); // Draco has survived it: nothing was refused only because it had stopped
});

test("Hostile bytes: a frame whose state hash is another is refused", () => {
    const { frames } = readLayout(octahedron);
    for (const frame of frames) {
        const hostile = rewritten(octahedron, (_, view) => view.setUint32(frame.begin + 20, frame.hash ^ 1, true));
        assert.throws(() => decodeLog(hostile, draco), DecodeError);
    }
});

test("Hostile bytes: bytes behind the end are refused", () => {
    for (const more of [[0], [...octahedron.subarray(0x1fd)]]) {
        assert.throws(() => decodeLog(concatenated(octahedron, Uint8Array.from(more)), draco), /behind the end frame/);
    }
});

test("Hostile bytes: what is no log is refused", () => {
    for (const bytes of [new Uint8Array(0), new Uint8Array(1000), new TextEncoder().encode("<!DOCTYPE html>")]) {
        assert.throws(() => decodeLog(bytes, draco), /header: expected the magic bytes/);
    }
});

test("Hostile bytes: a base that claims many vertices or faces is refused before they are allocated", () => {
    for (const [offset, count] of [[64, 2 ** 24], [68, 2 ** 25]] as const) {
        const upToBase = octahedron.subarray(0, 0xbe);
        const hostile = rewritten(upToBase, (_, view) => view.setUint32(offset, count, true));
        assert.throws(() => decodeLog(hostile, draco), /base: 66 bytes cannot hold/);
    }
});
