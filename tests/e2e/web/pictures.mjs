// What pictures of a page show. Functions "in the page" are for page.evaluate(), so they use nothing of this file.

/** Shows the canvas of the stage alone, on magenta, while `use` looks at it. */
async function canvasAlone(page, use) {
    const sheet = await page.evaluateHandle(() => {
        const rules = new CSSStyleSheet();
        rules.replaceSync(".stage { background: rgb(255, 0, 255) !important; } .stage canvas { outline: none !important; } .stage > :not(canvas) { visibility: hidden !important; }");
        document.adoptedStyleSheets.push(rules);
        return rules;
    });
    const shown = await use();
    await page.evaluate((rules) => (document.adoptedStyleSheets = document.adoptedStyleSheets.filter((other) => other !== rules)), sheet);
    return shown;
}

/**
 * Counts pixels of the stage: all of them, those that the mesh covers, and of these the ones that are no shade of grey,
 * and the ones whose colour is a unit vector that points to the eye, as normals are drawn. `box` holds the mesh, in pixels.
 */
export async function drawnPixels(page) {
    const shot = await canvasAlone(page, async () => page.screenshot({ clip: await page.locator(".stage canvas").boundingBox() }));
    return page.evaluate(async (base64) => {
        const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
        const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
        context.drawImage(image, 0, 0);
        const { data } = context.getImageData(0, 0, image.width, image.height);
        let [mesh, coloured, normals] = [0, 0, 0];
        const box = { left: Infinity, top: Infinity, right: -Infinity, bottom: -Infinity };
        for (let i = 0; i < data.length; i += 4) {
            const [r, g, b] = data.subarray(i, i + 3);
            if (r > 200 && g < 60 && b > 200) continue;
            ++mesh;
            if (Math.abs(r - b) > 40) ++coloured;
            const vector = [r, g, b].map((c) => (2 * c) / 255 - 1);
            if (vector[2] > -0.1 && Math.abs(Math.hypot(...vector) - 1) < 0.05) ++normals;
            const [x, y] = [(i / 4) % image.width, Math.floor(i / 4 / image.width)];
            [box.left, box.right] = [Math.min(box.left, x), Math.max(box.right, x)];
            [box.top, box.bottom] = [Math.min(box.top, y), Math.max(box.bottom, y)];
        }
        return { all: image.width * image.height, width: image.width, height: image.height, mesh, coloured, normals, box };
    }, shot.toString("base64"));
}

/**
 * In the page: intersection over union of what is not magenta in one picture and what is white in the other, which is
 * shifted by some pixels.
 */
export async function overlapOf([shown, mask, dx, dy]) {
    const [width, height] = [320, 240];
    const pixels = async (base64, x, y) => {
        const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
        const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        const context = new OffscreenCanvas(width, height).getContext("2d");
        context.drawImage(image, x, y, width, height);
        return context.getImageData(0, 0, width, height).data;
    };
    const [a, b] = [await pixels(shown, 0, 0), await pixels(mask, dx, dy)];
    let [both, either] = [0, 0];
    for (let i = 0; i < a.length; i += 4) {
        const isMesh = !(a[i] > 200 && a[i + 1] < 60 && a[i + 2] > 200);
        const isMask = b[i] > 127;
        if (isMesh && isMask) ++both;
        if (isMesh || isMask) ++either;
    }
    return both / either;
}

/** In the page: mean absolute difference of two pictures' channels. */
export async function differenceOf(pictures) {
    const [a, b] = await Promise.all(pictures.map(async (base64) => {
        const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
        const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
        context.drawImage(image, 0, 0);
        return context.getImageData(0, 0, image.width, image.height).data;
    }));
    let sum = 0;
    for (let i = 0; i < a.length; ++i) sum += Math.abs(a[i] - b[i]);
    return sum / a.length;
}
