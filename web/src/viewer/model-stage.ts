import type { Model } from "../client/index.js";
import type { Cameras, ModelInfo } from "./api.js";
import { cameraCentre, meanUp } from "./camera-view.js";
import type { Rectangle } from "./camera-view.js";
import { h } from "./dom.js";
import { HeatLegend } from "./heat-legend.js";
import { ModelView } from "./model-view.js";
import { Notice } from "./notice.js";
import { PhotoStrip } from "./photo-strip.js";
import { ProgressCard } from "./progress-card.js";
import { ShadingBar } from "./shading-bar.js";
import type { SharedState } from "./share-link.js";

/** A model as it is drawn, with what lies over it: messages, progress, shading and photographs. */
export class ModelStage {
    readonly element = h("div", { class: "stage" });
    readonly notice = new Notice();
    /** Is told when viewState has changed by hand. */
    onMoved: () => void = () => {};
    onCancel: () => void = () => {};

    private readonly shared: SharedState;
    private readonly progressCard = new ProgressCard();
    private readonly shadingBar: ShadingBar;
    private readonly legend = new HeatLegend();
    private readonly foot = h("div", { class: "foot" }, this.legend.element);
    private view: ModelView | undefined;
    private photos: PhotoStrip | undefined;
    private model: Model | undefined;

    /** @param shared the view to open with */
    constructor(shared: SharedState) {
        this.shared = shared;
        this.shadingBar = new ShadingBar(shared.shading ?? "colour", shared.edges ?? false);
        this.shadingBar.onShading = (shading) => {
            this.view?.setShading(shading);
            this.showLegend();
            this.onMoved();
        };
        this.shadingBar.onEdges = (shown) => {
            this.view?.setEdges(shown);
            this.onMoved();
        };
        this.shadingBar.onFit = () => this.view?.fit();
        this.progressCard.onCancel = () => this.onCancel();
        this.element.append(this.notice.element, this.progressCard.element, this.shadingBar.element, this.foot);
    }

    /** Undefined where nothing is drawn. */
    get framesPerSecond(): number | undefined {
        return this.view?.framesPerSecond;
    }

    /** What a link says of the view. */
    get viewState(): Omit<SharedState, "budget"> {
        const photograph = this.photos?.selected;
        return {
            ...(this.view && this.model?.mesh && { pose: this.view.pose }),
            ...(photograph !== undefined && { photograph }),
            shading: this.shadingBar.shading,
            edges: this.shadingBar.edges,
        };
    }

    /** Begins to draw; says so if this browser cannot. The stage is in its page by then. */
    openView(): void {
        try {
            this.view = new ModelView(this.element);
        } catch {
            this.notice.say("This browser shows no WebGL, so there is no picture. The downloads work without it.");
            return;
        }
        this.view.setShading(this.shadingBar.shading);
        this.view.setEdges(this.shadingBar.edges);
        this.view.onHeat = (step) => this.legend.show(step);
        this.leaveRoom();
        this.showLegend();
        this.view.onMoved = () => this.onMoved();
        this.view.onLeftPhotograph = () => {
            this.photos?.leave();
            this.onMoved();
        };
        if (this.shared.pose) this.view.setPose(this.shared.pose);
        if (this.model) this.view.setModel(this.model);
        this.begin();
    }

    /** Offers to look through the cameras of a model's photographs. */
    openPhotographs(cameras: Cameras): void {
        if (!this.view) return;
        this.view.setOrientation(meanUp(cameras.cameras), cameraCentre(cameras.cameras[0]));
        this.photos = new PhotoStrip(cameras, this.element, () => this.freePlace());
        this.photos.onEnter = (photograph, place) => {
            this.view?.enterPhotograph(photograph, place);
            this.onMoved();
        };
        this.photos.onPlace = (place) => this.view?.placePhotograph(place);
        this.photos.onLeave = () => this.view?.leavePhotograph();
        this.element.prepend(this.photos.picture);
        this.foot.append(this.photos.blendControl, this.photos.strip);
        this.leaveRoom();
        if (this.shared.photograph !== undefined) void this.photos.enter(this.shared.photograph);
    }

    /** Loads the small pictures of the photographs, once. */
    showPictures(): void {
        this.photos?.showPictures();
    }

    setModel(model: Model): void {
        this.model = model;
        this.view?.setModel(model);
    }

    /** The model has a mesh, or another one in place of what was there. */
    begin(): void {
        const mesh = this.model?.mesh;
        if (!mesh || !this.view) return;
        this.view.begin(mesh);
        this.view.take();
    }

    /** The model has changed. */
    take(): void {
        this.view?.take();
    }

    /** The next heat map is of what changes between these two. */
    beginStep(): void {
        this.view?.beginStep();
    }
    endStep(): void {
        this.view?.endStep();
    }

    showProgress(info: ModelInfo): void {
        const wasHidden = this.progressCard.element.hidden;
        this.progressCard.update(info);
        if (wasHidden !== this.progressCard.element.hidden) this.leaveRoom();
    }

    dispose(): void {
        this.photos?.dispose();
        this.view?.dispose();
    }

    /** Keeps the model clear of what lies over its stage: a card of stages that is as wide as a phone, too. */
    private leaveRoom(): void {
        const { top, height } = this.freePlace();
        this.view?.setCovered(top, this.element.clientHeight - top - height);
    }

    private freePlace(): Rectangle {
        const card = this.progressCard.element;
        const upper = !card.hidden && card.offsetWidth > 0.6 * this.element.offsetWidth ? card : this.shadingBar.element;
        const top = upper.offsetTop + upper.offsetHeight;
        const height = this.element.clientHeight - top - this.foot.offsetHeight;
        return { left: 0, top, width: this.element.clientWidth, height: Math.max(height, 1) };
    }

    private showLegend(): void {
        this.legend.element.hidden = this.shadingBar.shading !== "heat" || !this.view;
        this.photos?.place();
    }
}
