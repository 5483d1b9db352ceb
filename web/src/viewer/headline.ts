import { prefixFor } from "../client/index.js";
import type { Model } from "../client/index.js";
import { h } from "./dom.js";
import { bytes, count } from "./format.js";

/** How many vertices are shown, and what they cost: the prefix that ends with the packet in which the last of them is. */
export class Headline {
    readonly element = h("p", { class: "headline" });
    private vertices: number | undefined;
    private bytes: number | undefined;

    update({ rows, framesBegin }: Model, nVertices: number): void {
        const { nBytes } = prefixFor({ vertices: nVertices }, rows, framesBegin);
        if (nVertices === this.vertices && nBytes === this.bytes) return;
        this.vertices = nVertices;
        this.bytes = nBytes;
        this.element.replaceChildren(h("strong", {}, count(nVertices)), ` vertices for ${bytes(nBytes)}`);
    }
}
