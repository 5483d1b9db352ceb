import { prefixFor } from "./budget.js";
import type { Budget } from "./budget.js";
import { DecodeError } from "./decode-error.js";
import type { DracoDecoder } from "./draco.js";
import { readLayout } from "./log-layout.js";
import type { LogLayout } from "./log-layout.js";
import { ModelDecoder } from "./model-decoder.js";
import type { ProgressiveMesh } from "./progressive-mesh.js";

/** A log that is there as a whole, or as much of it as there is. */
export interface DecodedLog {
    readonly mesh: ProgressiveMesh;
    /** layout.cut says whether and where the file was cut. */
    readonly layout: LogLayout;
}

/**
 * The mesh of a log at a budget: 0 to 2 vertices below a vertex budget that the log reaches. A file that was cut is
 * decoded to its last whole frame.
 * @param budget all of the log if left out
 * @throws DecodeError if the log is unsound, or cut before its base is whole
 */
export function decodeLog(log: Uint8Array, draco: DracoDecoder, budget?: Budget): DecodedLog {
    const layout = readLayout(log);
    const decoder = new ModelDecoder(draco);
    if (budget && "vertices" in budget) decoder.setMaxVertices(budget.vertices);
    const wanted = budget ? prefixFor(budget, layout.index, layout.framesBegin).nBytes : layout.wholeBytes;
    decoder.feed(log.subarray(0, Math.min(wanted, layout.wholeBytes)));
    if (!decoder.mesh) throw new DecodeError(`log: it has no base; ${layout.cut ?? "it ends before"}`);
    return { mesh: decoder.mesh, layout };
}
