// The steps of a budget slider. Each kind of budget runs from the base to the whole log; the slider has a logarithmic
// scale, so that a step is a share and not a number.
import type { Budget, IndexRow } from "../client/index.js";

export type BudgetKind = "vertices" | "bytes" | "distortion";

/** From the coarsest to the finest mesh; distortion falls. */
export interface BudgetScale {
    readonly kind: BudgetKind;
    readonly coarsest: number;
    readonly finest: number;
}

export const sliderSteps = 1000;

/** @returns undefined if the rows do not know this kind */
export function budgetScale(kind: BudgetKind, rows: readonly IndexRow[], framesBegin: number): BudgetScale | undefined {
    const first = rows.find((row) => row.nVertices > 0);
    const last = rows.at(-1);
    if (!first || !last) return undefined;
    if (kind === "vertices") return { kind, coarsest: first.nVertices, finest: last.nVertices };
    if (kind === "bytes") return { kind, coarsest: framesBegin + first.end, finest: framesBegin + last.end };
    const known = rows.map(({ meanDistortion }) => meanDistortion).filter((d) => d > 0);
    if (known.length < 2) return undefined;
    return { kind, coarsest: known[0], finest: Math.min(...known) };
}

/** @param step 0 to sliderSteps */
export function valueAt({ kind, coarsest, finest }: BudgetScale, step: number): number {
    const value = coarsest * (finest / coarsest) ** (step / sliderSteps);
    if (step <= 0) return coarsest;
    if (step >= sliderSteps) return finest;
    return kind === "distortion" ? Number(value.toPrecision(4)) : Math.round(value);
}

export function stepOf({ coarsest, finest }: BudgetScale, value: number): number {
    if (coarsest === finest) return sliderSteps;
    const step = (sliderSteps * Math.log(value / coarsest)) / Math.log(finest / coarsest);
    return Math.min(Math.max(Math.round(step), 0), sliderSteps);
}

/**
 * One vertex more or less; for bytes and distortion, which change from frame to frame, that of the next frame.
 * @param direction 1 towards the finest, -1 towards the coarsest
 */
export function nextValue(
    { kind, coarsest, finest }: BudgetScale,
    rows: readonly IndexRow[],
    framesBegin: number,
    value: number,
    direction: number,
): number {
    if (kind === "vertices") return Math.min(Math.max(value + direction, coarsest), finest);
    const towards = kind === "bytes" ? direction : -direction;
    const amounts = rows.map(({ end, meanDistortion }) => (kind === "bytes" ? framesBegin + end : meanDistortion));
    const beyond = amounts.filter((amount) => amount > 0 && (towards > 0 ? amount > value : amount < value));
    if (beyond.length === 0) return direction > 0 ? finest : coarsest;
    return towards > 0 ? Math.min(...beyond) : Math.max(...beyond);
}

export function budgetOf(kind: BudgetKind, value: number): Budget {
    return { [kind]: value } as unknown as Budget;
}

export function kindOf(budget: Budget): BudgetKind {
    return Object.keys(budget)[0] as BudgetKind;
}

export function amountOf(budget: Budget): number {
    return Object.values(budget)[0] as number;
}
