// A server under test, a connection to it that can be cut, and a browser.
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, rmSync } from "node:fs";
import net from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

import { chromium } from "../../../web/node_modules/playwright-core/index.mjs";

const repository = new URL("../../../", import.meta.url);
export const anyrate = process.env.ANYRATE ?? fileURLToPath(new URL("build/anyrate", repository));

/** Runs `anyrate WORDS`, which must succeed. */
export function run(...words) {
    return execFileSync(anyrate, words, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
}

export function scratchFolder() {
    const folder = mkdtempSync(join(tmpdir(), "anyrate-e2e-"));
    return { path: folder, remove: () => rmSync(folder, { recursive: true, force: true }) };
}

/** `anyrate serve` on a free port, with the viewer beside the program. */
export async function startServer(data, ...options) {
    const child = spawn(anyrate, ["serve", "--listen", "127.0.0.1:0", "--data", data, ...options], { stdio: ["ignore", "pipe", "ignore"] });
    const [line] = await once(createInterface(child.stdout), "line");
    const url = /^listening on (http:\S+)$/.exec(line)?.[1];
    if (!url) throw new Error(`the server did not start: ${line}`);
    return {
        url,
        stop: async () => {
            child.kill("SIGTERM");
            await once(child, "exit");
        },
    };
}

/** What a browser connects to in the server's place: passes bytes on, until it is told to cut. */
export class Proxy {
    /** Bytes of the next live connection after which it is cut; undefined leaves it whole. */
    cutLiveAfter = undefined;
    nCuts = 0;
    #target;
    #sockets = new Set();
    #server = net.createServer((client) => this.#pass(client));

    constructor(url) {
        this.#target = new URL(url);
    }

    async start() {
        this.#server.listen(0, "127.0.0.1");
        await once(this.#server, "listening");
        this.url = `http://127.0.0.1:${this.#server.address().port}`;
        return this.url;
    }

    stop() {
        this.#server.close();
        for (const socket of this.#sockets) socket.destroy();
    }

    #pass(client) {
        const server = net.connect(Number(this.#target.port), this.#target.hostname);
        let left = Infinity;
        for (const [socket, other] of [[client, server], [server, client]]) {
            this.#sockets.add(socket);
            socket.on("error", () => other.destroy());
            socket.on("close", () => {
                other.destroy();
                this.#sockets.delete(socket);
            });
        }
        client.on("data", (bytes) => {
            if (this.cutLiveAfter !== undefined && /^GET \S+\/live\?/.test(bytes.toString("latin1"))) {
                left = this.cutLiveAfter;
                this.cutLiveAfter = undefined;
            }
            server.write(bytes);
        });
        server.on("data", (bytes) => {
            client.write(bytes.subarray(0, Math.min(left, bytes.length)));
            left -= bytes.length;
            if (left > 0) return;
            ++this.nCuts;
            client.end();
            server.destroy();
        });
    }
}

/** Drops files or folders of this machine on a point of a page, as a hand would. */
export async function dropFiles(page, { x, y }, paths) {
    const devtools = await page.context().newCDPSession(page);
    const data = { items: [], files: paths, dragOperationsMask: 1 };
    for (const type of ["dragEnter", "dragOver", "drop"]) await devtools.send("Input.dispatchDragEvent", { type, x, y, data });
}

/**
 * Headless, and looking for no other host. Without a graphics card WebGL is drawn in software by SwiftShader, the page
 * itself by Skia.
 */
export function startBrowser() {
    return chromium.launch({
        executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
        args: [
            "--no-sandbox",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--ignore-gpu-blocklist","--disable-gpu-rasterization",
        ],
    });
}
