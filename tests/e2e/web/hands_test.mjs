// A model under a visitor's hands: what mouse, fingers and keys do to the view, and how it is drawn.
import assert from "node:assert/strict";
import { join } from "node:path";

import { afterAll, beforeAll, test } from "vitest";

import { run, scratchFolder, startBrowser, startServer } from "./harness.mjs";
import { picture, settled, visit } from "./pages.mjs";
import { differenceOf, drawnPixels } from "./pictures.mjs";

const scratch = scratchFolder();
let server, browser, address;

beforeAll(async () => {
    const capture = join(scratch.path, "capture");
    run("simulate", "--scene", "vessel", "-o", capture, "--views", "8", "--width", "320", "--height", "240");
    server = await startServer(join(scratch.path, "data"));
    browser = await startBrowser();
    const id = run("push", capture, "--server", server.url, "--wait", "--vertices", "1500").trim();
    address = `${server.url}/models/${id}`;
});

afterAll(async () => {
    await browser?.close();
    await server?.stop();
    scratch.remove();
});

/** Until the address has told the same view for a while: on a busy machine what covers the model comes late. */
async function stillView(page) {
    let [before, now] = [undefined, page.url()];
    while (before !== now) {
        before = now;
        await page.waitForTimeout(500);
        now = page.url();
    }
}

/** The model's page, which stands still unless something moves it. */
const withModel = (options, use, query = "") =>
    visit(browser, server.url, { reducedMotion: "reduce", ...options }, async (page) => {
        await page.goto(address + query);
        await settled(page);
        await page.locator(".thumb").first().waitFor();
        await stillView(page);
        await use(page);
    });

/** What the address says of the view. */
async function viewOf(page) {
    const numbers = await page.evaluate(() => new URLSearchParams(location.search).get("view").split("_").map(Number));
    const [eye, target] = [numbers.slice(0, 3), numbers.slice(3)];
    const offset = eye.map((x, i) => x - target[i]);
    return { eye, target, offset, distance: Math.hypot(...offset) };
}

const apart = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
const angleBetween = (a, b) => Math.acos(Math.min(1, a.reduce((sum, x, i) => sum + x * b[i], 0) / (Math.hypot(...a) * Math.hypot(...b))));

async function middleOfStage(page) {
    const { x, y, width, height } = await page.locator(".stage canvas").boundingBox();
    return [x + width / 2, y + height / 2];
}

async function drag(page, dx, dy, button = "left") {
    const [x, y] = await middleOfStage(page);
    await page.mouse.move(x, y);
    await page.mouse.down({ button });
    await page.mouse.move(x + dx, y + dy, { steps: 8 });
    await page.mouse.up({ button });
}

test("Mouse: a drag turns the model about its middle, and the address says so", () =>
    withModel({}, async (page) => {
        const before = await viewOf(page);
        await drag(page, 150, 0);
        const sideways = await viewOf(page);
        assert.ok(angleBetween(before.offset, sideways.offset) > 0.2, "the eye went round");
        assert.ok(apart(before.target, sideways.target) < 1e-6 * before.distance, "about the same point");
        assert.ok(Math.abs(sideways.distance / before.distance - 1) < 1e-4, "as far away as before");
        await drag(page, 0, 100);
        assert.ok(angleBetween(sideways.offset, (await viewOf(page)).offset) > 0.2, "and over it");
    }));

test("Mouse: a drag of the right button moves the model with the pointer", () =>
    withModel({}, async (page) => {
        const [before, { box }] = [await viewOf(page), await drawnPixels(page)];
        await drag(page, 90, 40, "right");
        const [after, moved] = [await viewOf(page), await drawnPixels(page)];
        assert.ok(apart(before.offset, after.offset) < 1e-4 * before.distance, "it is seen from the same side");
        for (const [side, shift] of [["left", 90], ["right", 90], ["top", 40], ["bottom", 40]]) {
            const got = moved.box[side] - box[side];
            assert.ok(Math.abs(got - shift) < 0.15 * shift, `${side}: expected a shift of about ${shift} pixels, got ${got}`);
        }
    }));

