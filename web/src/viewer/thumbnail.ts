import { openModel } from "../client/index.js";
import { getCameras, modelUrl } from "./api.js";
import { cameraCentre, meanUp } from "./camera-view.js";
import { h } from "./dom.js";
import { draco } from "./draco.js";
import { ModelView } from "./model-view.js";
import { tokenOption } from "./token.js";

const size = { width: 320, height: 240 }; // CSS pixels

/**
 * Draws first pictures of models, one after the other, with one WebGL context. It does so in a corner of a canvas of the
 * size that the model's page will have, for to resize a canvas takes longer than to fetch a model's first picture.
 */
export class ThumbnailPainter {
    private readonly stage = h("div", { class: "stage" });
    private readonly rehearsal = h("div", { class: "model rehearsal", "aria-hidden": "true" }, this.stage, h("div", { class: "side" }));
    private turn: Promise<void> = Promise.resolve();
    private readonly stop = new AbortController();

    /** Draws a model, from its first kilobytes, into a canvas. */
    paint(id: string, canvas: HTMLCanvasElement): void {
        this.turn = this.turn.then(() => this.draw(id, canvas)).catch(() => {}); // the card stays without a picture
    }

    dispose(): void {
        this.stop.abort();
        this.rehearsal.remove();
    }

    private async draw(id: string, canvas: HTMLCanvasElement): Promise<void> {
        if (this.stop.signal.aborted) return;
        const coloured = { bytes: 0 }; // the base and its colours
        const model = await openModel(modelUrl(id), { ...tokenOption(), draco: draco(), budget: coloured, signal: this.stop.signal as never });
        document.body.append(this.rehearsal);
        const view = new ModelView(this.stage);
        try {
            const cameras = (await getCameras(id))?.cameras ?? [];
            if (cameras.length > 0) view.setOrientation(meanUp(cameras), cameraCentre(cameras[0]));
            view.setModel(model);
            if (!model.mesh) return;
            view.begin(model.mesh);
            const { left, top, width, height } = view.drawPicture(size);
            [canvas.width, canvas.height] = [width, height];
            canvas.getContext("2d")!.drawImage(view.canvas, left, top, width, height, 0, 0, width, height);
            canvas.classList.add("painted");
        } finally {
            view.dispose();
            model.dispose();
            this.rehearsal.remove();
        }
    }
}
