import { startBrowser } from "../../e2e/web/harness.mjs";

/**
 * Runs `use(page, throttle, trace)` in a browser of its own. throttle() slows the network from then on; trace() begins
 * to listen, and what it gives stops that and gives the main thread's tasks as {wall, cpu, what}, in milliseconds: what
 * it took of a clock and of a processor, and the longest named part of it.
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

/** Parts of a task that say nothing of what it does. */
const frames = /^(ThreadControllerImpl::RunTask|RunTask|v8\.callFunction|v8\.run|TimerFire|HandlePostMessage|Receive mojo message|BlinkScheduler_.*|FireAnimationFrame|EventDispatch|RunYieldContinuation)$/;

/** Of the renderer that is busiest: the page's. */
function mainThreadTasks(events) {
    const mains = events.filter(({ name, args }) => name === "thread_name" && args.name === "CrRendererMain");
    const of = ({ pid, tid }) => {
        const own = events.filter((event) => event.pid === pid && event.tid === tid && event.dur);
        return own.filter(({ name }) => name === "RunTask").map((task) => {
            const parts = own.filter(({ name, ts, dur }) => !frames.test(name) && ts >= task.ts && ts + dur <= task.ts + task.dur + 1);
            const longest = parts.reduce((most, part) => (part.dur > (most?.dur ?? 0) ? part : most), undefined);
            return { wall: task.dur / 1000, cpu: (task.tdur ?? 0) / 1000, what: longest?.name ?? "script" };
        });
    };
    const sum = (tasks) => tasks.reduce((total, { wall }) => total + wall, 0);
    return mains.map(of).sort((a, b) => sum(b) - sum(a))[0] ?? [];
}