test("Mouse: the wheel goes nearer and farther, and Fit has all of the model in view again", () =>
    withModel({}, async (page) => {
        const [before, { box }] = [await viewOf(page), await drawnPixels(page)];
        const height = ({ top, bottom }) => bottom - top;
        await page.mouse.move(...(await middleOfStage(page)));
        const scrolled = async (amount) => {
            const { distance } = await viewOf(page);
            await page.mouse.wheel(0, amount);
            await page.waitForFunction((d) => {
                const [x, y, z, a, b, c] = new URLSearchParams(location.search).get("view").split("_").map(Number);
                return Math.abs(Math.hypot(x - a, y - b, z - c) - d) > 1e-3 * d;
            }, distance);
            return viewOf(page);
        };
        assert.ok((await scrolled(-400)).distance < 0.9 * before.distance);
        assert.ok(height((await drawnPixels(page)).box) > 1.1 * height(box), "it is larger");
        assert.ok((await scrolled(1200)).distance > 1.1 * before.distance);
        assert.ok(height((await drawnPixels(page)).box) < 0.9 * height(box), "it is smaller");
        await drag(page, 60, 90, "right");
        await drag(page, 90, 30);
        await page.getByRole("button", { name: "Fit the model" }).click();
        const [fitted, shown] = [await viewOf(page), await drawnPixels(page)];
        assert.ok(apart(fitted.target, before.target) < 1e-4 * before.distance, "the model is in the middle");
        assert.ok(Math.abs(fitted.distance / before.distance - 1) < 1e-3, "as it was when the page opened");
        assert.ok(shown.box.left > 0 && shown.box.right < shown.width - 1 && shown.box.top > 0 && shown.box.bottom < shown.height - 1, "all of it");
    }));

test("View: the address tells it, though the photographs come after the model", () =>
    visit(browser, server.url, { reducedMotion: "reduce" }, async (page) => {
        await page.route("**/cameras", async (route) => {
            await settled(page);
            await route.continue();
        });
        await page.goto(address);
        await page.locator(".thumb").first().waitFor();
        await stillView(page);
        const told = await viewOf(page);
        await page.getByRole("button", { name: "Fit the model" }).click();
        const fitted = await viewOf(page);
        assert.ok(Math.abs(fitted.distance / told.distance - 1) < 1e-4, `fitted at ${fitted.distance}, told ${told.distance}`);
    }));

test("View: it fits the window until it is touched, and then stays as it was made", () =>
    withModel({}, async (page) => {
        const resizedTo = async (width, height) => {
            await page.setViewportSize({ width, height });
            await page.waitForTimeout(300); // of a few frames
            const { box, ...shown } = await drawnPixels(page);
            await page.locator(".stage canvas").press("ArrowLeft"); // the address is told the view
            await page.locator(".stage canvas").press("ArrowRight");
            return { box, shown, view: await viewOf(page) };
        };
        const narrow = await resizedTo(900, 820);
        assert.ok(narrow.box.left > 0 && narrow.box.right < narrow.shown.width - 1, "all of it is in view");
        await page.mouse.move(...(await middleOfStage(page)));
        await page.mouse.wheel(0, -300);
        await page.waitForTimeout(300);
        const before = await viewOf(page);
        const { view } = await resizedTo(1280, 820);
        assert.ok(apart(view.eye, before.eye) < 1e-3 * before.distance, "the view that was made is still there");
    }));

test("Mouse: a movement that fades out ends where the address says", () =>
    withModel({ reducedMotion: "no-preference" }, async (page) => {
        await drag(page, 150, 60);
        const standing = async () => {
            const shot = async () => (await page.screenshot({ clip: await page.locator(".stage canvas").boundingBox() })).toString("base64");
            for (let last = await shot(); ; ) {
                await page.waitForTimeout(400);
                const next = await shot();
                if (next === last) return next;
                last = next;
            }
        };
        const before = await standing();
        const link = page.url();
        await page.goto("about:blank");
        await page.goto(link);
        await settled(page);
        await page.locator(".thumb img[src]").first().waitFor();
        const difference = await page.evaluate(differenceOf, [before, await standing()]);
        assert.ok(difference < 0.5, `expected the same picture, got a mean difference of ${difference} of 255`);
    }));

