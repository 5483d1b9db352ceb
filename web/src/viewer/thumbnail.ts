import { openModel } from "../client/index.js";
import { getCameras, modelUrl } from "./api.js";
import { cameraCentre, meanUp } from "./camera-view.js";
import { draco } from "./draco.js";
import { ModelView } from "./model-view.js";

/** Draws first pictures of models, one after the other, with one WebGL context. */
export class ThumbnailPainter {
    private readonly stage = document.createElement("div");
    private turn: Promise<void> = Promise.resolve();
    private readonly stop = new AbortController();

    constructor() {
        this.stage.className = "thumbnail-stage";
    }

    /** Draws a model, from its first kilobytes, into a canvas. */
    paint(id: string, canvas: HTMLCanvasElement): void {
        this.turn = this.turn.then(() => this.draw(id, canvas)).catch(() => {}); // the card stays without a picture
    }

    dispose(): void {
        this.stop.abort();
        this.stage.remove();
    }

    private async draw(id: string, canvas: HTMLCanvasElement): Promise<void> {
        if (this.stop.signal.aborted) return;
        const model = await openModel(modelUrl(id), { draco: draco(), signal: this.stop.signal as never });
        document.body.append(this.stage);
        const view = new ModelView(this.stage);
        try {
            const cameras = (await getCameras(id))?.cameras ?? [];
            if (cameras.length > 0) view.setOrientation(meanUp(cameras), cameraCentre(cameras[0]));
            view.setModel(model);
            if (!model.mesh) return;
            if (!model.mesh.hasColours) view.setShading("plain");
            view.begin(model.mesh);
            view.take();
            view.drawNow();
            canvas.width = view.canvas.width;
            canvas.height = view.canvas.height;
            canvas.getContext("2d")!.drawImage(view.canvas, 0, 0);
            canvas.classList.add("painted");
        } finally {
            view.dispose();
            model.dispose();
            this.stage.remove();
        }
    }
}
