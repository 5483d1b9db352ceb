import assert from "node:assert/strict";

import { test } from "vitest";
import { WebSocket } from "ws";

import { DecodeError, dracoInThread, followModel, openModel, readLayout, ServerError } from "../src/client/index.js";
import type { LiveStatus, Model, ModelEvent, ModelOptions } from "../src/client/index.js";
import type { SocketConstructor } from "../src/client/platform.js";
import { draco, found, icosphere, icosphereExpectations, icospherePacked } from "./golden.js";
import { liveForm, LogServer, messagesOf, sideIndexOf } from "./log-server.js";
import type { LogServerOptions } from "./log-server.js";

const options: ModelOptions = {
    draco: dracoInThread(draco),
    platform: { WebSocket: WebSocket as unknown as SocketConstructor },
    live: { firstDelay: 1, maxDelay: 4 },
};

async function withServer(
    log: Uint8Array,
    serverOptions: LogServerOptions,
    use: (url: string, server: LogServer) => Promise<void>,
): Promise<void> {
    const server = new LogServer(log, serverOptions);
    try {
        await use(await server.start(), server);
    } finally {
        server.stop();
    }
}

function assertGolden(model: Model, budget: number): void {
    const expected = icosphereExpectations.find((expectation) => expectation.budget === budget);
    assert.ok(expected, `a golden budget, got ${budget}`);
    assert.deepEqual(found(budget, model.mesh!), expected);
}

const goldenBudgets = icosphereExpectations.map(({ budget }) => budget);
const mostVertices = Math.max(...goldenBudgets);
const framesBegin = readLayout(icosphere).framesBegin;
const framesIn = (log: Uint8Array) => readLayout(log).index.length;
const endOf = (row: number) => framesBegin + readLayout(icosphere).index[row].end;

test("openModel: one request of 8 KB brings a mesh, one more each raised budget", () =>
    withServer(icosphere, {}, async (url, server) => {
        const model = await openModel(url, options);
        assert.deepEqual(server.ranges, ["bytes=0-8191"]);
        assert.ok(model.mesh!.nVertices >= 42);
        await model.setBudget({ vertices: 100 });
        assert.deepEqual(server.ranges, ["bytes=0-8191"], "8 KB hold that budget");
        await model.setBudget({ vertices: 1e6 });
        assert.deepEqual(server.ranges, ["bytes=0-8191", `bytes=8192-${endOf(framesIn(icosphere) - 1) - 1}`]);
        assert.ok(server.nBytesSent <= icosphere.length);
        model.dispose();
    }));

test("openModel: bytes that are wanted in any case are asked for beside the first request, and come once", () =>
    withServer(icosphere, {}, async (url, server) => {
        const whole = { budget: { vertices: 1e6 }, bytesWanted: icosphere.length };
        const model = await openModel(url, { ...options, ...whole });
        // By two connections, so either may come first.
        assert.deepEqual(server.ranges.slice().sort(), ["bytes=0-8191", `bytes=8192-${icosphere.length - 1}`]);
        assertGolden(model, mostVertices);
        assert.equal(server.nBytesSent, icosphere.length);
        model.dispose();
        const small = await openModel(url, { ...options, bytesWanted: 5000 });
        assert.equal(server.ranges.length, 3, "8 KB hold what is wanted");
        small.dispose();
    }));

test("openModel: bytes asked for ahead are left if they are of another log, or too few", () =>
    withServer(icosphere, {}, async (url, server) => {
        server.onRequest = (range) => (server.log = range.startsWith("bytes=0-") ? icosphere : icospherePacked);
        const model = await openModel(url, { ...options, budget: { vertices: 1e6 }, bytesWanted: icosphere.length });
        assertGolden(model, mostVertices);
        assert.equal(server.ranges.length, 3);
        model.dispose();
        server.onRequest = () => {};
        server.log = icosphere;
        const short = await openModel(url, { ...options, budget: { vertices: 1e6 }, bytesWanted: 9000 });
        assertGolden(short, mostVertices);
        assert.deepEqual(server.ranges.slice(3).sort(), ["bytes=0-8191", "bytes=8192-8999", `bytes=9000-${endOf(framesIn(icosphere) - 1) - 1}`]);
        short.dispose();
    }));

