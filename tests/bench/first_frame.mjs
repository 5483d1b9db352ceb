#!/usr/bin/env node
// How long a visitor waits: first_frame.mjs LOG.arl [--runs N=3] [--tasks]     prints one JSON object
//
// LOG is a sealed log of at least 40,000 vertices, e.g.
//   anyrate simulate --scene vessel -o vessel && anyrate encode-mesh vessel/gt.ply -o vessel.arl --vertices 40000
//
// Headless Chromium, the built viewer (npm run viewer in web/), the log from a small web server; from the click on the
// model in the gallery to the first frame that shows it, to 10,000 and to 40,000 vertices drawn. Beside it the same
// meshes as GLBs in Draco's compression (anyrate decode --draco), loaded by three.js, each by itself. Page files and
// decoders are there before the click; no cache of the log. Once on loopback, once at 1.6 Mbit/s with 150 ms latency.
// Medians of N runs. Drawing is done in software (SwiftShader), on the same processors.
//
// --tasks instead lists the longest tasks of the main thread while the whole log is replayed and taken back (Chromium's own
// trace), by the clock and by the processor time that they took: with WebGL drawn in software on the same two processors a
// task mostly waits, for the drawing or for its turn. Once as it is, once with WebGL's draws and uploads left out.
import { execFileSync } from "node:child_process";
import { createReadStream, existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import http from "node:http";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

import { chromiumPage } from "./first_frame/browser.mjs";
import { decodeLog, loadDraco3d, readLayout } from "../../web/dist/src/client/index.js";
import { build } from "../../web/node_modules/vite/dist/node/index.js";

const repository = fileURLToPath(new URL("../../", import.meta.url));
const anyrate = process.env.ANYRATE ?? path.join(repository, "build/anyrate");
const viewer = process.env.ANYRATE_VIEWER ?? path.join(repository, "build/viewer");
const budgets = [10_000, 40_000];
const networks = {
    loopback: undefined,
    "1.6 Mbit/s, 150 ms": { offline: false, latency: 150, downloadThroughput: 1.6e6 / 8, uploadThroughput: 0.75e6 / 8 },
};
const id = "a".repeat(26);

const { values: options, positionals } = parseArgs({
    options: { runs: { type: "string", default: "3" }, tasks: { type: "boolean", default: false } },
    allowPositionals: true,
});
const log = readFileSync(positionals[0]);
const { index, frames } = readLayout(log);
const nVertices = index.at(-1).nVertices;

const scratch = mkdtempSync(path.join(os.tmpdir(), "anyrate-bench-"));
const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".svg": "image/svg+xml" };

function sendFile(response, file) {
    if (!existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { "Content-Type": types[path.extname(file)] ?? "application/octet-stream" });
    return createReadStream(file).pipe(response);
}

function sendLog(request, response) {
    const [, begin, end] = /bytes=(\d+)-(\d*)/.exec(request.headers.range).map(Number);
    const last = Math.min(end || Infinity, log.length - 1);
    const bytes = log.subarray(begin, last + 1);
    response.writeHead(206, {
        "Content-Range": `bytes ${begin}-${last}/${log.length}`,
        "Content-Length": bytes.length,
        "Cache-Control": "no-store",
        ETag: '"log"',
    });
    response.end(bytes);
}

const info = {
    id, state: "done", stage: "seal", fraction: 1, vertices: nVertices, bytes: log.length, distortion: null, attempts: 1,
    created: new Date().toISOString(), updated: new Date().toISOString(), options: { vertices: nVertices, coarse: 0 }, links: {},
};

