// The viewer as a visitor uses it: headless Chromium on a real `anyrate serve`.
// ANYRATE is the program; its viewer lies beside it (npm run viewer in web/).
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { afterAll, beforeAll, test } from "vitest";

import { decodeLog, loadDraco3d } from "../../../web/dist/src/client/index.js";
import { dropFiles, Proxy, run, scratchFolder, startBrowser, startServer } from "./harness.mjs";
import { askFor, data, picture, settled, visit } from "./pages.mjs";
import { differenceOf, drawnPixels, overlapOf } from "./pictures.mjs";
import { framesOfSockets } from "./socket_frames.mjs";

const nVertices = 3000;
const scratch = scratchFolder();
const capture = join(scratch.path, "capture");
let server, proxy, browser, draco;
/** The model that the second test makes, its log, and the vertices it came to. */
let id, log, most;

beforeAll(async () => {
    run("simulate", "--scene", "vessel", "-o", capture, "--views", "10", "--width", "320", "--height", "240");
    server = await startServer(join(scratch.path, "data"));
    proxy = new Proxy(server.url);
    await proxy.start();
    browser = await startBrowser();
    draco = await loadDraco3d();
});

afterAll(async () => {
    await browser?.close();
    proxy?.stop();
    await server?.stop();
    scratch.remove();
});

const withPage = ({ home = proxy.url, ...options }, use) => visit(browser, home, options, use);

const idOf = (page) => /models\/([a-z2-7]{26})/.exec(page.url())[1];
const expectedAt = (vertices) => decodeLog(log, draco, { vertices }).mesh;
const hex = (word) => word.toString(16).padStart(8, "0");

test("Upload: what is wrong is said per file before anything is sent", () =>
    withPage({}, async (page) => {
        const broken = join(scratch.path, "broken");
        cpSync(capture, broken, { recursive: true });
        const [image] = readdirSync(join(broken, "images"));
        rmSync(join(broken, "images", image));
        await page.goto(`${proxy.url}/?new`);
        await picture(page, "upload");
        await page.locator("input[webkitdirectory]").setInputFiles(broken);
        const faults = page.getByRole("alert").filter({ hasText: "not ready" });
        await faults.waitFor();
        assert.match(await faults.innerText(), new RegExp(`images/${image} is missing: cameras.json lists it`));
        assert.equal(await page.getByText("Upload and reconstruct").count(), 0);
    }));

/** Paths of the files that a page has sent, each as often as it was. */
function filesSent(page) {
    const sent = [];
    page.on("requestfinished", (request) => request.method() === "PUT" && sent.push(new URL(request.url()).pathname));
    return sent;
}

async function chooseCapture(page) {
    await page.goto(`${proxy.url}/?new`);
    await page.locator("input[webkitdirectory]").setInputFiles(capture);
    await page.getByText("10 photographs").waitFor();
    await page.getByLabel("Vertices of the finest mesh").fill(String(nVertices));
}

/** Of the upload that was left before it was done. */
let sentBefore = [];

test("Upload: one that is left half-way has sent what it has sent", () =>
    withPage({}, async (page) => {
        sentBefore = filesSent(page);
        let nFiles = 0;
        const seventh = new Promise((resolve) => {
            void page.route("**/v1/captures/*/files/**", (route) => (++nFiles <= 6 ? route.continue() : resolve()));
        });
        await chooseCapture(page);
        await page.getByText("Upload and reconstruct").click();
        await seventh;
        assert.equal(sentBefore.length, 6);
    }));

