// A visitor's pages, and what a model's page tells whoever tests it. SCREENSHOTS is a folder that gets pictures.
import assert from "node:assert/strict";
import { join } from "node:path";

const patience = 180_000; // ms, far above what is needed, also on a machine that others use

/**
 * A page that fails its test if it has an error, or asks another host than `home`.
 * @param options of Playwright's context, and `expected`: patterns of errors that are meant to be
 */
export async function visit(browser, home, { expected = [], ...options }, use) {
    const context = await browser.newContext({ viewport: { width: 1280, height: 820 }, ...options });
    const page = await context.newPage();
    page.setDefaultTimeout(patience);
    const complaints = [];
    page.on("pageerror", (error) => complaints.push(error.message));
    page.on("console", (line) => line.type() === "error" && complaints.push(line.text()));
    page.on("request", (request) => {
        const { origin, protocol } = new URL(request.url());
        if (protocol.startsWith("http") && origin !== home) complaints.push(`a request to ${request.url()}`);
    });
    try {
        await use(page);
        const unexpected = complaints.filter((text) => !expected.some((pattern) => pattern.test(text)));
        assert.deepEqual(unexpected, []);
    } finally {
        await context.close();
    }
}

const main = (page) => page.locator("main.model");
export const data = (page, name) => main(page).evaluate((element, key) => element.dataset[key], name);

export async function settled(page) {
    await page.waitForFunction(() => {
        const element = document.querySelector("main.model");
        return element?.dataset.vertices && !element.hasAttribute("aria-busy");
    });
}

/** Types a number of vertices, and waits until they are there. */
export async function askFor(page, vertices) {
    const field = page.getByLabel("Budget as a number");
    await field.fill(String(vertices));
    await field.press("Enter");
    await page.waitForFunction((n) => {
        const { dataset } = document.querySelector("main.model");
        return Number(dataset.vertices) <= n && Number(dataset.vertices) >= n - 2;
    }, vertices);
    await settled(page);
}

/** Only for whoever looks: see above. */
export async function picture(page, name) {
    if (process.env.SCREENSHOTS) await page.screenshot({ path: join(process.env.SCREENSHOTS, `${name}.png`) });
}
