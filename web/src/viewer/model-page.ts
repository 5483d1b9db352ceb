import { followModel, openModel, ServerError } from "../client/index.js";
import type { Budget, LiveStatus, Model, ModelEvent } from "../client/index.js";
import { cancelModel, getCameras, getModel, hasThumbnails, isFinal, knownModel, modelUrl, watchModel } from "./api.js";
import type { ModelInfo } from "./api.js";
import { h } from "./dom.js";
import { draco } from "./draco.js";
import { failureMessage } from "./failure-message.js";
import { hex32, shortId } from "./format.js";
import { cancelledSentence, deletedSentence, failedSentence } from "./model-sentences.js";
import { ModelSide } from "./model-side.js";
import { ModelStage } from "./model-stage.js";
import type { Page } from "./page.js";
import { formatShared, parseShared } from "./share-link.js";
import type { SharedState } from "./share-link.js";
import { tokenOption, wantsToken } from "./token.js";

export function modelPage(id: string, search: string): Page {
    const page = new ModelPage(id, parseShared(search));
    void page.open();
    return { element: page.element, title: `Model ${shortId(id)}`, dispose: () => page.dispose() };
}

const everything: Budget = { vertices: 2 ** 24 };
const settleMilliseconds = 90; // of a slider that is still being dragged
const statisticsMilliseconds = 250;

/** A model's page: what follows what, from its address to the mesh at the budget that is asked for. */
class ModelPage {
    readonly element: HTMLElement;
    private readonly id: string;
    private readonly stop = new AbortController();
    private readonly stage: ModelStage;
    private readonly side: ModelSide;
    private model: Model | undefined;
    private budget: Budget | undefined;
    private info: ModelInfo | undefined;
    private isOpened = false;
    private timer: ReturnType<typeof setTimeout> | undefined;
    private clock: ReturnType<typeof setInterval> | undefined;
    private stopWatching: () => void = () => {};

    constructor(id: string, shared: SharedState) {
        this.id = id;
        this.budget = shared.budget;
        this.stage = new ModelStage(shared);
        this.side = new ModelSide(id);
        this.element = h("main", { class: "model empty" }, this.stage.element, this.side.element);
        this.stage.onMoved = () => this.remember();
        this.stage.onCancel = () => void this.cancel();
        this.side.onBudget = (budget) => this.ask(budget);
        this.side.onShare = () => this.share();
    }

    async open(): Promise<void> {
        this.clock = setInterval(() => this.showStatistics(), statisticsMilliseconds);
        try {
            this.showInfo(knownModel(this.id) ?? (await getModel(this.id)));
        } catch (error) {
            this.sayFailure(error);
            return;
        }
        const opened = this.openModel();
        await new Promise((resolve) => setTimeout(resolve)); // so that the request leaves before the view is made
        if (!this.stop.signal.aborted) this.stage.openView();
        await Promise.all([this.openPhotographs(), opened]);
        this.isOpened = true;
        this.showPictures();
    }

    dispose(): void {
        this.stop.abort();
        this.stopWatching();
        clearInterval(this.clock);
        clearTimeout(this.timer);
        this.model?.dispose();
        this.stage.dispose();
    }

    // --- the model

    private async openModel(): Promise<void> {
        const info = this.info!;
        const options = {
            ...tokenOption(),
            draco: draco(),
            signal: this.stop.signal as never,
            onEvent: (event: ModelEvent) => this.take(event),
            onModel: (model: Model) => this.attach(model),
        };
        try {
            if (isFinal(info)) {
                if (info.bytes === 0) return;
                this.element.setAttribute("aria-busy", "true");
                const wanted = this.budget ? { budget: this.budget } : { budget: everything, bytesWanted: info.bytes };
                await openModel(modelUrl(this.id), { ...options, ...wanted });
                if (!this.model?.isSealed) this.showRows();
                this.settled();
            } else {
                this.stopWatching = watchModel(this.id, (now) => this.showInfo(now), () => this.stage.notice.say(deletedSentence));
                await followModel(modelUrl(this.id), options);
                if (this.budget) void this.model!.setBudget(this.budget);
            }
        } catch (error) {
            this.sayFailure(error, () => void this.openModel());
        }
    }

    /** They wait for the model itself, and until they are there. */
    private showPictures(): void {
        if (this.isOpened && hasThumbnails(this.info!)) this.stage.showPictures();
    }

    private async openPhotographs(): Promise<void> {
        const cameras = await getCameras(this.id).catch(() => undefined); // the model is there without them
        if (!cameras || cameras.cameras.length === 0 || this.stop.signal.aborted) return;
        this.stage.openPhotographs(cameras);
        if (this.model?.mesh) this.remember(); // an untouched view makes room for them
    }