test("Upload: it goes on where it was left, and becomes a model that refines before one's eyes, though its connection is cut", () =>
    withPage({ expected: [/WebSocket connection to .* failed/, /net::ERR_CONNECTION_RESET/] }, async (page) => {
        const logs = framesOfSockets(page);
        const sent = filesSent(page);
        let nBroken = 0;
        await page.route("**/files/images/**", (route) => (++nBroken === 2 ? route.abort("connectionreset") : route.continue()));
        await chooseCapture(page);
        proxy.cutLiveAfter = 9000;
        await page.getByText("Upload and reconstruct").click();
        await page.waitForURL(/\/models\/[a-z2-7]{26}/);
        const all = [...sentBefore, ...sent];
        assert.equal(new Set(all).size, 21, "cameras, images and masks have arrived");
        assert.equal(all.length, 21, "and none was sent again, but for the one whose connection broke");
        id = idOf(page);
        await page.evaluate(() => {
            window.shown = new Set();
            setInterval(() => window.shown.add(document.querySelector("main.model")?.dataset.vertices), 50);
        });
        await page.waitForFunction(() => document.querySelector(".stages .current"));
        await page.waitForFunction(() => document.querySelector("main.model").dataset.vertices);
        await picture(page, "refining");
        await page.waitForFunction(() => document.querySelector(".title-line .chip")?.textContent === "Done", undefined, { polling: 50 });
        log = new Uint8Array(await (await fetch(`${server.url}/v1/models/${id}/log`)).arrayBuffer());
        const whole = expectedAt(1e9);
        most = whole.nVertices;
        await page.waitForFunction((n) => document.querySelector("main.model").dataset.vertices === String(n), whole.nVertices);
        await settled(page);
        assert.equal(await data(page, "hash"), hex(whole.stateHash));
        assert.equal(proxy.nCuts, 1, "the connection was cut once");
        const shown = await page.evaluate(() => [...window.shown]);
        assert.ok(shown.length > 2, `meshes of several sizes were shown, got ${shown}`);
        logs.assertEachOnce();
    }));

test("Upload: what the server refuses is said per file after the upload", () =>
    withPage({ expected: [/422/] }, async (page) => {
        const broken = join(scratch.path, "refused");
        cpSync(capture, broken, { recursive: true });
        const [first, second] = readdirSync(join(broken, "images")).sort();
        const whole = readFileSync(join(broken, "images", second));
        writeFileSync(join(broken, "images", second), whole.subarray(0, whole.length / 2));
        await page.goto(`${proxy.url}/?new`);
        const choose = async (folder) => {
            await page.locator("input[webkitdirectory]").setInputFiles(folder);
            await page.getByText("10 photographs").waitFor();
            await page.getByText("Upload and reconstruct").click();
        };
        await choose(broken);
        const refused = page.getByRole("alert").filter({ hasText: "The server refuses these files" }).last();
        await refused.waitFor();
        const items = await refused.getByRole("listitem").allInnerTexts();
        assert.equal(items.length, 1, `only the cut one is refused, got ${items}`);
        assert.ok(items[0].startsWith(`images/${second}: `) && !items[0].includes(first), items[0]);
        await picture(page, "upload-refused");
        assert.doesNotMatch(page.url(), /models/);
    }));

/** A zip of the capture. */
function zippedCapture() {
    const zip = join(scratch.path, "capture.zip");
    execFileSync("python3", ["-m", "zipfile", "-c", zip, "images", "masks", "cameras.json"], { cwd: capture });
    return zip;
}

test("Upload: a zip becomes a model, and its reconstruction can be cancelled", () =>
    withPage({ expected: [/404/] }, async (page) => {
        await page.goto(`${proxy.url}/?new`);
        await page.locator("input[accept]").setInputFiles(zippedCapture());
        await page.getByText("A zip, ").waitFor();
        await page.getByLabel("Vertices of the finest mesh").fill("200000");
        await page.getByText("Upload and reconstruct").click();
        await page.waitForURL(/\/models\/[a-z2-7]{26}/);
        await page.waitForFunction(() => document.querySelector(".stages .current"));
        await page.getByRole("button", { name: "Cancel" }).click();
        await page.getByText("This reconstruction was cancelled").waitFor();
        await page.waitForFunction(() => document.querySelector(".title-line .chip").textContent === "Cancelled");
        assert.equal(await page.getByRole("button", { name: "Cancel" }).count(), 0, "there is nothing left to cancel");
        const model = await (await fetch(`${server.url}/v1/models/${idOf(page)}`)).json();
        assert.equal(model.state, "cancelled");
    }));

test("Upload: a zip without cameras is refused before it is sent", () =>
    withPage({}, async (page) => {
        const zip = join(scratch.path, "no-cameras.zip");
        execFileSync("python3", ["-m", "zipfile", "-c", zip, "images"], { cwd: capture });
        await page.goto(`${proxy.url}/?new`);
        await dropFiles(page, { x: 30, y: 700 }, [zip]); // beside the place for it
        const faults = page.getByRole("alert").filter({ hasText: "not ready" });
        await faults.waitFor();
        assert.match(await faults.innerText(), /cameras\.json/);
    }));