test("openModel, followModel: a token goes with every request, and with a WebSocket as a protocol that it offers", async () => {
    const live = liveForm(icosphere);
    const onLive: LogServerOptions["onLive"] = (socket) => {
        socket.send(JSON.stringify({ type: "end", state: "done" }));
        socket.close();
    };
    await withServer(live, { onLive }, async (url, server) => {
        const model = await openModel(url, { ...options, token: "abc", bytesWanted: live.length });
        await model.live();
        assert.deepEqual(server.credentials, ["Bearer abc", "Bearer abc", "anyrate.live,anyrate.bearer.abc"]);
        model.dispose();
        const open = await openModel(url, options);
        await open.live();
        assert.deepEqual(server.credentials.slice(3), [undefined, undefined]);
        open.dispose();
    });
});

test("openModel: every budget, up and down, is the mesh that the golden file tells", () =>
    withServer(icosphere, {}, async (url, server) => {
        const model = await openModel(url, options);
        for (const budget of [...goldenBudgets, ...goldenBudgets.slice().reverse(), ...goldenBudgets]) {
            await model.setBudget({ vertices: budget });
            assertGolden(model, budget);
        }
        assert.ok(server.nBytesSent <= icosphere.length, "no byte comes twice");
        model.dispose();
    }));

test("openModel: budgets of bytes and of distortion end where the index says", () =>
    withServer(icosphere, {}, async (url) => {
        const model = await openModel(url, options);
        const rows = readLayout(icosphere).index;
        const middle = rows.findIndex(({ nVertices }) => nVertices > 500);
        await model.setBudget({ bytes: endOf(middle) });
        assert.equal(model.mesh!.nVertices, rows[middle].nVertices);
        const wanted = rows[middle].meanDistortion;
        await model.setBudget({ distortion: wanted });
        assert.equal(model.mesh!.nVertices, rows.find((row) => row.meanDistortion <= wanted)!.nVertices);
        model.dispose();
    }));

test("openModel: a server that ignores Range is read once, and no further than needed", () =>
    withServer(icosphere, { ignoresRange: true }, async (url, server) => {
        const model = await openModel(url, options);
        for (const budget of goldenBudgets) {
            await model.setBudget({ vertices: budget });
            assertGolden(model, budget);
        }
        assert.equal(server.ranges.length, 1);
        model.dispose();
    }));

test("openModel: a log that was replaced since the first request is begun anew", () =>
    withServer(icosphere, {}, async (url, server) => {
        const model = await openModel(url, options);
        server.log = icospherePacked;
        await model.setBudget({ vertices: mostVertices });
        assertGolden(model, mostVertices);
        model.dispose();
    }));

test("openModel: a live log's budgets come from the side index", () =>
    withServer(liveForm(icosphere), {}, async (url, server) => {
        server.sideIndex = sideIndexOf(server.log);
        const model = await openModel(url, options);
        await model.setBudget({ vertices: 500 });
        assertGolden(model, 500);
        await model.setBudget({ distortion: 700 });
        assert.ok(1000 - model.mesh!.nVertices / 2 <= 700);
        model.dispose();
    }));

test("openModel: what the server says is what is thrown", () =>
    withServer(icosphere, {}, async (url) => {
        await assert.rejects(openModel(`${url}x`.replace("/v1/models", "/v1/other"), options), (error) => {
            assert.ok(error instanceof ServerError);
            assert.equal(error.message, "there is no such model");
            return true;
        });
    }));

test("openModel: a damaged frame is an error, and the mesh before it stays", () => {
    const damaged = icosphere.slice();
    damaged[8192 + 300] ^= 1;
    return withServer(damaged, {}, async (url) => {
        const events: ModelEvent[] = [];
        const model = await openModel(url, { ...options, onEvent: (event) => events.push(event) });
        await assert.rejects(model.setBudget({ vertices: 1e6 }), DecodeError);
        assert.ok(model.mesh!.nVertices > 42);
        assert.ok(events.some((event) => event.type === "error"));
        model.dispose();
    });
});

test("openModel: an aborted signal ends the model's work", () =>
    withServer(icosphere, {}, async (url) => {
        const abort = new AbortController();
        abort.abort();
        await assert.rejects(openModel(url, { ...options, signal: abort.signal as never }), { name: "AbortError" });
    }));