    private attach(model: Model): void {
        this.model = model;
        this.stage.setModel(model);
    }

    private take(event: ModelEvent): void {
        if (event.type === "mesh") {
            this.stage.begin();
            this.showRows(); // a sealed log has all of them in front of its base
            this.showStatistics();
        } else if (event.type === "change") {
            this.stage.take();
            if (!this.model?.isSealed) this.showRows();
        } else if (event.type === "error") {
            this.sayFailure(event.error);
        } else if (event.type === "live") {
            this.followLive(event.status);
        }
    }

    private followLive(status: LiveStatus): void {
        const { notice } = this.stage;
        if (status.type === "lost") {
            const retry = { label: "Try now", run: () => this.model?.retryNow() };
            notice.show({ sentence: "The connection is lost. What has arrived stays; trying again…", action: retry });
        } else if (status.type === "open") {
            notice.clear();
        } else if (status.type === "ended") {
            if (status.state === "deleted") notice.say(deletedSentence);
            else if (status.state === "failed") notice.say(failedSentence(status.error));
            else void this.liveEnded();
        }
    }

    private async liveEnded(): Promise<void> {
        this.stage.notice.clear();
        try {
            await this.model?.loadIndex(); // the distortions, which the live stream has not
            this.showInfo(await getModel(this.id));
            await this.model?.settled();
        } catch (failure) {
            this.sayFailure(failure);
        }
        this.showRows();
        this.settled();
    }

    /** Asks for a budget a moment later, so that a slider may be dragged. */
    private ask(budget: Budget): void {
        this.budget = budget;
        clearTimeout(this.timer);
        this.timer = setTimeout(() => void this.go(budget), settleMilliseconds);
    }

    private async go(budget: Budget): Promise<void> {
        if (!this.model) return;
        this.stage.beginStep();
        this.element.setAttribute("aria-busy", "true");
        try {
            await this.model.setBudget(budget);
            this.stage.notice.clearConnection();
        } catch (error) {
            this.sayFailure(error, () => void this.go(budget));
        }
        if (this.budget !== budget) return;
        this.stage.endStep();
        this.settled();
    }

    private settled(): void {
        this.element.removeAttribute("aria-busy");
        this.showStatistics();
        this.showDownloads();
        this.remember();
    }

    private async cancel(): Promise<void> {
        try {
            await cancelModel(this.id);
        } catch (error) {
            this.sayFailure(error);
        }
    }

    // --- what the page says

    private showInfo(info: ModelInfo): void {
        this.info = info;
        this.stage.showProgress(info);
        this.side.showState(info);
        this.showPictures();
        if (info.state === "failed") this.stage.notice.say(failedSentence(info.error));
        if (info.state === "cancelled") this.stage.notice.say(cancelledSentence);
        this.showDownloads();
    }

    private showRows(): void {
        if (this.model) this.side.showRows(this.model, this.budget);
    }

    private showStatistics(): void {
        const { model } = this;
        this.side.showStatistics(model, this.stage.framesPerSecond);
        if (!model?.mesh) return;
        this.element.classList.remove("empty");
        // For whoever tests or measures.
        const { dataset } = this.element;
        dataset["vertices"] = String(model.mesh.nVertices);
        dataset["hash"] = hex32(model.mesh.stateHash);
        dataset["bytes"] = String(model.nBytes);
        dataset["requests"] = String(model.nRequests);
    }

    private showDownloads(): void {
        if (this.info) this.side.showDownloads(this.info, this.model?.mesh?.nVertices);
    }

    /** @param again tries once more, where a visitor may ask for that */
    private sayFailure(error: unknown, again?: () => void): void {
        if (this.stop.signal.aborted) return;
        this.element.removeAttribute("aria-busy");
        if (error instanceof ServerError) wantsToken(error.status);
        this.stage.notice.show(failureMessage(error, this.info !== undefined, again));
    }

    /** What is shown goes into the address, though nobody asked for just that budget. */
    private share(): void {
        this.budget ??= this.model?.mesh && { vertices: this.model.mesh.nVertices };
        this.remember();
    }

    /** Keeps the address up to date, so that it opens the same view. */
    private remember(): void {
        if (this.stop.signal.aborted) return;
        const query = formatShared({ ...(this.budget && { budget: this.budget }), ...this.stage.viewState });
        history.replaceState(null, "", location.pathname + (query ? `?${query}` : ""));
    }
}