test("Upload: a folder is dropped, and deleted while it is reconstructed: what was decoded stays", () =>
    withPage({ expected: [/404/] }, async (page) => {
        await page.goto(`${proxy.url}/?new`);
        const { x, y, width, height } = await page.locator(".drop").boundingBox();
        await dropFiles(page, { x: x + width / 2, y: y + height / 2 }, [capture]);
        await page.getByText("10 photographs").waitFor();
        await page.getByLabel("Vertices of the finest mesh").fill("200000");
        await page.getByText("Upload and reconstruct").click();
        await page.waitForURL(/\/models\/[a-z2-7]{26}/);
        await page.waitForFunction(() => Number(document.querySelector("main.model")?.dataset.vertices) > 0);
        assert.equal((await fetch(`${server.url}/v1/models/${idOf(page)}`, { method: "DELETE" })).status, 204);
        await page.getByText("This model was deleted").waitFor();
        assert.ok(Number(await data(page, "vertices")) > 0);
        await page.locator("canvas").press("ArrowLeft");
    }));

test("Private server: a token is asked for, one that is wrong has its sentence, and with the right one all works", async () => {
    const folder = join(scratch.path, "private");
    const made = run("token", "tests", "--data", folder, "--scope", "write").trim();
    const token = made.split(/\s+/).at(-1);
    const closed = await startServer(folder, "--private");
    try {
        await withPage({ home: closed.url, expected: [/401/] }, async (page) => {
            const addresses = [];
            page.on("request", (request) => addresses.push(request.url()));
            const dialog = page.getByRole("dialog");
            const give = async (word) => {
                await dialog.getByLabel("Token", { exact: true }).fill(word);
                await dialog.getByRole("button", { name: "Continue" }).click();
            };
            await page.goto(closed.url);
            await dialog.getByText("This server wants a token").waitFor();
            await picture(page, "token");
            await give("wrong");
            await dialog.getByText("The server does not know this token").waitFor();
            await give(token);
            await page.getByRole("link", { name: "New model from" }).click();
            await page.locator("input[webkitdirectory]").setInputFiles(capture);
            await page.getByLabel("Vertices of the finest mesh").fill(String(nVertices));
            await page.getByText("Upload and reconstruct").click();
            await page.waitForFunction(() => document.querySelector("main.model")?.dataset.vertices, undefined, { polling: 50 });
            await page.waitForFunction(() => document.querySelector(".title-line .chip")?.textContent === "Done");
            // "Done" may stand there before the last batch is drawn, which is what the link will be to.
            await page.waitForFunction((n) => Number(document.querySelector("main.model").dataset.vertices) > n, nVertices - 3);
            await settled(page);
            await page.waitForFunction(() => document.querySelector(".thumb img")?.naturalWidth > 0);
            const waiting = page.waitForEvent("download");
            await page.locator(".downloads").getByText("Log").click();
            const saved = new Uint8Array(readFileSync(await (await waiting).path()));
            assert.equal(decodeLog(saved, draco).mesh.nVertices, Number(await data(page, "vertices")));
            await page.goto(closed.url);
            await page.locator("canvas.painted").waitFor();
            assert.deepEqual(addresses.filter((address) => address.includes(token)), [], "the token is in no address");
        });
    } finally {
        await closed.stop();
    }
});

test("Gallery: the model is there with a picture of its first kilobytes", () =>
    withPage({}, async (page) => {
        await page.goto(proxy.url);
        const card = page.locator(`article[data-id="${id}"]`);
        await card.locator("canvas.painted").waitFor();
        const colours = await card.locator("canvas").evaluate((canvas) => {
            const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
            const seen = new Set();
            for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 0) seen.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
            return [...seen].filter((rgb) => Math.abs((rgb >> 16) - (rgb & 255)) > 40).length;
        });
        assert.ok(colours > 100, `the picture has the model's colours, got ${colours} of them`);
        assert.match(await card.innerText(), new RegExp(`Done\\s+${most.toLocaleString("en")} vertices`));
        await page.waitForTimeout(500); // of its fading in
        await picture(page, "gallery");
        await card.getByRole("link").click();
        await settled(page);
    }));