const server = http.createServer((request, response) => {
    const { pathname, searchParams } = new URL(request.url, "http://localhost");
    const json = (value) => response.writeHead(200, { "Content-Type": "application/json" }).end(JSON.stringify(value));
    if (pathname === "/v1/models") return json({ models: [info] });
    if (pathname === `/v1/models/${id}`) return json(info);
    if (pathname === `/v1/models/${id}/log`) return sendLog(request, response);
    if (pathname === "/mesh.glb") return sendFile(response, path.join(scratch, `${Number(searchParams.get("vertices"))}.glb`));
    if (pathname.startsWith("/draco/")) {
        return sendFile(response, path.join(repository, "web/node_modules/three/examples/jsm/libs/draco/gltf", path.basename(pathname)));
    }
    if (pathname.startsWith("/glb")) return sendFile(response, path.join(scratch, "glb", pathname.slice(4)));
    if (pathname === "/" || pathname.startsWith("/models/")) return sendFile(response, path.join(viewer, "index.html"));
    return sendFile(response, path.join(viewer, pathname));
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const url = `http://127.0.0.1:${server.address().port}`;

const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
const drawn = (page, vertices) =>
    page.waitForFunction((n) => performance.getEntriesByName("drawn").some(({ detail }) => detail >= n), vertices);
/** Milliseconds from the click to the first frame with so many vertices. */
const since = (page, vertices) =>
    page.evaluate((n) => {
        const [click] = performance.getEntriesByName("click");
        return performance.getEntriesByName("drawn").find(({ startTime, detail }) => startTime > click.startTime && detail >= n).startTime - click.startTime;
    }, vertices);

async function openGallery(page) {
    await page.goto(url);
    await page.locator("canvas.painted").waitFor();
    await page.waitForTimeout(400); // of its fading in
}

const clickModel = (page) =>
    page.evaluate(() => {
        performance.clearMarks();
        performance.mark("click");
        document.querySelector(".card-link").click();
    });

async function timeLog(page, throttle) {
    await openGallery(page);
    await throttle();
    await clickModel(page);
    await drawn(page, budgets.at(-1) - 2);
    return [1, ...budgets.map((n) => n - 2)].reduce(async (times, n) => [...(await times), await since(page, n)], []);
}

async function timeGlb(page, throttle, vertices) {
    await page.goto(`${url}/glb/glb.html?vertices=${vertices}`);
    await page.locator("body[data-ready]").waitFor();
    await page.waitForTimeout(400); // of the decoder's start
    await throttle();
    await page.locator("#load").click();
    await drawn(page, 1);
    return since(page, 1);
}

async function compare() {
    for (const n of budgets) execFileSync(anyrate, ["decode", positionals[0], "-o", path.join(scratch, `${n}.glb`), "--vertices", `${n}`, "--draco"], { stdio: "ignore" });
    await build({
        configFile: false, logLevel: "silent", base: "/glb/", root: path.join(repository, "tests/bench/first_frame"),
        resolve: { alias: [
            { find: /^three\/addons/, replacement: path.join(repository, "web/node_modules/three/examples/jsm") },
            { find: /^three$/, replacement: path.join(repository, "web/node_modules/three/build/three.module.js") },
        ] },
        build: { outDir: path.join(scratch, "glb"), emptyOutDir: true, target: "es2022", rollupOptions: { input: path.join(repository, "tests/bench/first_frame/glb.html") } },
    });
    const glbBytes = Object.fromEntries(budgets.map((n) => [n, readFileSync(path.join(scratch, `${n}.glb`)).length]));
    const seconds = {};
    for (const [name, conditions] of Object.entries(networks)) {
        const logs = [];
        const glbs = budgets.map(() => []);
        for (let i = 0; i < Number(options.runs); ++i) {
            logs.push(await chromiumPage(conditions, timeLog));
            for (const [j, n] of budgets.entries()) glbs[j].push(await chromiumPage(conditions, (page, throttle) => timeGlb(page, throttle, n)));
        }
        const of = (k) => Math.round(median(logs.map((times) => times[k])));
        seconds[name] = {
            log_ms: { first_frame: of(0), ...Object.fromEntries(budgets.map((n, j) => [n, of(j + 1)])) },
            draco_glb_ms: Object.fromEntries(budgets.map((n, j) => [n, Math.round(median(glbs[j]))])),
        };
    }
    return { log_bytes: log.length, first_request_bytes: 8192, draco_glb_bytes: glbBytes, ...seconds };
}

/** The main thread's tasks while the log is fetched, replayed to its end, and coarsened. */
async function tasks(drawing) {
    const draco = await loadDraco3d();
    const { stateHash } = decodeLog(log, draco).mesh;
    const found = await chromiumPage(undefined, async (page, _, trace) => {
        if (!drawing) await page.addInitScript(leaveOutDrawing);
        await openGallery(page);
        const stop = await trace();
        await clickModel(page);
        await drawn(page, nVertices - 2);
        await page.waitForTimeout(600);
        const whole = await page.evaluate(() => document.querySelector("main.model").dataset.hash);
        if (whole !== stateHash.toString(16).padStart(8, "0")) throw new Error(`the page has the state hash ${whole}`);
        const slider = page.getByRole("slider", { name: "Budget", exact: true });
        for (let i = 0; i < 6; ++i) await slider.press("PageDown");
        await page.waitForTimeout(2500);
        return stop();
    });
    const longest = (key) => found.slice().sort((a, b) => b[key] - a[key]).slice(0, 6).map((task) => `${task[key].toFixed(1)} ${task.what}`);
    const over = (key) => found.filter((task) => task[key] > 16).length;
    return { tasks: found.length, over_16_ms_of_cpu: over("cpu"), over_16_ms_by_clock: over("wall"), longest_cpu_ms: longest("cpu"), longest_clock_ms: longest("wall") };
}

/** In the page, before it begins. */
function leaveOutDrawing() {
    for (const name of ["drawElements", "drawArrays", "bufferData", "bufferSubData"]) WebGL2RenderingContext.prototype[name] = () => {};
}

try {
    const [cpu] = os.cpus();
    const machine = { cpu: cpu?.model, cores: os.cpus().length, load_average: os.loadavg()[0], node: process.version };
    const report = { machine, vertices: nVertices, frames: frames.length, ...(options.tasks ? { main_thread: await tasks(true), without_drawing: await tasks(false) } : await compare()) };
    console.log(JSON.stringify(report, null, 1));
} finally {
    server.close();
    server.closeAllConnections();
    rmSync(scratch, { recursive: true });
}
