import assert from "node:assert/strict";

import { test } from "vitest";

import { decodeLog, FrameType, ModelDecoder, prefixFor, readLayout } from "../src/client/index.js";
import { triplesOfFormat } from "./format-text.js";
import {
    cube, cubeExpectations, draco, found, icosphere, icosphereExpectations, icospherePacked, octahedron, sphere,
    sphereExpectations,
} from "./golden.js";

test("Golden: every budget gives the mesh, the colours and the hash that C++ recorded", () => {
    assert.ok(icosphereExpectations.length > 10);
    for (const expected of icosphereExpectations) {
        for (const log of [icosphere, icospherePacked]) {
            const { mesh } = decodeLog(log, draco, { vertices: expected.budget });
            assert.deepEqual(found(expected.budget, mesh), expected);
        }
    }
});

for (const [name, log, flipRule, expectations] of [
    ["cube", cube, 2, cubeExpectations],
    ["sphere", sphere, 3, sphereExpectations],
] as const) {
    test(`Golden: later rules, recorded on a ${name}, are those of C++`, () => {
        const { header } = readLayout(log);
        assert.deepEqual([header.rules.flipRule, header.rules.smoothing], [flipRule, 2]);
        for (const expected of expectations) {
            const { mesh } = decodeLog(log, draco, { vertices: expected.budget });
            assert.deepEqual(found(expected.budget, mesh), expected);
        }
    });
}

test("Golden: a budget that is raised step by step gives the same as one that is set at once", () => {
    for (const log of [icosphere, icospherePacked]) {
        const decoder = new ModelDecoder(draco);
        decoder.setMaxVertices(icosphereExpectations[0].budget);
        decoder.feed(log);
        for (const expected of icosphereExpectations) {
            decoder.setMaxVertices(expected.budget);
            assert.deepEqual(found(expected.budget, decoder.mesh!), expected);
        }
    }
});

test("Golden: the prefix that the index names is all that a vertex budget needs", () => {
    for (const log of [icosphere, icospherePacked]) {
        const { index, framesBegin } = readLayout(log);
        for (const expected of icosphereExpectations) {
            const decoder = new ModelDecoder(draco);
            decoder.setMaxVertices(expected.budget);
            decoder.feed(log.subarray(0, prefixFor({ vertices: expected.budget }, index, framesBegin).nBytes));
            assert.deepEqual(found(expected.budget, decoder.mesh!), expected);
        }
    }
});

test("Golden: bytes that come one by one give the same mesh, and every frame's hash is passed on the way", () => {
    for (const log of [octahedron, icosphere, icospherePacked, cube, sphere]) {
        const decoder = new ModelDecoder(draco);
        const frames = Array.from(log, (_, i) => decoder.feed(log.subarray(i, i + 1))).flat();
        assert.deepEqual(frames.map((frame) => frame.end), readLayout(log).frames.map((frame) => frame.end));
        assert.equal(decoder.ended, true);
        assert.equal(decoder.wholeBytes, log.length);
        assert.deepEqual(found(0, decoder.mesh!), found(0, decodeLog(log, draco).mesh));
    }
});

test("Golden: the state after every frame has the hash that the frame states", () => {
    for (const log of [octahedron, icosphere, icospherePacked, cube, sphere]) {
        const decoder = new ModelDecoder(draco);
        let fed = 0;
        for (const frame of readLayout(log).frames) {
            decoder.feed(log.subarray(fed, frame.end));
            fed = frame.end;
            if (frame.type <= FrameType.refine) assert.equal(decoder.mesh!.stateHash, frame.hash);
            if (frame.type !== FrameType.index) assert.equal(decoder.mesh!.nVertices, frame.nVerticesAfter);
        }
    }
});

test("Golden: the worked example of FORMAT.md is what this reader computes", () => {
    const states = [
        { budget: 8, sentence: "The base as decoded", vertices: 6, hash: 0x7b3f27f1 },
        { budget: 11, sentence: "After the first split", vertices: 9, hash: 0x1735f175 },
        { budget: 12, sentence: "After the second", vertices: 12, hash: 0x1cc5311a },
    ];
    for (const { budget, sentence, vertices, hash } of states) {
        const { mesh } = decodeLog(octahedron, draco, { vertices: budget });
        const listed = triplesOfFormat(sentence);
        assert.deepEqual([...mesh.positions], listed.slice(0, vertices).flat());
        assert.deepEqual([...mesh.triangles], listed.slice(vertices).flat());
        assert.equal(mesh.stateHash, hash);
    }
    const ofBase = triplesOfFormat("Colour residuals (luma, Co, Cg) of the base").slice(6);
    const ofNew = triplesOfFormat("Colour residuals of vertices 6 to 11").slice(6);
    assert.deepEqual([...decodeLog(octahedron, draco).mesh.colours], [...ofBase, ...ofNew].flat());
});

test("Golden: world positions are origin + unit x integer", () => {
    const { mesh, layout } = decodeLog(octahedron, draco);
    const { origin, unit } = layout.header.grid;
    assert.deepEqual([origin, unit], [[-1, -1, -1], 2 / 1024]);
    const world = [...mesh.positions].map((x) => x / 512 - 1);
    assert.deepEqual([...mesh.worldPositions()], world); // small binary fractions: exact in 32 bits
});
