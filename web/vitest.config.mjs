// Tests of the client (tests/*.test.ts) and of the viewer in a browser (../tests/e2e/web): `vitest run --project NAME`.
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
        projects: [project("client", "web/tests/*.test.ts"), project("viewer", "tests/e2e/web/*_test.mjs")],
    },
});
