import { startBrowser } from "../../e2e/web/harness.mjs";

/**
 * Runs `use(page, throttle, trace)` in a browser of its own. throttle() slows the network from then on; trace() begins
 * to listen, and what it gives stops that and gives the durations of the main thread's tasks in milliseconds.
 */
export async function chromiumPage(conditions, use) {
    const browser = await startBrowser();
    try {
        const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
        page.setDefaultTimeout(60_000);
        const devtools = await page.context().newCDPSession(page);
        await devtools.send("Network.enable");
        await devtools.send("Network.setCacheDisabled", { cacheDisabled: true });
        const throttle = async () => conditions && devtools.send("Network.emulateNetworkConditions", conditions);
        const trace = async () => {
            await browser.startTracing(page, { categories: ["toplevel", "disabled-by-default-devtools.timeline", "devtools.timeline", "__metadata"] });
            return async () => mainThreadTasks(JSON.parse((await browser.stopTracing()).toString()).traceEvents, page.url());
        };
        return await use(page, throttle, trace);
    } finally {
        await browser.close();
    }
}

/** Of the renderer that is busiest: the page's. */
function mainThreadTasks(events) {
    const mains = events.filter(({ name, args }) => name === "thread_name" && args.name === "CrRendererMain");
    const of = ({ pid, tid }) =>
        events.filter((event) => event.pid === pid && event.tid === tid && event.name === "RunTask" && event.dur).map(({ dur }) => dur / 1000);
    const sum = (durations) => durations.reduce((total, ms) => total + ms, 0);
    return mains.map(of).sort((a, b) => sum(b) - sum(a))[0] ?? [];
}
