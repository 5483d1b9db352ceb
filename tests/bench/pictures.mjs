#!/usr/bin/env node
// The README's pictures of the viewer: pictures.mjs URL [--out FOLDER=tests/bench/results]
//
// URL is a model's page, such as server/run.sh prints; the model must be done. Writes viewer_model.png, the page, and
// viewer_plot.png, its rate-distortion curve.
import path from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

import { startBrowser } from "../e2e/web/harness.mjs";

const { values: options, positionals } = parseArgs({
    options: { out: { type: "string", default: fileURLToPath(new URL("results", import.meta.url)) } },
    allowPositionals: true,
});
if (positionals.length !== 1) throw new Error("usage: pictures.mjs URL [--out FOLDER]");

const browser = await startBrowser();
try {
    const page = await browser.newPage({ viewport: { width: 1360, height: 860 } });
    await page.goto(positionals[0]);
    await page.waitForFunction(() => {
        const element = document.querySelector("main.model");
        return element?.dataset.vertices && !element.hasAttribute("aria-busy");
    });
    await page.waitForLoadState("networkidle"); // the photographs
    await page.waitForTimeout(1500); // of the last morph
    await page.screenshot({ path: path.join(options.out, "viewer_model.png") });
    const plot = await browser.newPage({ viewport: { width: 1360, height: 860 }, deviceScaleFactor: 2 });
    await plot.goto(positionals[0]);
    await plot.locator(".plot .point").waitFor();
    await plot.waitForTimeout(1500);
    await plot.locator(".panel.plot").screenshot({ path: path.join(options.out, "viewer_plot.png") });
} finally {
    await browser.close();
}
