import assert from "node:assert/strict";

import { test } from "vitest";

import { DecodeError } from "../src/client/index.js";
import { RefinableMesh } from "../src/client/refinable-mesh.js";
import type { SplitRecords } from "../src/client/refinable-mesh.js";
import { triplesOfFormat } from "./format-text.js";

const gridBits = 10;
const rules = { flipRule: 1, smoothing: 1, stepRatio: 80 };

/** The base of FORMAT.md's worked example. */
function octahedron(): RefinableMesh {
    const listed = triplesOfFormat("The base as decoded");
    const [positions, triangles] = [listed.slice(0, 6), listed.slice(6)].map((rows) => Int32Array.from(rows.flat()));
    return new RefinableMesh({ positions, triangles }, gridBits, rules);
}

function baseOf(nVertices: number, ...triangles: number[]): () => RefinableMesh {
    const base = { positions: new Int32Array(3 * nVertices), triangles: Int32Array.from(triangles) };
    return () => new RefinableMesh(base, gridBits, rules);
}

function record(face: number, residuals: number[], updates: number[]): SplitRecords {
    return { faces: Int32Array.of(face), residuals: Int32Array.from(residuals), updates: Int32Array.from(updates) };
}

function snapshot(mesh: RefinableMesh): unknown {
    const { nVertices, nFaces, corners, twins, outgoing, valences } = mesh.connectivity;
    return {
        hash: mesh.stateHash,
        positions: mesh.positions.slice(0, 3 * nVertices),
        corners: corners.slice(0, 3 * nFaces),
        twins: twins.slice(0, 3 * nFaces),
        outgoing: outgoing.slice(0, nVertices),
        valences: valences.slice(0, nVertices),
    };
}

const none = [0, 0, 0, 0, 0, 0];
const first = record(0, [9, 6, 9], [10, 3, 3, 0, 6, 0]);
const second = record(6, [7, 8, 6], [0, 3, 2, -1, 0, 0]);

test("RefinableMesh: the records of FORMAT.md lead to the hashes of FORMAT.md", () => {
    const mesh = octahedron();
    mesh.apply(first, 0);
    assert.equal(mesh.stateHash, 0x1735f175);
    mesh.apply(second, 0);
    assert.equal(mesh.stateHash, 0x1cc5311a);
});

test("RefinableMesh: a record that takes a vertex off the grid leaves no trace, whichever vertex it is", () => {
    const far = 2 ** 25;
    for (let slot = 0; slot < 9; ++slot) {
        const scalars = [...none, 0, 0, 0].map((_, i) => (i === slot ? far : 0));
        const mesh = octahedron();
        mesh.apply(first, 0);
        const before = snapshot(mesh);
        const bad = record(6, scalars.slice(0, 3), scalars.slice(3));
        assert.throws(() => mesh.apply(bad, 0), /expected vertex \d+ on the grid, the scalar 33554432 takes it off/);
        assert.deepEqual(snapshot(mesh), before);
        mesh.apply(second, 0);
        assert.equal(mesh.stateHash, 0x1cc5311a);
    }
});

test("RefinableMesh: a face that does not exist or cannot be split is refused", () => {
    const tetrahedron = baseOf(4, 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2)();
    assert.throws(() => tetrahedron.apply(record(0, [0, 0, 0], none), 0), DecodeError); // the apexes are one vertex
    assert.throws(() => octahedron().apply(record(8, [0, 0, 0], none), 0), /face 8 of 8 cannot be split/);
});

/** Two poles, each joined to all n vertices of an equator; without extent, so that nothing flips. */
function bipyramid(n: number): RefinableMesh {
    const equator = Array.from({ length: n }, (_, i) => [2 + i, 2 + ((i + 1) % n)]);
    return baseOf(n + 2, ...equator.flatMap(([p, q]) => [0, p, q, 1, q, p]))();
}

test("RefinableMesh: a split takes no vertex beyond 64 edges", () => {
    assert.throws(() => bipyramid(64).apply(record(0, [0, 0, 0], none), 0), /face 0 of 128 cannot be split/);
    const mesh = bipyramid(63);
    mesh.apply(record(0, [0, 0, 0], none), 0); // the south pole is an apex of this face
    assert.deepEqual([...mesh.connectivity.valences.subarray(0, 2)], [63, 64]);
    assert.throws(() => mesh.apply(record(4, [0, 0, 0], none), 0), /face 4 of 132 cannot be split/);
});

test("RefinableMesh: a base that is not closed, not oriented or not manifold is refused", () => {
    const two = [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2];
    assert.throws(baseOf(4, ...two.slice(0, 9)), /expected a closed mesh/);
    assert.throws(baseOf(4, ...two.slice(0, 9), 1, 2, 3), /expected a (closed mesh|consistently oriented manifold)/);
    assert.throws(baseOf(4, ...two, ...two), /expected a consistently oriented manifold/);
    assert.throws(baseOf(4, ...two.slice(0, 9), 1, 3, 4), /vertex 4 of only 4/);
    assert.throws(baseOf(4, ...two.slice(0, 9), 1, 3, 3), /three different corners/);
    assert.throws(baseOf(5, ...two), /base vertex 4: expected at least three edges, got 0/);
    const second = two.map((v) => (v === 0 ? 0 : v + 3)); // another tetrahedron, which shares one vertex
    assert.throws(baseOf(7, ...two, ...second), /base vertex 0: its faces form more than one fan/);
});
