import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";

import { test } from "vitest";

import { repository } from "./golden.js";

// That the client uses no DOM and no Node is for the compiler: src/client/tsconfig.json gives it neither.
test("Client: it imports its own files only, and Draco in one place", () => {
    const folder = new URL("web/src/client/", repository);
    const files = readdirSync(folder).filter((name) => name.endsWith(".ts"));
    assert.ok(files.length > 20);
    const foreign = files.flatMap((name) =>
        [...readFileSync(new URL(name, folder), "utf8").matchAll(/from "((?!\.\/)[^"]*)"/g)].map(
            (match) => `${name}: ${match[1]}`,
        ),
    );
    assert.deepEqual(foreign, ["draco3d-module.ts: draco3d/draco_decoder_nodejs.js"]);
});
