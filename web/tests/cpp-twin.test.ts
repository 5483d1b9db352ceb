// Logs of real size: made by the C++ program, read here, compared with what the C++ reader makes of them. Needs a built
// `anyrate` (ANYRATE, or build/anyrate), and for all captures but the first the shared ones (ANYRATE_SHARED, or ../shared).
import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { decodeLog, frameTypeName } from "../src/client/index.js";
import type { Budget, ProgressiveMesh } from "../src/client/index.js";
import { draco, repository } from "./golden.js";
import { anyrate, inScratchFolder, noProgram, testUnless } from "./program.js";

const shared = process.env["ANYRATE_SHARED"] ?? fileURLToPath(new URL("../shared", repository));
const sharedCaptures = ["nefertiti", "pot", "bowl", "oxford_dinosaur"];

/** The bytes behind the header of the file that `anyrate decode` would write for this mesh, but for its normals. */
function plyBody(mesh: ProgressiveMesh): Uint8Array {
    const body = new Uint8Array(15 * mesh.nVertices + 13 * mesh.nFaces);
    const view = new DataView(body.buffer);
    let at = 0;
    const world = mesh.worldPositions();
    for (let v = 0; v < mesh.nVertices; ++v, at += 3) {
        for (let axis = 0; axis < 3; ++axis, at += 4) view.setFloat32(at, world[3 * v + axis], true);
        body.set(mesh.colours.subarray(3 * v, 3 * v + 3), at);
    }
    for (let f = 0; f < mesh.nFaces; ++f) {
        body[at++] = 3;
        for (let i = 0; i < 3; ++i, at += 4) view.setUint32(at, mesh.triangles[3 * f + i], true);
    }
    return body;
}

/** The same of a file: normals are not part of the stream, each writer computes its own. */
function bodyOfPly(file: string, nVertices: number): Uint8Array {
    const bytes = readFileSync(file);
    const end = "end_header\n";
    const [normalsBegin, normalsEnd, stride] = [12, 24, 27];
    const facesBegin = stride * nVertices;
    return bytes
        .subarray(bytes.indexOf(end) + end.length)
        .filter((_, i) => i >= facesBegin || i % stride < normalsBegin || i % stride >= normalsEnd);
}

async function compareReaders(folder: string, capture: string): Promise<void> {
    const model = join(folder, "model.arl");
    await anyrate("reconstruct", capture, "-o", model, "--coarse", "500", "--vertices", "2200", "--quiet");
    const log = new Uint8Array(readFileSync(model));

    const { layout } = decodeLog(log, draco); // checks every checksum and state hash
    const listed = JSON.parse(await anyrate("info", model, "--json"));
    assert.deepEqual(
        layout.frames.map((frame) => [frameTypeName(frame.type), frame.nVerticesAfter, frame.end]),
        listed.frames.map((frame: Record<string, unknown>) => [frame["type"], frame["vertices"], frame["end"]]),
    );

    const middle = layout.index[layout.index.length >> 1];
    const budgets: Budget[] = [
        ...[1, 500, 777, 1500, 1501, 2000, 2200, 100000].map((vertices) => ({ vertices })),
        { bytes: 1 },
        { bytes: Math.round(log.length / 2) },
        { distortion: middle.meanDistortion },
        { distortion: 0 },
    ];
    for (const budget of budgets) {
        const [[option, value]] = Object.entries(budget);
        const mesh = join(folder, "mesh.ply");
        await anyrate("decode", model, "-o", mesh, `--${option}`, String(value));
        const decoded = decodeLog(log, draco, budget).mesh;
        const written = bodyOfPly(mesh, decoded.nVertices);
        assert.ok(Buffer.compare(plyBody(decoded), written) === 0, `${option} ${value}`);
    }
}

testUnless(noProgram)("Twin: C++ and JavaScript decode a simulated capture's log alike at every budget", async () => {
    await inScratchFolder(async (folder) => {
        const capture = join(folder, "capture");
        await anyrate("simulate", "--scene", "vessel", "-o", capture, "--views", "12", "--width", "200", "--height", "150");
        await compareReaders(folder, capture);
    });
});

for (const name of sharedCaptures) {
    const capture = join(shared, "data", name);
    const noCapture = existsSync(join(capture, "cameras.json")) ? false : `no capture at ${capture}`;
    testUnless(noProgram || noCapture)(`Twin: C++ and JavaScript decode a log of ${name} alike at every budget`, () =>
        inScratchFolder((folder) => compareReaders(folder, capture)),
    );
}
