import assert from "node:assert/strict";

import { test } from "vitest";

import { ModelDecoder, readLayout } from "../src/client/index.js";
import type { ProgressiveMesh, Range } from "../src/client/index.js";
import { draco, icosphere } from "./golden.js";

/** What a graphics card would hold: grows, and changes only where it is told to. */
class Copy {
    private positions: number[] = [];
    private triangles: number[] = [];
    private colours: number[] = [];

    update(mesh: ProgressiveMesh): void {
        const changes = mesh.takeChanges();
        copyRanges(mesh.positions, this.positions, changes.vertices);
        copyRanges(mesh.triangles, this.triangles, changes.faces);
        copyRanges(mesh.colours, this.colours, changes.colours);
    }

    assertEqual(mesh: ProgressiveMesh): void {
        assert.deepEqual(this.positions, [...mesh.positions]);
        assert.deepEqual(this.triangles, [...mesh.triangles]);
        assert.deepEqual(this.colours, [...mesh.colours]);
    }
}

function copyRanges(from: ArrayLike<number>, to: number[], ranges: readonly Range[]): void {
    let end = 0;
    for (const { first, count } of ranges) {
        assert.ok(first >= end && count > 0, "ranges ascend");
        end = first + count;
        for (let i = 3 * first; i < 3 * end; ++i) to[i] = from[i];
    }
}

test("ProgressiveMesh: after every frame the ranges it reports hold all that changed", () => {
    const decoder = new ModelDecoder(draco);
    const copy = new Copy();
    let fed = 0;
    for (const frame of readLayout(icosphere).frames) {
        decoder.feed(icosphere.subarray(fed, frame.end));
        fed = frame.end;
        if (!decoder.mesh) continue;
        copy.update(decoder.mesh);
        copy.assertEqual(decoder.mesh);
    }
});

test("ProgressiveMesh: the ranges hold all that changed when a budget is raised within packets, too", () => {
    const decoder = new ModelDecoder(draco);
    decoder.setMaxVertices(0);
    decoder.feed(icosphere);
    const copy = new Copy();
    for (let budget = 42; budget < 1400; budget += 31) {
        decoder.setMaxVertices(budget);
        copy.update(decoder.mesh!);
        copy.assertEqual(decoder.mesh!);
    }
});

test("ProgressiveMesh: one split reports few elements of a large mesh", () => {
    const decoder = new ModelDecoder(draco);
    decoder.setMaxVertices(1311);
    decoder.feed(icosphere);
    decoder.mesh!.takeChanges();
    decoder.setMaxVertices(1314);
    const { vertices, colours } = decoder.mesh!.takeChanges();
    assert.ok(vertices.reduce((sum, range) => sum + range.count, 0) < 600);
    assert.deepEqual(colours, [{ first: 1311, count: 3 }]);
    assert.deepEqual(decoder.mesh!.takeChanges(), { vertices: [], faces: [], colours: [] });
});

test("ProgressiveMesh: any number of splits gives a closed manifold of Euler number 2", () => {
    const decoder = new ModelDecoder(draco);
    decoder.setMaxVertices(0);
    decoder.feed(icosphere);
    for (let budget = 42; budget <= 1317; budget += 51) {
        decoder.setMaxVertices(budget);
        const { triangles, nVertices, nFaces } = decoder.mesh!;
        assert.ok(nVertices > budget - 3 && nVertices <= budget);
        const edges = new Set<string>();
        for (let h = 0; h < triangles.length; ++h) {
            edges.add(`${triangles[h]} ${triangles[h % 3 === 2 ? h - 2 : h + 1]}`);
        }
        assert.equal(edges.size, triangles.length, "each directed edge once");
        for (const edge of edges) assert.ok(edges.has(edge.split(" ").reverse().join(" ")), "and its reverse");
        assert.equal(nVertices - triangles.length / 2 + nFaces, 2);
    }
});

test("ProgressiveMesh: the parents of a vertex are two older vertices, of the base's vertices themselves", () => {
    const decoder = new ModelDecoder(draco);
    decoder.feed(icosphere);
    const { parents, nVertices } = decoder.mesh!;
    for (let v = 0; v < nVertices; ++v) {
        const [p, q] = [parents[2 * v], parents[2 * v + 1]];
        if (v < 42) assert.deepEqual([p, q], [v, v]);
        else assert.ok(p < v && q < v && p !== q);
    }
});

test("ProgressiveMesh: a lower budget keeps what has been replayed", () => {
    const decoder = new ModelDecoder(draco);
    decoder.setMaxVertices(500);
    decoder.feed(icosphere);
    decoder.setMaxVertices(100);
    assert.equal(decoder.mesh!.nVertices, 498);
});