test("openModel: takeChanges() brings a copy up to date, normals too, up and down", () =>
    withServer(icosphere, {}, async (url) => {
        const model = await openModel(url, options);
        const normals: number[] = [];
        const positions: number[] = [];
        for (const budget of [mostVertices, 100, 700, 42, mostVertices]) {
            await model.setBudget({ vertices: budget });
            const changes = model.takeChanges();
            for (const { first, count } of changes.vertices) {
                for (let i = 3 * first; i < 3 * (first + count); ++i) positions[i] = model.mesh!.positions[i];
            }
            for (const { first, count } of changes.normals) {
                for (let i = 4 * first; i < 4 * (first + count); ++i) normals[i] = model.normals[i];
            }
            const { nVertices } = model.mesh!;
            assert.deepEqual(positions.slice(0, 3 * nVertices), [...model.mesh!.positions]);
            assert.deepEqual(normals.slice(0, 4 * nVertices), normalsOf(model));
        }
        model.dispose();
    }));

test("openModel: a budget is met also on a machine so slow that every deadline has passed when it is looked at", () =>
    withServer(icosphere, {}, async (url) => {
        let now = 0;
        const platform = { ...options.platform, now: () => (now += 1000) };
        const model = await openModel(url, { ...options, platform });
        for (const budget of [mostVertices, 100, 500]) {
            await model.setBudget({ vertices: budget });
            assertGolden(model, budget);
        }
        model.dispose();
    }));

test("openModel: a model takes no more memory than it is said to", () =>
    withServer(icosphere, {}, async (url) => {
        const model = await openModel(url, options);
        await model.setBudget({ vertices: mostVertices });
        const perVertex = arrayBytes(model) / model.mesh!.nVertices;
        assert.ok(perVertex > 100 && perVertex <= 380, `expected at most 380 bytes a vertex, got ${perVertex}`);
        model.dispose();
    }));

/** Of every typed array that an object holds, directly or not; arrays of a fixed small size are not counted. */
function arrayBytes(root: object): number {
    const seen = new Set<unknown>();
    const waiting: unknown[] = [root];
    let sum = 0;
    while (waiting.length > 0) {
        const value = waiting.pop();
        if (typeof value !== "object" || value === null || seen.has(value)) continue;
        seen.add(value);
        if (!ArrayBuffer.isView(value)) waiting.push(...Object.values(value));
        else if (!seen.has(value.buffer) && value.buffer.byteLength > 2048) sum += value.buffer.byteLength;
        if (ArrayBuffer.isView(value)) seen.add(value.buffer);
    }
    return sum;
}

/** Of all vertices, from scratch: sums of the faces' cross products. */
function normalsOf(model: Model): number[] {
    const { positions, triangles, nVertices } = model.mesh!;
    const sums = new Float64Array(3 * nVertices);
    const at = (v: number) => [positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]];
    for (let h = 0; h < triangles.length; h += 3) {
        const [p, q, r] = [at(triangles[h]), at(triangles[h + 1]), at(triangles[h + 2])];
        const [a, b] = [q.map((x, i) => x - p[i]), r.map((x, i) => x - p[i])];
        const n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        for (const v of triangles.subarray(h, h + 3)) n.forEach((x, i) => (sums[3 * v + i] += x));
    }
    return Array.from({ length: nVertices }, (_, v) => {
        const n = sums.subarray(3 * v, 3 * v + 3);
        const length = Math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        return [...[...n].map((x) => Math.round(x * (32767 / length)) + 0), 0];
    }).flat();
}

/** Sends messages from the frame that is asked for; cuts the connection behind so many of them. */
function liveServer(live: Uint8Array, logId: string, cutAfter: readonly number[]): LogServerOptions & { sent: number } {
    const messages = messagesOf(live);
    const cuts = [...cutAfter];
    const server = {
        sent: 0,
        onLive: (socket: import("ws").WebSocket, from: number) => {
            socket.send(JSON.stringify({ type: "hello", log_id: logId, next_sequence: from, sealed: true }));
            const rest = from === 0 ? messages : messages.slice(from + 1);
            const now = rest.slice(0, cuts.shift() ?? Infinity);
            for (const message of now) {
                server.sent += message.length;
                socket.send(message);
            }
            if (now.length < rest.length) {
                setTimeout(() => socket.terminate(), 20);
            } else {
                socket.send(JSON.stringify({ type: "end", state: "done" }));
                socket.close(1000);
            }
        },
    };
    return server;
}

const liveId = (live: Uint8Array) => readLayout(live).header.logId.toString(16).padStart(16, "0");

