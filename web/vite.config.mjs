// Builds the viewer into build/viewer, beside the program that serves it; each file also packed, since most of what a
// visitor waits for is these files.
import { readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, gzipSync } from "node:zlib";

import { defineConfig } from "vite";

const output = process.env.ANYRATE_VIEWER ?? fileURLToPath(new URL("../build/viewer", import.meta.url));

function packFiles() {
    return {
        name: "pack-files",
        apply: "build",
        closeBundle() {
            for (const name of readdirSync(output, { recursive: true })) {
                const file = join(output, name);
                if (!statSync(file).isFile() || !/\.(html|js|css|wasm|svg)$/.test(name)) continue;
                const bytes = readFileSync(file);
                writeFileSync(`${file}.br`, brotliCompressSync(bytes));
                writeFileSync(`${file}.gz`, gzipSync(bytes, { level: 9 }));
            }
        },
    };
}

export default defineConfig({
    root: fileURLToPath(new URL("src/viewer", import.meta.url)),
    base: "/",
    plugins: [packFiles()],
    worker: { format: "es" },
    build: {
        outDir: output,
        emptyOutDir: true,
        target: "es2022",
        assetsInlineLimit: 0, // the page's policy lets it load files, not data
        modulePreload: { polyfill: false },
        chunkSizeWarningLimit: 900,
    },
    server: { proxy: { "/v1": { target: process.env.ANYRATE_SERVER ?? "http://127.0.0.1:8080", ws: true } } },
});
