import assert from "node:assert/strict";

import { test } from "vitest";

import { DecodeError, dracoInWorker, openModel } from "../src/client/index.js";
import { found, icosphere, icosphereExpectations } from "./golden.js";
import { LogServer } from "./log-server.js";
import { nodeWorker } from "./node-worker.js";

test("dracoInWorker: a model decoded with it is the same mesh", async () => {
    const draco = dracoInWorker(nodeWorker());
    const server = new LogServer(icosphere);
    try {
        const model = await openModel(await server.start(), { draco });
        for (const expected of icosphereExpectations) {
            await model.setBudget({ vertices: expected.budget });
            assert.deepEqual(found(expected.budget, model.mesh!), expected);
        }
        assert.ok(draco.milliseconds > 0);
        model.dispose();
    } finally {
        server.stop();
        draco.dispose();
    }
});

test("dracoInWorker: what Draco refuses is a DecodeError here too", async () => {
    const draco = dracoInWorker(nodeWorker());
    await assert.rejects(draco.decodePointCloud(Uint8Array.of(1, 2, 3), 1, [1]), DecodeError);
    draco.dispose();
});

test("dracoInWorker: after dispose() nothing is left waiting", async () => {
    const draco = dracoInWorker(nodeWorker());
    const waiting = draco.decodePointCloud(Uint8Array.of(1, 2, 3), 1, [1]);
    draco.dispose();
    await assert.rejects(waiting, /disposed of/);
    await assert.rejects(draco.decodePointCloud(Uint8Array.of(1, 2, 3), 1, [1]), /disposed of/);
});
