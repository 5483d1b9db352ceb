import type { IndexRow } from "./log-index.js";

/** How much of a model somebody wants. */
export type Budget =
    | { readonly vertices: number }
    /** Of the whole prefix, header and index included. */
    | { readonly bytes: number }
    /** Mean distortion, at most, if the log gets there. */
    | { readonly distortion: number };

/** A beginning of a log that ends at a frame. */
export interface Prefix {
    /** Index rows (frames) in it. */
    readonly nRows: number;
    /** Its bytes, counted from the start of the file. */
    readonly nBytes: number;
}

/**
 * The prefix that answers a budget (proto/FORMAT.md, "Budgets"); it always holds the base and its colours.
 * For a budget of vertices it ends at the packet in which that count is reached: replay stops inside.
 * @param rows        in file order, as decodeIndexRows() gives them
 * @param framesBegin offset of the base frame in the file
 */
export function prefixFor(budget: Budget, rows: readonly IndexRow[], framesBegin: number): Prefix {
    if (rows.length === 0) return { nRows: 0, nBytes: framesBegin };
    const nRows = Math.max(withColours(rows, 1), rowsWithin(budget, rows, framesBegin));
    return { nRows, nBytes: framesBegin + rows[nRows - 1].end };
}

function rowsWithin(budget: Budget, rows: readonly IndexRow[], framesBegin: number): number {
    if ("vertices" in budget) return rowsUpTo(rows, (row) => row.nVertices >= budget.vertices - 2);
    if ("distortion" in budget) return rowsUpTo(rows, (row) => row.meanDistortion <= budget.distortion);
    const beyond = rows.findIndex((row) => framesBegin + row.end > budget.bytes);
    return beyond < 0 ? rows.length : beyond;
}

/** Rows up to the first that is good enough, with its colours; all rows if none is. */
function rowsUpTo(rows: readonly IndexRow[], isEnough: (row: IndexRow) => boolean): number {
    const found = rows.findIndex(isEnough);
    return found < 0 ? rows.length : withColours(rows, found + 1);
}

/** So many rows, and those behind them that add no vertex: the colours of the last one. */
function withColours(rows: readonly IndexRow[], nRows: number): number {
    while (nRows < rows.length && rows[nRows].nVertices === rows[nRows - 1].nVertices) ++nRows;
    return nRows;
}