test("Gallery: a model that is being made shows how far it is, gets its picture on the way, and can be deleted", () =>
    withPage({ expected: [/404/] }, async (page) => {
        const made = await fetch(`${server.url}/v1/models?vertices=200000`, {
            method: "POST",
            headers: { "Content-Type": "application/zip" },
            body: readFileSync(zippedCapture()),
        });
        const { id: running } = await made.json();
        await page.goto(proxy.url);
        const card = page.locator(`article[data-id="${running}"]`);
        const told = await page.waitForFunction((model) => {
            const element = document.querySelector(`article[data-id="${model}"]`);
            const stage = element?.querySelector(".chip").textContent;
            const share = parseFloat(element?.querySelector(".fill").style.width);
            return share > 0 && share < 100 && /^[A-Z][a-z]+ \d+ %$/.test(stage) && { stage, share };
        }, running, { polling: 20 });
        const { stage, share } = await told.jsonValue();
        assert.equal(Number(/\d+/.exec(stage)[0]), Math.round(share), "the bar is as long as the number says");
        await page.waitForFunction(({ model, before }) => {
            const now = document.querySelector(`article[data-id="${model}"] .chip`).textContent;
            return / \d+ %$/.test(now) && now !== before;
        }, { model: running, before: stage }, { polling: 20 });
        await card.locator("canvas.painted").waitFor();
        await picture(page, "gallery-running");
        assert.match(await card.innerText(), /[\d,]+ vertices/);
        assert.equal((await fetch(`${server.url}/v1/models/${running}/cancel`, { method: "POST" })).ok, true);
        await card.getByText("Cancelled").waitFor();
        assert.equal(await card.locator(".bar").isVisible(), false, "there is no progress any more");
        page.on("dialog", (dialog) => void dialog.accept());
        await card.hover();
        await card.getByRole("button", { name: /Delete/ }).click();
        await card.waitFor({ state: "detached" });
        assert.equal((await fetch(`${server.url}/v1/models/${running}`)).status, 404);
    }));

test("Model page: the first 8,192 bytes make a picture, before the colours and the rest have come", () =>
    withPage({}, async (page) => {
        const { layout, mesh } = decodeLog(log, draco, { vertices: 1 });
        const [base, colours] = layout.index.map(({ end }) => layout.framesBegin + end);
        assert.ok(base <= 8192 && colours > 8192, `the base is in them, its colours are not, got ends at ${base} and ${colours}`);
        let release;
        const released = new Promise((resolve) => (release = resolve));
        await page.route(`**/v1/models/${id}/log`, async (route) => {
            if (route.request().headers()["range"] !== "bytes=0-8191") await released;
            await route.continue();
        });
        await page.goto(`${proxy.url}/models/${id}`);
        const drawn = () => page.evaluate(() => performance.getEntriesByName("drawn").map(({ detail }) => detail));
        await page.waitForFunction(() => performance.getEntriesByName("drawn").length > 0);
        await page.waitForFunction(() => document.querySelector("main.model").dataset.bytes);
        await page.locator(".thumb").first().waitFor(); // the view is then the one that stays
        const first = await drawnPixels(page);
        await picture(page, "first-picture");
        assert.equal(await data(page, "bytes"), "8192");
        assert.equal(await data(page, "hash"), hex(mesh.stateHash));
        assert.deepEqual(await drawn(), [mesh.nVertices]);
        assert.ok(first.mesh > 0.05 * first.all, `the mesh is seen, got ${first.mesh} of ${first.all} pixels`);
        assert.equal(first.coloured, 0, "and has no colours yet");
        release();
        await settled(page);
        await page.waitForFunction((n) => performance.getEntriesByName("drawn").at(-1).detail === n, most);
        await page.waitForTimeout(600); // of the colours that come out of the plain surface
        const last = await drawnPixels(page);
        await picture(page, "first-picture-coloured");
        assert.ok(last.coloured > 0.1 * last.mesh, `the colours have come, got ${last.coloured} of ${last.mesh} pixels`);
    }));

test("Model page: budgets up and down are the meshes that any reader decodes, by one request each raise", () =>
    withPage({}, async (page) => {
        const ranges = [];
        page.on("request", (request) => request.url().endsWith("/log") && ranges.push(request.headers()["range"]));
        await page.goto(`${proxy.url}/models/${id}?vertices=2600`);
        await settled(page);
        assert.equal(ranges[0], "bytes=0-8191");
        const opened = ranges.length;
        assert.ok(opened <= 2);
        for (const vertices of [2601, 2800, most, 2650, most - 3]) {
            await askFor(page, vertices);
            const mesh = expectedAt(vertices);
            assert.equal(Number(await data(page, "vertices")), mesh.nVertices);
            assert.equal(await data(page, "hash"), hex(mesh.stateHash));
        }
        assert.ok(ranges.length <= opened + 3, `three raises, got ${ranges}`);
        const ends = ranges.map((range) => /bytes=(\d+)-(\d+)/.exec(range).slice(1).map(Number));
        ends.slice(1).forEach(([begin], i) => assert.equal(begin, ends[i][1] + 1, "each goes on where the last one ended"));
        await picture(page, "model");
    }));

