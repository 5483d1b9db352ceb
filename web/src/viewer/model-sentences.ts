// What a model's page says of the state that its model is in.
import type { ModelInfo } from "./api.js";
import { count, duration, significant } from "./format.js";
import { stateSentence } from "./stage-list.js";

export const deletedSentence = "This model was deleted. What was decoded stays until you leave the page.";
export const cancelledSentence = "This reconstruction was cancelled.";

/** In place of everything about a mesh while there is none. */
export function waitingSentence({ state, bytes }: ModelInfo): string {
    if (state === "queued") return "Other models come first. The page follows by itself: leave it open, or come back.";
    if (state === "running") return "A first shape appears a second or two after the photographs have been read, and refines from there.";
    return bytes > 0 ? "The first kilobytes are on their way." : "This model has no mesh.";
}

export function failedSentence(error: string | undefined): string {
    return `The reconstruction failed${error ? `: ${error}` : "."}`;
}

/** How far a reconstruction has come: "Refine 40 % · 2,300 vertices · Ψ 0.021 · about 40 s left". */
export function progressSentence(info: ModelInfo): string {
    const parts = [stateSentence(info)];
    if (info.vertices > 0) parts.push(`${count(info.vertices)} vertices`);
    if (info.distortion !== null) parts.push(`Ψ ${significant(info.distortion)}`);
    if (info.seconds_left != null) parts.push(`about ${duration(info.seconds_left)} left`);
    return parts.join(" · ");
}
