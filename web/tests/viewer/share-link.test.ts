import assert from "node:assert/strict";

import { test } from "vitest";

import { formatShared, parseShared } from "../../src/viewer/share-link.js";
import type { SharedState } from "../../src/viewer/share-link.js";

test("Link: what it says is read back", () => {
    const states: SharedState[] = [
        {},
        { budget: { vertices: 4321 }, pose: [1, -2.5, 3e-5, 0, 1e6, -0.125], shading: "normals", edges: true },
        { budget: { bytes: 8192 }, photograph: 3 },
        { budget: { distortion: 10.68 }, shading: "heat" },
    ];
    for (const state of states) assert.deepEqual(parseShared(formatShared(state)), state);
});

test("Link: what it says wrongly is left out", () => {
    for (const query of ["vertices=-1", "vertices=1e3", "bytes=x", "distortion=", "distortion=-2", "view=1_2_3", "view=1_2_3_4_5_x", "shading=gold", "edges=yes", "photograph=1.5"]) {
        assert.deepEqual(parseShared(query), {}, query);
    }
});