test("Model page: the curve and the slider lead to budgets, by keys too", () =>
    withPage({}, async (page) => {
        await page.goto(`${proxy.url}/models/${id}`);
        await settled(page);
        const [slider, plot] = [page.getByRole("slider", { name: "Budget", exact: true }), page.getByLabel("Rate-distortion curve")];
        const base = expectedAt(1).nVertices;
        // The first mesh with the least distortion, which a log of few photographs may have before its end.
        const distortions = decodeLog(log, draco).layout.index.map(({ meanDistortion }) => meanDistortion);
        const nearest = decodeLog(log, draco, { distortion: Math.min(...distortions.filter((d) => d > 0)) }).mesh.nVertices;
        const reached = (n) => page.waitForFunction((count) => document.querySelector("main.model").dataset.vertices === String(count), n);
        await slider.press("Home");
        await reached(base);
        for (const n of [base + 1, base + 2, base + 3]) {
            await slider.press("ArrowRight");
            await page.waitForFunction((count) => document.querySelector(".budget-number").value === String(count), n);
        }
        await reached(expectedAt(base + 3).nVertices);
        await page.getByRole("button", { name: "Bytes" }).first().click();
        await slider.press("End");
        await reached(most);
        assert.match(page.url(), /bytes=\d+/);
        await page.getByRole("button", { name: "Distortion", exact: true }).click();
        await slider.press("Home");
        await reached(base);
        assert.match(page.url(), /distortion=[\d.]+/);
        await slider.press("End");
        await reached(nearest);
        await page.getByRole("button", { name: "Bytes" }).first().click();
        await slider.press("End");
        await reached(most);
        await plot.press("ArrowLeft");
        await page.waitForFunction((n) => Number(document.querySelector("main.model").dataset.vertices) < n, most);
        const { width, height } = await plot.boundingBox();
        await plot.click({ position: { x: width - 3, y: height / 2 } });
        await reached(most);
    }));

test("Model page: the strip loads small copies of the photographs, and a photograph itself when it is looked through", () =>
    withPage({}, async (page) => {
        const asked = [];
        page.on("request", (request) => asked.push(/\/(thumbnails|photographs)\/\d+$/.exec(request.url())?.[0]));
        await page.goto(`${proxy.url}/models/${id}`);
        await page.waitForFunction(() => document.querySelector(".thumb img")?.naturalWidth > 0);
        const { width, height } = await page.locator(".thumb img").first().evaluate(({ naturalWidth, naturalHeight }) => ({ width: naturalWidth, height: naturalHeight }));
        assert.deepEqual([width, height], [216, 162]);
        assert.deepEqual(asked.filter((path) => path?.startsWith("/photographs/")), []);
        await page.locator(".thumb").nth(1).click();
        await page.locator("img.photograph").waitFor();
        assert.deepEqual(asked.filter((path) => path?.startsWith("/photographs/")), ["/photographs/1"]);
    }));

test("Model page: through a photograph's camera the mesh covers what the photograph's mask covers", () =>
    withPage({}, async (page) => {
        await page.goto(`${proxy.url}/models/${id}`);
        await settled(page);
        await page.locator(".thumb").nth(2).click();
        await page.locator("img.photograph").waitFor();
        await page.waitForTimeout(600); // of the morph
        await picture(page, "photograph");
        const share = await page.evaluate(() => {
            const stage = document.querySelector(".stage");
            for (const part of stage.querySelectorAll(".toolbar, .foot, .photograph")) part.style.visibility = "hidden";
            stage.style.background = "rgb(255, 0, 255)";
            const { left, top, width, height } = document.querySelector(".photograph").getBoundingClientRect();
            return { x: left, y: top, width, height };
        });
        const shot = await page.screenshot({ clip: share });
        const mask = readFileSync(join(capture, "masks", readdirSync(join(capture, "masks")).sort()[2]));
        const pictures = [shot.toString("base64"), mask.toString("base64")];
        const overlap = await page.evaluate(overlapOf, [...pictures, 0, 0]);
        assert.ok(overlap > 0.93, `expected the silhouettes to agree, got an overlap of ${overlap}`);
        for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
            const shifted = await page.evaluate(overlapOf, [...pictures, dx, dy]);
            assert.ok(shifted < overlap, `expected less than ${overlap} a pixel aside, got ${shifted} at ${dx} ${dy}`);
        }
        await page.locator("canvas").press("ArrowLeft");
        await page.locator("img.photograph").waitFor({ state: "hidden" });
    }));