test("live: a connection that is cut goes on at the frame it lacks, and no byte comes twice", async () => {
    const live = liveForm(icosphere);
    const server = liveServer(live, liveId(live), [3, 0, 5, 1]);
    await withServer(live, server, async (url) => {
        const seen: LiveStatus[] = [];
        const ended = new Promise<void>((resolve) => {
            void followModel(url, {
                ...options,
                onEvent: (event) => {
                    if (event.type !== "live") return;
                    seen.push(event.status);
                    if (event.status.type === "ended") resolve();
                },
            }).then((followed) => (model = followed));
        });
        let model: Model | undefined;
        await ended;
        await model!.setBudget({ vertices: mostVertices });
        assertGolden(model!, mostVertices);
        assert.equal(server.sent, live.length);
        assert.equal(model!.nBytes, live.length);
        assert.equal(seen.filter(({ type }) => type === "lost").length, 4);
        model!.dispose();
    });
});

test("live: it goes on behind what a range has brought, from the next whole frame", async () => {
    const live = liveForm(icosphere);
    const server = liveServer(live, liveId(live), []);
    await withServer(live, server, async (url) => {
        const model = await openModel(url, options);
        const whole = readLayout(live.subarray(0, 8192)).wholeBytes;
        await model.live();
        await model.setBudget({ vertices: mostVertices });
        assertGolden(model, mostVertices);
        assert.equal(server.sent, live.length - whole);
        model.dispose();
    });
});

test("live: a hello with another log id replaces the mesh by that of the log that follows", async () => {
    const [preview, log] = [liveForm(icospherePacked, 7n), liveForm(icosphere)];
    const serverOptions: LogServerOptions = {
        onLive: (socket) => {
            const send = (live: Uint8Array, n: number) => {
                socket.send(JSON.stringify({ type: "hello", log_id: liveId(live), next_sequence: 0, sealed: false }));
                for (const message of messagesOf(live).slice(0, n)) socket.send(message);
            };
            send(preview, 3);
            setTimeout(() => {
                send(log, Infinity);
                socket.send(JSON.stringify({ type: "end", state: "done" }));
                socket.close(1000);
            }, 50);
        },
    };
    await withServer(log, serverOptions, async (url) => {
        let nMeshes = 0;
        let end: () => void;
        const ended = new Promise<void>((resolve) => (end = resolve));
        const model = await followModel(url, {
            ...options,
            onEvent: (event) => {
                if (event.type === "mesh") ++nMeshes;
                if (event.type === "live" && event.status.type === "ended") end();
            },
        });
        await ended;
        await model.setBudget({ vertices: mostVertices });
        assertGolden(model, mostVertices);
        assert.equal(nMeshes, 2);
        model.dispose();
    });
});

test("live: a log that was begun anew while the connection was away is asked for from its start", async () => {
    const [before, after] = [liveForm(icospherePacked, 7n), liveForm(icosphere)];
    const asked: number[] = [];
    await withServer(after, {
        onLive: (socket, from) => {
            asked.push(from);
            const live = asked.length === 1 ? before : after;
            socket.send(JSON.stringify({ type: "hello", log_id: liveId(live), next_sequence: from, sealed: false }));
            if (asked.length === 1) {
                for (const message of messagesOf(live).slice(0, 4)) socket.send(message);
                setTimeout(() => socket.terminate(), 20);
            } else if (from === 0) {
                for (const message of messagesOf(live)) socket.send(message);
                socket.send(JSON.stringify({ type: "end", state: "done" }));
                socket.close(1000);
            }
        },
    }, async (url) => {
        let end: () => void;
        const ended = new Promise<void>((resolve) => (end = resolve));
        const model = await followModel(url, {
            ...options,
            onEvent: (event) => event.type === "live" && event.status.type === "ended" && end(),
        });
        await ended;
        await model.setBudget({ vertices: mostVertices });
        assertGolden(model, mostVertices);
        assert.deepEqual(asked, [0, 3, 0]);
        model.dispose();
    });
});

test("live: it gives up after as many attempts as it is told", () =>
    withServer(icosphere, { onLive: (socket) => socket.terminate() }, async (url) => {
        const seen: string[] = [];
        const gone = new Promise<void>((resolve) => {
            void followModel(url, {
                ...options,
                live: { firstDelay: 1, maxDelay: 2, maxAttempts: 3 },
                onEvent: (event) => {
                    if (event.type !== "live") return;
                    seen.push(event.status.type);
                    if (event.status.type === "gone") resolve();
                },
            });
        });
        await gone;
        assert.equal(seen.filter((type) => type === "connecting").length, 3);
    }));
