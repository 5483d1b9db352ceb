// The built C++ program, for tests that compare with it: ANYRATE, or build/anyrate.
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { repository } from "./golden.js";

const program = process.env["ANYRATE"] ?? fileURLToPath(new URL("build/anyrate", repository));

/** Why tests that need the program are skipped; false if it is there. */
export const noProgram = existsSync(program) ? false : `no program at ${program}`;

/** Runs `anyrate WORDS`, which must succeed, and gives what it printed. */
export function anyrate(...words: string[]): string {
    return execFileSync(program, words, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
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