test("Model page: edges and the map of the last step are drawn, and go again", () =>
    withPage({ reducedMotion: "reduce" }, async (page) => {
        await page.goto(`${proxy.url}/models/${id}?vertices=2600&shading=plain`);
        await settled(page);
        const stage = await page.locator(".stage canvas").boundingBox();
        const shown = async (name) => {
            await page.waitForTimeout(300); // of a few frames
            await picture(page, name);
            return (await page.screenshot({ clip: stage })).toString("base64");
        };
        const difference = (a, b) => page.evaluate(differenceOf, [a, b]);
        const edges = page.getByRole("button", { name: "Edges" });
        await page.getByRole("button", { name: "Last step" }).click();
        await page.getByText("No step yet: choose another budget.").waitFor();
        await page.getByRole("button", { name: "Plain" }).click();
        const plain = await shown("plain");
        await edges.click();
        const withEdges = await shown("edges");
        assert.ok((await difference(plain, withEdges)) > 1, "edges are seen");
        await edges.click();
        assert.ok((await difference(plain, await shown("edges-gone"))) < 0.1, "and go, but for the button that is pointed at");
        await edges.click();
        await askFor(page, most);
        await shown("edges-finer");
        await edges.click();
        const finer = await shown("plain-finer");
        await page.getByRole("button", { name: "Last step" }).click();
        await page.getByText(/^Last step: [\d,]+ new vertices, [\d,]+ moved$/).waitFor();
        await shown("last-step");
        const { mesh, coloured } = await drawnPixels(page);
        assert.ok(coloured > 0.05 * mesh && coloured < 0.9 * mesh, `what the step changed is marked, got ${coloured} of ${mesh} pixels`);
        await page.goto("about:blank");
        await page.goto(`${proxy.url}/models/${id}?vertices=${most}&shading=plain`);
        await settled(page);
        assert.ok((await difference(finer, await shown("plain-anew"))) < 0.5, "a page that is opened there shows the same");
    }));

test("Model page: downloads are the server's bytes at the budget that is shown", () =>
    withPage({}, async (page) => {
        await page.goto(`${proxy.url}/models/${id}?vertices=2800`);
        await settled(page);
        const vertices = await data(page, "vertices");
        for (const [label, path] of [["PLY", "mesh.ply"], ["OBJ", "mesh.obj"], ["GLB", "mesh.glb"], ["Log", "log"]]) {
            const waiting = page.waitForEvent("download");
            await page.locator(".downloads").getByText(label).click();
            const saved = readFileSync(await (await waiting).path());
            const sent = await fetch(`${server.url}/v1/models/${id}/${path}?vertices=${vertices}`);
            assert.deepEqual(saved, Buffer.from(await sent.arrayBuffer()), `${label} is what the server sends`);
        }
        const prefix = new Uint8Array(await (await fetch(`${server.url}/v1/models/${id}/log?vertices=${vertices}`)).arrayBuffer());
        assert.equal(decodeLog(prefix, draco, { vertices: Number(vertices) }).mesh.nVertices, Number(vertices));
    }));

test("Model page: a link opens the same budget, shading and view", () =>
    withPage({ permissions: ["clipboard-read", "clipboard-write"] }, async (page) => {
        await page.goto(`${proxy.url}/models/${id}?vertices=2700`);
        await settled(page);
        await page.getByRole("button", { name: "Normals" }).click();
        await page.locator("canvas").press("ArrowLeft");
        await page.locator("canvas").press("+");
        await page.getByRole("button", { name: "Copy link" }).click();
        await page.getByRole("button", { name: "Copied" }).waitFor();
        const [link, hash] = [await page.evaluate(() => navigator.clipboard.readText()), await data(page, "hash")];
        assert.match(link, /vertices=2700/);
        assert.match(link, /shading=normals/);
        const shown = await page.locator(".stage canvas").boundingBox();
        await page.waitForTimeout(700); // of damping and morph
        const before = await page.screenshot({ clip: shown });
        await page.goto("about:blank");
        await page.goto(link);
        await settled(page);
        assert.equal(await data(page, "hash"), hash);
        assert.equal(await page.getByRole("button", { name: "Normals" }).getAttribute("aria-pressed"), "true");
        await page.waitForTimeout(1200);
        const afterwards = await page.screenshot({ clip: shown });
        const difference = await page.evaluate(differenceOf, [before.toString("base64"), afterwards.toString("base64")]);
        assert.ok(difference < 2, `expected the same picture, got a mean difference of ${difference} of 255`);
    }));