test("Fingers: one turns the model, two that spread go nearer", () =>
    withModel({ hasTouch: true, viewport: { width: 390, height: 844 } }, async (page) => {
        const devtools = await page.context().newCDPSession(page);
        const [x, y] = await middleOfStage(page);
        const touch = (type, points) => devtools.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
        const before = await viewOf(page);
        await touch("touchStart", [[x, y]]);
        for (let i = 1; i <= 6; ++i) await touch("touchMove", [[x + 12 * i, y]]);
        await touch("touchEnd", []);
        const turned = await viewOf(page);
        assert.ok(angleBetween(before.offset, turned.offset) > 0.1);
        assert.ok(apart(before.target, turned.target) < 1e-6 * before.distance);
        await touch("touchStart", [[x - 30, y], [x + 30, y]]);
        for (let i = 1; i <= 6; ++i) await touch("touchMove", [[x - 30 - 10 * i, y], [x + 30 + 10 * i, y]]);
        await touch("touchEnd", []);
        const nearer = await viewOf(page);
        assert.ok(nearer.distance < 0.8 * before.distance, `expected less than ${before.distance}, got ${nearer.distance}`);
    }));

test("Keys: arrows turn, W A S D move, + and - zoom, F fits", () =>
    withModel({}, async (page) => {
        const canvas = page.locator(".stage canvas");
        const before = await viewOf(page);
        await canvas.press("ArrowLeft");
        const turned = await viewOf(page);
        assert.ok(Math.abs(angleBetween(before.offset, turned.offset)) > 0.03);
        await canvas.press("+");
        assert.ok((await viewOf(page)).distance < before.distance);
        await canvas.press("-");
        const { box } = await drawnPixels(page);
        for (const key of ["d", "d", "w"]) await canvas.press(key);
        const moved = (await drawnPixels(page)).box;
        assert.ok(moved.left > box.left + 20 && moved.top < box.top - 10, `it went right and up, from ${JSON.stringify(box)} to ${JSON.stringify(moved)}`);
        for (const key of ["a", "a", "s"]) await canvas.press(key);
        assert.ok(apart((await viewOf(page)).target, before.target) < 1e-4 * before.distance, "and back");
        await canvas.press("d");
        await canvas.press("f");
        assert.ok(apart((await viewOf(page)).target, before.target) < 1e-4 * before.distance);
    }));

test("Shading: colours, the plain surface and its normals are drawn as what they are", () =>
    withModel({}, async (page) => {
        const shaded = async (name) => {
            await page.getByRole("button", { name, exact: true }).click();
            await page.waitForTimeout(200); // of a few frames
            await picture(page, `shading-${name}`);
            return drawnPixels(page);
        };
        const colour = await shaded("Colour");
        assert.ok(colour.coloured > 0.1 * colour.mesh, `got ${colour.coloured} coloured pixels of ${colour.mesh}`);
        const plain = await shaded("Plain");
        assert.equal(plain.coloured, 0);
        assert.ok(plain.normals < 0.5 * plain.mesh);
        const normals = await shaded("Normals");
        assert.ok(normals.normals > 0.9 * normals.mesh, `expected unit vectors towards the eye, got ${normals.normals} of ${normals.mesh} pixels`);
        for (const { mesh } of [colour, normals]) assert.ok(Math.abs(mesh / plain.mesh - 1) < 0.01, "it is the same surface");
    }));

