import assert from "node:assert/strict";

import { test } from "vitest";

import { decodeColour } from "../src/client/colour-codec.js";
import { DecodeError, loadDraco3d, readLayout } from "../src/client/index.js";
import { decodeRefine, noPreviousFace } from "../src/client/refine-codec.js";
import { encodePointCloud } from "./draco-encoder.js";
import { draco, octahedron } from "./golden.js";

function payloadOfFrame(sequence: number): Uint8Array {
    const frame = readLayout(octahedron).frames[sequence];
    return octahedron.slice(frame.begin + 28, frame.end);
}

const basePayload = payloadOfFrame(0);
const refinePayload = payloadOfFrame(2);

function refinePacket(gaps: number[]): Uint8Array {
    return encodePointCloud(gaps.length, [
        { nComponents: 1, values: gaps.map((gap) => (gap % 2 === 0 ? gap / 2 : -(gap + 1) / 2)) },
        { nComponents: 3, values: gaps.flatMap((_, i) => [i, 2, 3]) },
        { nComponents: 6, values: gaps.flatMap((_, i) => [-i, 2, 3, 4, 5, 6]) },
    ]);
}

function colourPacket(luma: number[], chroma: number[]): Uint8Array {
    return encodePointCloud(luma.length, [
        { nComponents: 1, values: luma },
        { nComponents: 2, values: chroma },
    ]);
}

test("Draco: the packet of the worked example holds the records that FORMAT.md lists", () => {
    assert.deepEqual(decodeRefine(refinePayload, 2, noPreviousFace, 8, draco), {
        faces: Int32Array.of(0, 6),
        residuals: Int32Array.of(9, 6, 9, 7, 8, 6),
        updates: Int32Array.of(10, 3, 3, 0, 6, 0, 0, 3, 2, -1, 0, 0),
    });
});

test("Draco: integers keep their order and their value up to 2^25 in magnitude", () => {
    const values = [0, -1, 2 ** 25, -(2 ** 25), 7, 7];
    const packet = encodePointCloud(3, [{ nComponents: 2, values }]);
    assert.deepEqual(draco.decodePointCloud(packet, 3, [2]), [Int32Array.from(values)]);
    const beyond = encodePointCloud(2, [{ nComponents: 1, values: [1, -(2 ** 25) - 1] }]);
    assert.throws(() => draco.decodePointCloud(beyond, 2, [1]), /expected integers of at most 2\^25/);
});

test("Draco: another layout than the expected one is refused before Draco sees it", () => {
    assert.throws(() => draco.decodePointCloud(refinePayload, 3, [1, 3, 6]), /expected 3 as points, got 2/);
    assert.throws(() => draco.decodePointCloud(refinePayload, 2, [1, 3]), /expected 2 as attributes, got 3/);
    assert.throws(() => draco.decodePointCloud(refinePayload, 2, [1, 3, 5]), /expected 5 as components, got 6/);
    assert.throws(() => draco.decodePointCloud(basePayload, 6, [3]), /a point cloud .* got version 2.2, type 1/);
    assert.throws(() => draco.decodeMesh(refinePayload, 6, 8), /expected a mesh/);
    assert.throws(() => draco.decodeMesh(basePayload, 7, 8), /expected 7 as vertices, got 6/);
    assert.throws(() => draco.decodeMesh(basePayload, 6, 10), /expected 10 as faces, got 8/);
    const reordering = refinePayload.slice();
    reordering[8] = 1; // kd-tree
    assert.throws(() => draco.decodePointCloud(reordering, 2, [1, 3, 6]), /expected a point cloud .* method 1/);
    const withMetadata = refinePayload.slice();
    withMetadata[10] = 0x80;
    assert.throws(() => draco.decodePointCloud(withMetadata, 2, [1, 3, 6]), /expected 0 as flags/);
});

test("Draco: a cut payload is refused or gives integers of the layout asked for", () => {
    for (let n = 0; n < refinePayload.length; ++n) {
        try {
            const columns = draco.decodePointCloud(refinePayload.subarray(0, n), 2, [1, 3, 6]);
            assert.deepEqual(columns.map((column) => column.length), [2, 6, 12]);
        } catch (error) {
            assert.ok(error instanceof DecodeError);
        }
    }
    for (let n = 0; n < basePayload.length; ++n) {
        assert.throws(() => draco.decodeMesh(basePayload.subarray(0, n), 6, 8), DecodeError);
    }
});

test("Draco: a payload that exhausts its memory stops that decoder for good, and no other", async () => {
    const hostile = encodePointCloud(1, [{ nComponents: 3, values: [1, 2, 3] }]);
    const nPoints = 2 ** 29;
    new DataView(hostile.buffer).setUint32(11, nPoints, true);
    const victim = await loadDraco3d();
    assert.throws(() => victim.decodePointCloud(hostile, nPoints, [3]), DecodeError);
    assert.throws(() => victim.decodePointCloud(refinePayload, 2, [1, 3, 6]), /load another/);
    draco.decodePointCloud(refinePayload, 2, [1, 3, 6]);
});

test("Refine packet: faces ascend from the gaps, and go on from the packet before", () => {
    const facesOf = (gaps: number[], previousFace: number) =>
        [...decodeRefine(refinePacket(gaps), gaps.length, previousFace, 2000, draco).faces];
    assert.deepEqual(facesOf([0, 0, 5, 1000], noPreviousFace), [0, 1, 7, 1008]);
    assert.deepEqual(facesOf([0, 3], 1008), [1009, 1013]);
});

test("Refine packet: a gap that leads beyond the faces that are there goes on from the first one", () => {
    // 20 faces, then 26, then 32: 15 + 1 + 12 = 28 is face 2 of the 26.
    assert.deepEqual([...decodeRefine(refinePacket([15, 12, 0]), 3, noPreviousFace, 20, draco).faces], [15, 2, 3]);
    assert.deepEqual([...decodeRefine(refinePacket([19, 25]), 2, noPreviousFace, 20, draco).faces], [19, 19]);
});

test("Refine packet: a gap that leads twice beyond the faces that are there is refused", () => {
    assert.throws(
        () => decodeRefine(refinePacket([0, 51]), 2, noPreviousFace, 20, draco),
        /record 1 names a face beyond the 26 that are there/,
    );
    assert.throws(() => decodeRefine(refinePacket([2 ** 26 - 1]), 1, noPreviousFace, 20, draco), /beyond the 20/);
});

test("Colour packet: residuals reach to 511 and no further", () => {
    const residuals = decodeColour(colourPacket([511, -511], [1, 2, 3, -511]), 2, draco);
    assert.deepEqual(residuals, { luma: Int32Array.of(511, -511), chroma: Int32Array.of(1, 2, 3, -511) });
    assert.throws(() => decodeColour(colourPacket([512], [0, 0]), 1, draco), /at most 511, got 512/);
    assert.throws(() => decodeColour(colourPacket([0], [0, -512]), 1, draco), /at most 511, got -512/);
});