test("Model page: where a page may not copy, the button says where the link is", () =>
    withPage({}, async (page) => {
        await page.addInitScript(() => Object.defineProperty(Navigator.prototype, "clipboard", { value: undefined }));
        await page.goto(`${proxy.url}/models/${id}`);
        await settled(page);
        await page.getByRole("button", { name: "Copy link" }).click();
        await page.getByRole("button", { name: "It is in the address bar" }).waitFor();
        assert.match(page.url(), /vertices=\d+/);
    }));

test("Pages: strict policy, a name and a ring for everything that the keyboard reaches", () =>
    withPage({}, async (page) => {
        const policy = (await page.goto(`${proxy.url}/models/${id}`)).headers()["content-security-policy"];
        assert.match(policy, /default-src 'none'/);
        assert.doesNotMatch(policy, /unsafe-inline|'unsafe-eval'|https?:|\*/);
        await settled(page);
        await page.locator(".thumb").first().waitFor();
        const reached = [];
        for (let i = 0; i < 60; ++i) {
            await page.keyboard.press("Tab");
            const focused = await page.evaluate(() => {
                const element = document.activeElement;
                if (!element || element === document.body) return undefined;
                const name = element.getAttribute("aria-label") ?? element.title ?? "";
                return {
                    tag: element.tagName,
                    name: name || element.textContent.trim() || element.querySelector("img")?.alt || "",
                    outline: getComputedStyle(element).outlineStyle,
                };
            });
            if (!focused) break;
            reached.push(focused);
        }
        const names = reached.map(({ name }) => name).join("|");
        for (const part of ["New model", "The model. Arrow keys", "Normals", "Fit", "Look through", "Budget", "Rate-distortion", "PLY"]) {
            assert.ok(names.includes(part), `expected to reach ${part} by keys, got ${names}`);
        }
        assert.deepEqual(reached.filter(({ name, outline }) => name === "" || outline === "none"), []);
    }));

test("Model page: with reduced motion a step is there at once", () =>
    withPage({ reducedMotion: "reduce" }, async (page) => {
        await page.goto(`${proxy.url}/models/${id}?vertices=1`);
        await settled(page);
        await askFor(page, most);
        await page.waitForFunction((n) => performance.getEntriesByName("drawn").at(-1).detail === n, most);
        await page.waitForTimeout(100); // two frames
        const shown = await page.locator(".stage canvas").boundingBox();
        const [at, later] = [await page.screenshot({ clip: shown }), (await page.waitForTimeout(500), await page.screenshot({ clip: shown }))];
        const difference = await page.evaluate(differenceOf, [at.toString("base64"), later.toString("base64")]);
        assert.equal(difference, 0, "nothing moves any more");
    }));

for (const [device, viewport] of [["phone", { width: 390, height: 844 }], ["desktop", { width: 1280, height: 820 }]]) {
    for (const colorScheme of ["light", "dark"]) {
        test(`Pages: on a ${device}, ${colorScheme}, nothing is cut off`, () =>
            withPage({ viewport, colorScheme, hasTouch: device === "phone" }, async (page) => {
                const check = async (name) => {
                    await page.waitForTimeout(600); // of what fades in
                    await picture(page, `${name}-${device}-${colorScheme}`);
                    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
                    assert.ok(overflow <= 0, `${name}: expected no sideways scrolling, got ${overflow} px`);
                    const dark = await page.evaluate(() => getComputedStyle(document.body).backgroundColor.match(/\d+/g).every((c) => c < 128));
                    assert.equal(dark, colorScheme === "dark", name);
                };
                await page.goto(proxy.url);
                await page.locator("canvas.painted").waitFor();
                await check("gallery");
                await page.goto(`${proxy.url}/?new`);
                await page.locator("input[webkitdirectory]").setInputFiles(capture);
                await page.getByText("10 photographs").waitFor();
                await check("upload");
                await page.goto(`${proxy.url}/models/${id}`);
                await settled(page);
                await page.waitForFunction(() => document.querySelector(".thumb img")?.naturalWidth > 0);
                await check("model");
                await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
                await check("model-below");
            }));
    }
}

