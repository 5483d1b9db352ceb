// The built C++ program, for tests that compare with it: ANYRATE, or build/anyrate.
import { execFile } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";

import { test } from "vitest";

import { repository } from "./golden.js";

const program = process.env["ANYRATE"] ?? fileURLToPath(new URL("build/anyrate", repository));

/** Why tests that need the program are skipped; false if it is there. */
export const noProgram = existsSync(program) ? false : `no program at ${program}`;

/** Like `test`, but skipped if something is missing, with a note of what it is. */
export function testUnless(missing: string | false) {
    return (name: string, run: () => void | Promise<void>) =>
        test(name, async ({ skip }) => {
            if (missing !== false) skip(missing);
            await run();
        });
}

/** Runs `anyrate WORDS`, which must succeed, and gives what it printed. */
export async function anyrate(...words: string[]): Promise<string> {
    return (await promisify(execFile)(program, words, { encoding: "utf8", maxBuffer: Infinity })).stdout;
}

/** A folder that is gone when `use` is done. */
export async function inScratchFolder(use: (folder: string) => void | Promise<void>): Promise<void> {
    const folder = mkdtempSync(join(tmpdir(), "anyrate-web-"));
    try {
        await use(folder);
    } finally {
        rmSync(folder, { recursive: true });
    }
}
