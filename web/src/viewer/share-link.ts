// What an address says beside the model: the budget and the view that it opens with.
import type { Budget } from "../client/index.js";
import type { Pose } from "./orbit-camera.js";
import { shadings } from "./shading.js";
import type { Shading } from "./shading.js";

export interface SharedState {
    readonly budget?: Budget;
    readonly pose?: Pose;
    readonly shading?: Shading;
    readonly edges?: boolean;
    /** Place in the list of cameras. */
    readonly photograph?: number;
}

/** The query of a link, without its question mark. */
export function formatShared({ budget, pose, shading, edges, photograph }: SharedState): string {
    const query = new URLSearchParams();
    if (budget) for (const [name, value] of Object.entries(budget)) query.set(name, String(value));
    if (photograph !== undefined) query.set("photograph", String(photograph));
    else if (pose) query.set("view", pose.map((x) => Number(x.toPrecision(6))).join("_"));
    if (shading && shading !== "colour") query.set("shading", shading);
    if (edges) query.set("edges", "1");
    return query.toString();
}

/** What a link says; what it says wrongly is left out. */
export function parseShared(search: string): SharedState {
    const query = new URLSearchParams(search);
    const budget = budgetOf(query);
    const pose = poseOf(query.get("view"));
    const shading = shadings.find((name) => name === query.get("shading"));
    const photograph = wholeNumber(query.get("photograph"));
    return {
        ...(budget && { budget }),
        ...(pose && { pose }),
        ...(shading && { shading }),
        ...(query.get("edges") === "1" && { edges: true }),
        ...(photograph !== undefined && { photograph }),
    };
}

function budgetOf(query: URLSearchParams): Budget | undefined {
    const vertices = wholeNumber(query.get("vertices"));
    if (vertices) return { vertices };
    const bytes = wholeNumber(query.get("bytes"));
    if (bytes) return { bytes };
    const text = query.get("distortion");
    const distortion = Number(text);
    return text && Number.isFinite(distortion) && distortion >= 0 ? { distortion } : undefined;
}

function poseOf(text: string | null): Pose | undefined {
    const numbers = (text ?? "").split("_").map(Number);
    return text && numbers.length === 6 && numbers.every(Number.isFinite) ? (numbers as never as Pose) : undefined;
}

function wholeNumber(text: string | null): number | undefined {
    return text !== null && /^\d{1,10}$/.test(text) ? Number(text) : undefined;
}
