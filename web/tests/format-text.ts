import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

import { repository } from "./golden.js";

/** The lines of the code block of FORMAT.md behind a sentence, as numbers: "0 (81 566 566)" gives 81, 566 and 566. */
export function triplesOfFormat(sentence: string): number[][] {
    const text = readFileSync(new URL("proto/FORMAT.md", repository), "utf8");
    const [, behind] = text.split(sentence);
    assert.ok(behind !== undefined, `FORMAT.md has the sentence "${sentence}"`);
    const block = behind.split("```")[1];
    return [...block.matchAll(/\((-?\d+) (-?\d+) (-?\d+)\)/g)].map((match) => match.slice(1).map(Number));
}
