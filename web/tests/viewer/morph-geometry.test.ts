// What goes to the graphics card, without one: positions from which and to which a surface moves, its faces and edges.
import assert from "node:assert/strict";

import { test } from "vitest";

import { dracoInThread, openModel } from "../../src/client/index.js";
import type { Model } from "../../src/client/index.js";
import { MorphGeometry } from "../../src/viewer/morph-geometry.js";
import { draco, icosphere } from "../golden.js";
import { LogServer } from "../log-server.js";

async function withModel(vertices: number, use: (model: Model, morphing: MorphGeometry) => Promise<void>): Promise<void> {
    const server = new LogServer(icosphere);
    const model = await openModel(await server.start(), { draco: dracoInThread(draco), budget: { vertices } });
    const morphing = new MorphGeometry();
    try {
        morphing.update(model, model.takeChanges(), 1);
        await use(model, morphing);
    } finally {
        morphing.dispose();
        model.dispose();
        server.stop();
    }
}

const numbers = (morphing: MorphGeometry, name: string) => morphing.geometry.getAttribute(name).array;

test("Geomorph: a new vertex starts at the middle of the edge it was put on, and an old one where it was", () =>
    withModel(100, async (model, morphing) => {
        const before = model.mesh!.positions.slice();
        const nBefore = model.mesh!.nVertices;
        await model.setBudget({ vertices: 400 });
        morphing.update(model, model.takeChanges(), 1);
        const [from, to] = [numbers(morphing, "positionFrom"), numbers(morphing, "position")];
        const { nVertices, parents, positions } = model.mesh!;
        assert.ok(nVertices > nBefore + 250);
        assert.deepEqual(Array.from(to.slice(0, 3 * nVertices)), Array.from(positions));
        assert.deepEqual(Array.from(from.slice(0, 3 * nBefore)), Array.from(before));
        for (let v = nBefore; v < nVertices; ++v) {
            for (let axis = 0; axis < 3; ++axis) {
                const ends = [from[3 * parents[2 * v] + axis], from[3 * parents[2 * v + 1] + axis]];
                assert.equal(from[3 * v + axis], (ends[0] + ends[1]) / 2, `vertex ${v}`);
            }
        }
    }));

test("Geomorph: a step that comes in the middle of another goes on from what is drawn", () =>
    withModel(100, async (model, morphing) => {
        await model.setBudget({ vertices: 300 });
        morphing.update(model, model.takeChanges(), 1);
        const n = model.mesh!.nVertices;
        const [from, to] = ["positionFrom", "position"].map((name) => Array.from(numbers(morphing, name).slice(0, 3 * n)));
        const drawn = from.map((x, i) => x + 0.25 * (to[i] - x));
        await model.setBudget({ vertices: 400 });
        morphing.update(model, model.takeChanges(), 0.25);
        assert.deepEqual(Array.from(numbers(morphing, "positionFrom").slice(0, 3 * n)), drawn);
    }));

test("Geomorph: fewer vertices are drawn as what they are", () =>
    withModel(400, async (model, morphing) => {
        await model.setBudget({ vertices: 100 });
        morphing.update(model, model.takeChanges(), 1);
        const { nVertices, nFaces, positions, triangles } = model.mesh!;
        assert.equal(morphing.vertexCount, nVertices);
        assert.equal(morphing.geometry.drawRange.count, 3 * nFaces);
        assert.deepEqual(Array.from(numbers(morphing, "position").slice(0, 3 * nVertices)), Array.from(positions));
        assert.deepEqual(Array.from(morphing.geometry.index!.array.slice(0, 3 * nFaces)), Array.from(triangles));
    }));

test("Edges: each edge of the mesh is drawn once", () =>
    withModel(300, async (model, morphing) => {
        morphing.showEdges(true);
        await model.setBudget({ vertices: 400 });
        morphing.update(model, model.takeChanges(), 1);
        const { array } = morphing.edgeGeometry.index!;
        const drawn: string[] = [];
        for (let i = 0; i < morphing.edgeGeometry.drawRange.count; i += 2) {
            if (array[i] !== array[i + 1]) drawn.push(`${array[i]} ${array[i + 1]}`);
        }
        const { triangles, nVertices, nFaces } = model.mesh!;
        const edges = new Set<string>();
        for (let h = 0; h < triangles.length; ++h) {
            const [a, b] = [triangles[h], triangles[h % 3 === 2 ? h - 2 : h + 1]];
            edges.add(`${Math.min(a, b)} ${Math.max(a, b)}`);
        }
        assert.equal(edges.size, nVertices + nFaces - 2, "Euler");
        assert.deepEqual(drawn.sort(), [...edges].sort());
    }));

test("Heat map: it tells the vertices of a step that are new, those that moved, and how far", () =>
    withModel(100, async (model, morphing) => {
        assert.equal(morphing.measureHeat(model.mesh!), undefined, "there was no step");
        morphing.beginStep(model.mesh!);
        const before = model.mesh!.positions.slice();
        await model.setBudget({ vertices: 400 });
        morphing.update(model, model.takeChanges(), 1);
        const step = morphing.measureHeat(model.mesh!)!;
        const { positions, nVertices } = model.mesh!;
        const nBefore = before.length / 3;
        const moved = Array.from({ length: nBefore }, (_, v) => [0, 1, 2].some((axis) => before[3 * v + axis] !== positions[3 * v + axis]));
        assert.deepEqual(step, { added: nVertices - nBefore, moved: moved.filter(Boolean).length });
        const heat = Array.from({ length: nVertices }, (_, v) => numbers(morphing, "tint")[4 * v + 3]);
        assert.deepEqual(heat.slice(0, nBefore).map((x) => x > 0), moved);
        assert.ok(heat.slice(nBefore).every((x) => x === 255));
        morphing.beginStep(model.mesh!);
        await model.setBudget({ vertices: 200 });
        morphing.update(model, model.takeChanges(), 1);
        assert.equal(morphing.measureHeat(model.mesh!)!.added, model.mesh!.nVertices - nVertices);
    }));
