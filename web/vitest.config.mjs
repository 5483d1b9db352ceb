// Tests of the client and of parts of the viewer (tests), and of the viewer in a browser (../tests/e2e/web):
// vitest run --project unit|browser
import { fileURLToPath } from "node:url";

import { defineConfig } from "vitest/config";

const repository = fileURLToPath(new URL("../", import.meta.url));

/** Tests wait for other programs on machines that others use: only what hangs for ever is ended. */
const patience = 600_000; // ms

/**
 * Each file of tests runs in its own process, and its tests in the order they stand in. Vitest gives up a process that
 * did not come round to its messages for a minute: long tests let others have a turn in between.
 */
const project = (name, files) => ({
    root: repository,
    server: { fs: { allow: [repository] } },
    test: { name, include: [files], testTimeout: patience, hookTimeout: patience },
});

export default defineConfig({
    test: {
        reporters: ["verbose"],
        cache: false,
        projects: [project("unit", "web/tests/**/*.test.ts"), project("browser", "tests/e2e/web/*_test.mjs")],
    },
});
