import assert from "node:assert/strict";
import { fileURLToPath } from "node:url";
import { brotliCompressSync } from "node:zlib";

import { build } from "vite";
import { test } from "vitest";

import { repository } from "./golden.js";

const mostBytes = 25 * 1024;

/** All of the package in one minified module, without the packages it imports. */
async function bundled(entry: string): Promise<Uint8Array> {
    const result = await build({
        configFile: false,
        logLevel: "silent",
        build: {
            write: false,
            minify: true,
            target: "es2022",
            lib: { entry: fileURLToPath(new URL(entry, repository)), formats: ["es"] },
            rollupOptions: { external: /^draco3d/ },
        },
    });
    const { output } = (Array.isArray(result) ? result[0] : result) as { output: { code?: string }[] };
    return new TextEncoder().encode(output.map(({ code }) => code ?? "").join(""));
}

test("Client: the library takes at most 25 KB in Brotli, without draco3d", async () => {
    const library = await bundled("web/src/client/index.ts");
    const compressed = brotliCompressSync(library).length;
    assert.ok(compressed > 5000, `it is all there, got ${compressed} bytes`);
    assert.ok(compressed <= mostBytes, `expected at most ${mostBytes} bytes, got ${compressed}`);
});
