#!/usr/bin/env node
// How fast the JavaScript reader of logs is: replay.mjs [LOG.arl] [--seconds S=2]     prints one JSON object
//
//   replay   splits per second of the operation alone, on records that Draco decoded before: of the first pass over the
//            log in this process (cold), and the median of the passes of the next S seconds (warm)
//   decode   the whole reader, bytes to coloured mesh with all checksums and hashes: vertices per second, warm
//   packet   milliseconds that Draco's WebAssembly takes for the refine packet nearest to 512 splits, warm
//
// Needs `npm ci && npm run build` in web/. A log of a useful size:
//   anyrate simulate --scene vessel -o vessel && anyrate reconstruct vessel -o vessel.arl --vertices 40000
// without LOG it takes tests/golden/icosphere.arl, whose 425 splits measure little but the warming up.
// One thread; timings are those of the machine as it is.
import { readFileSync } from "node:fs";
import os from "node:os";
import { performance } from "node:perf_hooks";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

import { decodeBase } from "../../web/dist/src/client/base-codec.js";
import { flagNewBatch, payloadOf } from "../../web/dist/src/client/frame.js";
import { decodeLog, FrameType, loadDraco3d, readLayout } from "../../web/dist/src/client/index.js";
import { RefinableMesh } from "../../web/dist/src/client/refinable-mesh.js";
import { decodeRefine, noPreviousFace, refineComponents } from "../../web/dist/src/client/refine-codec.js";

const { values: options, positionals } = parseArgs({
    options: { seconds: { type: "string", default: "2" } },
    allowPositionals: true,
});
const golden = fileURLToPath(new URL("../golden/icosphere.arl", import.meta.url));
const log = readFileSync(positionals[0] ?? golden);
const draco = await loadDraco3d();
const layout = readLayout(log);

const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];

/** Milliseconds of passes for about so many seconds, at least of one. What `prepare` does for each is not counted. */
function timesOf(prepare, seconds) {
    const times = [];
    const start = performance.now();
    do {
        const pass = prepare();
        const before = performance.now();
        pass();
        times.push(performance.now() - before);
    } while (performance.now() - start < 1000 * seconds);
    return times;
}

const payload = (frame) => payloadOf(log.subarray(frame.begin), frame);
const base = decodeBase(payload(layout.frames.find((frame) => frame.type === FrameType.base)), layout.header, draco);
const packets = layout.frames.filter((frame) => frame.type === FrameType.refine);
let previousFace = noPreviousFace;
const nFacesBefore = ({ nVerticesBefore }) => layout.header.nBaseFaces + 2 * (nVerticesBefore - layout.header.nBaseVertices);
const records = packets.map((frame) => {
    if (frame.flags & flagNewBatch) previousFace = noPreviousFace;
    const decoded = decodeRefine(payload(frame), frame.nSplits, previousFace, nFacesBefore(frame), draco);
    previousFace = decoded.faces[frame.nSplits - 1];
    return decoded;
});
const nSplits = packets.reduce((sum, frame) => sum + frame.nSplits, 0);
const nVertices = layout.frames.at(-1).nVerticesAfter;

function prepareReplay() {
    const mesh = new RefinableMesh(base, layout.header.grid.bits, layout.header.rules);
    return () => {
        for (const packet of records) {
            for (let i = 0; i < packet.faces.length; ++i) mesh.apply(packet, i);
        }
    };
}

const seconds = Number(options.seconds);
const cold = timesOf(prepareReplay, 0)[0];
const warm = median(timesOf(prepareReplay, seconds));
const decode = median(timesOf(() => () => decodeLog(log, draco), seconds));
const near512 = packets.reduce((a, b) => (Math.abs(a.nSplits - 512) <= Math.abs(b.nSplits - 512) ? a : b));
const decodePacket = () => draco.decodePointCloud(payload(near512), near512.nSplits, refineComponents);
const packet = median(timesOf(() => decodePacket, seconds));

const perSecond = (n, milliseconds) => Math.round((1000 * n) / milliseconds);
const [cpu] = os.cpus();
const report = {
    machine: { cpu: cpu?.model, cores: os.cpus().length, load_average: os.loadavg()[0], node: process.version },
    log: { splits: nSplits, vertices: nVertices, bytes: log.length },
    replay: { cold_splits_per_second: perSecond(nSplits, cold), warm_splits_per_second: perSecond(nSplits, warm) },
    decode: { milliseconds: decode, vertices_per_second: perSecond(nVertices, decode) },
    packet: { splits: near512.nSplits, milliseconds: packet },
};
console.log(JSON.stringify(report, null, 1));