test("Trouble: a damaged log is said to be, and the mesh before it stays", () =>
    withPage({}, async (page) => {
        await page.route(`**/v1/models/${id}/log`, async (route) => {
            const response = await route.fetch();
            const body = await response.body();
            if (!route.request().headers()["range"].startsWith("bytes=0-")) body[body.length - 40] ^= 1;
            await route.fulfill({ response, body });
        });
        await page.goto(`${proxy.url}/models/${id}`);
        await page.getByText("The stream is damaged").waitFor();
        await page.waitForFunction(() => Number(document.querySelector("main.model").dataset.vertices) >= 100);
    }));

test("Trouble: a lost connection has its sentence, and the way back", () =>
    withPage({ expected: [/Failed to load resource: net::ERR_/] }, async (page) => {
        await page.goto(`${proxy.url}/models/${id}?bytes=1`);
        await settled(page);
        const coarse = Number(await data(page, "vertices"));
        await page.route(`**/v1/models/${id}/log`, (route) => route.abort("connectionreset"));
        const field = page.getByLabel("Budget as a number");
        await field.fill("1000000");
        await field.press("Enter");
        await page.getByText("The connection is lost").waitFor();
        assert.equal(Number(await data(page, "vertices")), coarse, "what was decoded stays");
        await page.unroute(`**/v1/models/${id}/log`);
        await page.getByText("Try again").click();
        await page.waitForFunction((n) => document.querySelector("main.model").dataset.vertices === String(n), most);
    }));

test("Trouble: without WebGL the page says so, and still offers the downloads", () =>
    withPage({ expected: [/WebGL/] }, async (page) => {
        await page.addInitScript(() => {
            const getContext = HTMLCanvasElement.prototype.getContext;
            HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
                return kind.startsWith("webgl") ? null : getContext.call(this, kind, ...rest);
            };
        });
        await page.goto(`${proxy.url}/models/${id}`);
        await page.getByText("This browser shows no WebGL").waitFor();
        await page.locator(".downloads").getByText("PLY").waitFor();
    }));

/** An image that looks sound and cannot be decoded: the job finds that out. */
const jpegWithoutTables = (width, height) =>
    Buffer.concat([
        Buffer.from([0xff, 0xd8, 0xff, 0xc0, 0, 17, 8, height >> 8, height & 255, width >> 8, width & 255]),
        Buffer.from([3, 1, 0x22, 0, 2, 0x11, 1, 3, 0x11, 1, 0xff, 0xda, 0, 12, 3, 1, 0, 2, 0x11, 3, 0x11, 0, 63, 0]),
        Buffer.alloc(64),
        Buffer.from([0xff, 0xd9]),
    ]);

test("Trouble: a failed job and a model that is not there have their sentences", () =>
    withPage({ expected: [/404/] }, async (page) => {
        const form = new FormData();
        for (const name of readdirSync(capture, { recursive: true }).filter((file) => /^images.*png$|^masks.*png$|cameras.json$/.test(file)))
            form.append("file", new Blob([name === "images/000.png" ? jpegWithoutTables(320, 240) : readFileSync(join(capture, name))]), name);
        const response = await fetch(`${server.url}/v1/models`, { method: "POST", body: form });
        const failed = (await response.json()).id;
        await page.goto(`${proxy.url}/models/${failed}`);
        await page.getByText("The reconstruction failed").waitFor();
        await page.goto(`${proxy.url}/models/${"a".repeat(26)}`);
        await page.getByText("There is no such model").waitFor();
    }));

test("Trouble: a model that is deleted while it is looked at leaves what was decoded", () =>
    withPage({ expected: [/404/] }, async (page) => {
        await page.goto(`${proxy.url}/models/${id}?bytes=1`);
        await settled(page);
        await fetch(`${server.url}/v1/models/${id}`, { method: "DELETE" });
        const field = page.getByLabel("Budget as a number");
        await field.fill("1000000");
        await field.press("Enter");
        await page.locator(".notice").filter({ hasText: /no model|deleted/ }).waitFor();
        assert.ok(Number(await data(page, "vertices")) > 0);
    }));
