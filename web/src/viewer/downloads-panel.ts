import type { ModelInfo } from "./api.js";
import { h } from "./dom.js";
import { shortId } from "./format.js";
import { saveWithToken } from "./server-file.js";

const files = [
    { path: "mesh.ply", suffix: "ply", label: "PLY" },
    { path: "mesh.obj", suffix: "obj", label: "OBJ" },
    { path: "mesh.glb", suffix: "glb", label: "GLB" },
    { path: "log", suffix: "arl", label: "Log" },
] as const;

/** Links to what the server makes of a model at the budget that is shown. */
export class DownloadsPanel {
    readonly element: HTMLElement;
    private readonly links = h("div", { class: "downloads" });

    constructor() {
        this.element = h("section", { class: "panel", "aria-label": "Downloads" }, h("h2", {}, "Download at this budget"), this.links);
    }

    /** @param vertices of the mesh that is shown; undefined for all that the model has */
    update({ id, bytes }: ModelInfo, vertices: number | undefined): void {
        this.links.replaceChildren(...(bytes > 0 ? files.map((file) => link(id, file, vertices)) : []));
    }
}

function link(id: string, { path, suffix, label }: (typeof files)[number], vertices: number | undefined): HTMLElement {
    const query = vertices === undefined ? "" : `?vertices=${vertices}`;
    const name = `anyrate-${shortId(id)}-${vertices ?? "all"}.${suffix}`;
    const element = h("a", { class: "button", href: `/v1/models/${id}/${path}${query}`, download: name }, label);
    saveWithToken(element);
    return element;
}
