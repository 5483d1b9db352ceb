import assert from "node:assert/strict";

import { test } from "vitest";

import { readLayout } from "../../src/client/index.js";
import { budgetScale, nextValue, sliderSteps, stepOf, valueAt } from "../../src/viewer/budget-scale.js";
import { icosphere } from "../golden.js";

const { index, framesBegin } = readLayout(icosphere);
const kinds = ["vertices", "bytes", "distortion"] as const;

test("Budget slider: its ends are the base and the whole log", () => {
    for (const kind of kinds) {
        const scale = budgetScale(kind, index, framesBegin)!;
        assert.equal(valueAt(scale, 0), scale.coarsest);
        assert.equal(valueAt(scale, sliderSteps), scale.finest);
    }
    const scale = budgetScale("vertices", index, framesBegin)!;
    assert.deepEqual([scale.coarsest, scale.finest], [index[0].nVertices, index.at(-1)!.nVertices]);
});

test("Budget slider: its scale is logarithmic, and a value finds its step again", () => {
    const scale = { kind: "vertices", coarsest: 100, finest: 1_000_000 } as const;
    assert.equal(valueAt(scale, sliderSteps / 2), 10_000);
    for (let step = 0; step <= sliderSteps; ++step) assert.ok(Math.abs(stepOf(scale, valueAt(scale, step)) - step) <= 1);
});

test("Budget slider: arrow keys reach every number of vertices, up and down, and stay at the ends", () => {
    const scale = budgetScale("vertices", index, framesBegin)!;
    const go = (value: number, direction: number) => nextValue(scale, index, framesBegin, value, direction);
    let value = scale.coarsest;
    for (let n = scale.coarsest + 1; n <= scale.finest; ++n) assert.equal((value = go(value, 1)), n);
    assert.equal(go(value, 1), scale.finest);
    for (let n = scale.finest - 1; n >= scale.coarsest; --n) assert.equal((value = go(value, -1)), n);
    assert.equal(go(value, -1), scale.coarsest);
});

test("Budget slider: arrow keys reach every frame's bytes and every distortion", () => {
    for (const kind of ["bytes", "distortion"] as const) {
        const scale = budgetScale(kind, index, framesBegin)!;
        const seen = [scale.coarsest];
        for (let next = seen[0]; next !== scale.finest; seen.push(next)) next = nextValue(scale, index, framesBegin, next, 1);
        const amounts = index.map(({ end, meanDistortion }) => (kind === "bytes" ? framesBegin + end : meanDistortion));
        const expected = [...new Set(amounts)].sort((a, b) => (kind === "bytes" ? a - b : b - a));
        assert.deepEqual(seen, expected.slice(expected.indexOf(scale.coarsest)), kind);
    }
});
