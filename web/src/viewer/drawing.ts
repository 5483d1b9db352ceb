import { WebGLRenderer } from "three";

import { newMaterials } from "./shading.js";
import type { Materials } from "./shading.js";

/** A WebGL context with its compiled materials. */
export interface Drawing {
    readonly renderer: WebGLRenderer;
    readonly materials: Materials;
}

let idle: Drawing | undefined;

/**
 * A context for one view. It outlives the view and goes to the next one: to make a context and to compile its materials
 * takes longer than to fetch a model's first picture.
 * @throws Error if there is no WebGL
 */
export function acquireDrawing(): Drawing {
    const drawing = idle ?? {
        renderer: new WebGLRenderer({ antialias: true, alpha: true, powerPreference: "high-performance" }),
        materials: newMaterials(),
    };
    idle = undefined;
    return drawing;
}

export function releaseDrawing(drawing: Drawing): void {
    drawing.renderer.domElement.remove();
    if (idle) {
        drawing.materials.surface.dispose();
        drawing.materials.edges.dispose();
        drawing.renderer.dispose();
        drawing.renderer.forceContextLoss();
    } else {
        drawing.renderer.clear();
        idle = drawing;
    }
}