test("Drawing: what a browser takes away to save its memory is drawn again when it gives it back", () =>
    withModel({ expected: [/context/i] }, async (page) => {
        const before = await drawnPixels(page);
        await page.evaluate(async () => {
            const canvas = document.querySelector(".stage canvas");
            const extension = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
            const lost = new Promise((resolve) => canvas.addEventListener("webglcontextlost", resolve, { once: true }));
            extension.loseContext();
            await lost;
            const restored = new Promise((resolve) => canvas.addEventListener("webglcontextrestored", resolve, { once: true }));
            await new Promise((resolve) => setTimeout(resolve));
            extension.restoreContext();
            await restored;
        });
        await page.waitForTimeout(500); // of a few frames
        const after = await drawnPixels(page);
        assert.ok(Math.abs(after.mesh - before.mesh) <= 0.01 * before.mesh, `expected ${before.mesh} pixels, got ${after.mesh}`);
        assert.deepEqual(after.box, before.box);
        assert.ok(after.coloured > 0.1 * after.mesh);
    }));

test("Photograph: the slider goes from the mesh over it to it over the mesh", () =>
    withModel({}, async (page) => {
        await page.locator(".thumb").nth(2).click();
        await page.locator("img.photograph").waitFor();
        const slider = page.getByRole("slider", { name: "Blend" });
        const place = await page.locator("img.photograph").boundingBox();
        const clip = { x: place.x + 2, y: place.y + 2, width: place.width - 4, height: place.height - 4 };
        const [strip, bars] = [await page.locator(".blend").boundingBox(), await page.locator(".toolbar").boundingBox()];
        assert.ok(place.y >= bars.y + bars.height - 1 && place.y + place.height <= strip.y + 1, "it lies between the bars");
        const shotWithout = async (selector) => {
            const sheet = await page.evaluateHandle((hidden) => {
                const rules = new CSSStyleSheet();
                rules.replaceSync(`${hidden} { visibility: hidden !important; }`);
                document.adoptedStyleSheets.push(rules);
                return rules;
            }, selector);
            const shot = await page.screenshot({ clip });
            await page.evaluate((rules) => (document.adoptedStyleSheets = document.adoptedStyleSheets.filter((other) => other !== rules)), sheet);
            return shot.toString("base64");
        };
        const shownAt = async (share) => {
            await slider.fill(String(share));
            await page.waitForTimeout(200); // of a few frames
            await picture(page, `blend-${share}`);
            return { all: (await page.screenshot({ clip })).toString("base64"), mesh: await shotWithout(".photograph"), photograph: await shotWithout(".stage canvas") };
        };
        const difference = (a, b) => page.evaluate(differenceOf, [a, b]);
        const over = await shownAt(100);
        assert.ok((await difference(over.all, over.photograph)) < 0.1, "the photograph hides the mesh");
        const half = await shownAt(50);
        assert.ok((await difference(half.all, half.photograph)) > 0.3 && (await difference(half.all, half.mesh)) > 0.3, "both are seen");
        const behind = await shownAt(0);
        assert.ok((await difference(behind.all, behind.photograph)) > 0.3, "the mesh is seen");
        assert.ok((await difference(behind.all, behind.mesh)) > 0.3, "and the photograph round it");
        const [inFront, blended] = [await page.evaluate(differenceWhereDrawn, [behind.all, behind.mesh]), await page.evaluate(differenceWhereDrawn, [half.all, half.mesh])];
        assert.ok(inFront < 0.15 * blended, `the mesh is in front of the photograph, got a mean difference of ${inFront} of 255, half-way ${blended}`);
    }));

/**
 * In the page: mean difference of the first two pictures, where the second has the mesh: where it differs from the page's
 * background, which is the same in its upper left corner.
 */
async function differenceWhereDrawn(pictures) {
    const [all, mesh] = await Promise.all(pictures.slice(0, 2).map(async (base64) => {
        const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
        const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
        context.drawImage(image, 0, 0);
        return context.getImageData(0, 0, image.width, image.height).data;
    }));
    let [sum, n] = [0, 0];
    for (let i = 0; i < mesh.length; i += 4) {
        const isDrawn = Math.max(mesh[i], mesh[i + 1], mesh[i + 2]) < 200; // the page is light
        if (!isDrawn) continue;
        ++n;
        for (let c = 0; c < 3; ++c) sum += Math.abs(all[i + c] - mesh[i + c]) / 3;
    }
    return n > 1000 ? sum / n : NaN;
}
