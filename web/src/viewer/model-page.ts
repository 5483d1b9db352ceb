import { DecodeError, followModel, openModel, prefixFor, ServerError } from "../client/index.js";
import type { Budget, Model, ModelEvent } from "../client/index.js";
import { cancelModel, getCameras, getModel, isFinal, knownModel, modelUrl, RequestError, watchModel } from "./api.js";
import type { ModelInfo } from "./api.js";
import { BudgetPanel } from "./budget-panel.js";
import { cameraCentre, meanUp } from "./camera-view.js";
import { h, icon, icons } from "./dom.js";
import { draco } from "./draco.js";
import { bytes, count, duration, hex32, milliseconds, shortId, significant } from "./format.js";
import { ModelView } from "./model-view.js";
import { goTo } from "./page.js";
import type { Page } from "./page.js";
import { PhotoStrip } from "./photo-strip.js";
import { RatePlot } from "./rate-plot.js";
import { formatShared, parseShared } from "./share-link.js";
import type { SharedState } from "./share-link.js";
import { saveWithToken } from "./server-file.js";
import type { Shading } from "./shading.js";
import { StageList, stateSentence } from "./stage-list.js";
import { tokenOption, wantsToken } from "./token.js";

export function modelPage(id: string, search: string): Page {
    const page = new ModelPage(id, parseShared(search));
    void page.open();
    return { element: page.element, title: `Model ${shortId(id)}`, dispose: () => page.dispose() };
}

const shadingNames: readonly (readonly [Shading, string])[] = [
    ["colour", "Colour"],
    ["plain", "Plain"],
    ["normals", "Normals"],
    ["heat", "Last step"],
];

const everything: Budget = { vertices: 2 ** 24 };
const settleMilliseconds = 90; // of a slider that is still being dragged

class ModelPage {
    readonly element: HTMLElement;
    private readonly id: string;
    private readonly shared: SharedState;
    private readonly stop = new AbortController();
    private readonly stage = h("div", { class: "stage" });
    private readonly notice = h("div", { class: "notice", role: "status", hidden: true });
    private readonly stages = new StageList();
    private readonly stageLine = h("div", { class: "stage-line", hidden: true });
    private readonly stageText = h("p", { class: "stage-text", "aria-live": "polite" });
    private readonly budgetPanel = new BudgetPanel();
    private readonly plot = new RatePlot();
    private readonly plotPanel = h("section", { class: "panel plot", "aria-label": "Rate and distortion", hidden: true });
    private readonly statistics: Record<string, HTMLElement> = {};
    private readonly downloads = h("div", { class: "downloads" });
    private readonly chip = h("span", { class: "chip" });
    private readonly headline = h("p", { class: "headline" });
    /** In place of everything about a mesh while there is none. */
    private readonly waiting = h("p", { class: "waiting" });
    private readonly foot = h("div", { class: "foot" });
    private readonly toolbar: HTMLElement;
    private readonly shareButton = h("button", { class: "button quiet", onclick: () => void this.share() }, icon(icons.link), "Copy link");

    private view: ModelView | undefined;
    private model: Model | undefined;
    private photos: PhotoStrip | undefined;
    private budget: Budget | undefined;
    /** Milliseconds that Draco had taken for other models. */
    private readonly dracoBefore = draco().milliseconds;
    private shading: Shading;
    private edges: boolean;
    private info: ModelInfo | undefined;
    private timer: ReturnType<typeof setTimeout> | undefined;
    private clock: ReturnType<typeof setInterval> | undefined;
    private stopWatching: () => void = () => {};

    constructor(id: string, shared: SharedState) {
        this.id = id;
        this.shared = shared;
        this.budget = shared.budget;
        this.shading = shared.shading ?? "colour";
        this.edges = shared.edges ?? false;
        const cancel = h("button", { class: "button quiet", onclick: () => void this.cancel() }, "Cancel");
        this.stageLine.append(this.stages.element, h("div", { class: "stage-foot" }, this.stageText, cancel));
        this.toolbar = this.newToolbar();
        this.stage.append(this.notice, this.stageLine, this.toolbar, this.foot);
        this.element = h("main", { class: "model empty" }, this.stage, this.side());
        this.budgetPanel.onBudget = (budget) => this.ask(budget);
        this.plot.onChoose = (vertices) => {
            const budget = { vertices };
            this.budgetPanel.show(budget);
            this.ask(budget);
        };
    }

    async open(): Promise<void> {
        this.clock = setInterval(() => this.showStatistics(), 250);
        try {
            this.showInfo(knownModel(this.id) ?? (await getModel(this.id)));
        } catch (error) {
            this.sayFailure(error);
            return;
        }
        const opened = this.openModel();
        await new Promise((resolve) => setTimeout(resolve)); // so that the request leaves before the view is made
        this.openView();
        await Promise.all([this.openPhotographs(), opened]);
        this.photos?.showPictures();
    }

    private openView(): void {
        if (this.stop.signal.aborted) return;
        try {
            this.view = new ModelView(this.stage);
        } catch {
            this.say("This browser shows no WebGL, so there is no picture. The downloads work without it.");
            return;
        }
        this.view.setShading(this.shading);
        this.view.setEdges(this.edges);
        this.leaveRoom();
        this.view.onMoved = () => this.remember();
        this.view.onLeftPhotograph = () => this.leavePhotograph();
        if (this.shared.pose) this.view.setPose(this.shared.pose);
        if (this.model) this.view.setModel(this.model);
        this.begin();
    }

    /** Keeps the model clear of what lies over its stage: a card of stages that is as wide as a phone, too. */
    private leaveRoom(): void {
        const card = this.stageLine;
        const upper = !card.hidden && card.offsetWidth > 0.6 * this.stage.offsetWidth ? card : this.toolbar;
        this.view?.setCovered(upper.offsetTop + upper.offsetHeight, this.foot.offsetHeight);
    }

    dispose(): void {
        this.stop.abort();
        this.stopWatching();
        clearInterval(this.clock);
        clearTimeout(this.timer);
        this.photos?.dispose();
        this.model?.dispose();
        this.view?.dispose();
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
                const wanted = this.budget ? { budget: this.budget } : { budget: everything, bytesWanted: info.bytes };
                await openModel(modelUrl(this.id), { ...options, ...wanted });
                this.refreshRows();
                this.settled();
            } else {
                this.stopWatching = watchModel(this.id, (now) => this.showInfo(now), () => this.say(deletedSentence));
                await followModel(modelUrl(this.id), options);
                if (this.budget) void this.model!.setBudget(this.budget);
            }
        } catch (error) {
            if (!this.stop.signal.aborted) this.sayFailure(error, () => void this.openModel());
        }
    }

    private attach(model: Model): void {
        this.model = model;
        this.view?.setModel(model);
    }

    private begin(): void {
        const mesh = this.model?.mesh;
        if (!mesh || !this.view) return;
        this.view.begin(mesh);
        this.view.take();
        if (!mesh.hasColours && this.shading === "colour") this.view.setShading("plain");
    }

    private take(event: ModelEvent): void {
        if (event.type === "mesh") {
            this.begin();
        } else if (event.type === "change") {
            if (this.model?.mesh?.hasColours) this.view?.setShading(this.shading);
            this.view?.take();
            if (!this.model?.isSealed) this.refreshRows();
        } else if (event.type === "error") {
            this.sayFailure(event.error);
        } else if (event.type === "live") {
            if (event.status.type === "lost") {
                this.say("The connection is lost. What has arrived stays; trying again…", "Try now", () => this.model?.retryNow());
            } else if (event.status.type === "open") {
                this.say("");
            } else if (event.status.type === "ended") {
                void this.liveEnded(event.status.state, event.status.error);
            }
        }
    }

    private async liveEnded(state: string, error: string | undefined): Promise<void> {
        if (state === "deleted") return this.say(deletedSentence);
        if (state === "failed") return this.say(failedSentence(error));
        this.say("");
        try {
            await this.model?.loadIndex(); // the distortions, which the live stream has not
            this.showInfo(await getModel(this.id));
            await this.model?.settled();
        } catch (failure) {
            if (!this.stop.signal.aborted) this.sayFailure(failure);
        }
        this.refreshRows();
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
        this.view?.beginStep();
        this.element.setAttribute("aria-busy", "true");
        try {
            await this.model.setBudget(budget);
            if (this.notice.dataset["kind"] === "connection") this.say("");
        } catch (error) {
            if (!this.stop.signal.aborted) this.sayFailure(error, () => void this.go(budget));
        }
        if (this.budget !== budget) return;
        this.view?.endStep();
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
        this.chip.textContent = stateSentence(info);
        this.chip.className = `chip ${info.state}`;
        const wasHidden = this.stageLine.hidden;
        this.stageLine.hidden = isFinal(info);
        if (wasHidden !== this.stageLine.hidden) this.leaveRoom();
        this.stages.update(info);
        this.stageText.textContent = stageSentence(info);
        this.waiting.textContent = waitingSentence(info);
        if (info.state === "failed") this.say(failedSentence(info.error));
        if (info.state === "cancelled") this.say("This reconstruction was cancelled.");
        this.showDownloads();
    }

    private refreshRows(): void {
        const model = this.model;
        if (!model || model.rows.length === 0) return;
        this.budgetPanel.setRows(model.rows, model.framesBegin);
        this.plot.setRows(model.rows, model.framesBegin);
        this.plotPanel.hidden = this.plot.isEmpty;
        if (!this.budget) this.budgetPanel.show({ vertices: model.rows.at(-1)!.nVertices });
        else this.budgetPanel.show(this.budget);
    }

    private showStatistics(): void {
        const model = this.model;
        const mesh = model?.mesh;
        const set = (name: string, text: string) => {
            if (this.statistics[name].textContent !== text) this.statistics[name].textContent = text;
        };
        set("fps", this.view ? String(Math.round(this.view.framesPerSecond)) : "–");
        if (!model || !mesh) return;
        set("vertices", count(mesh.nVertices));
        set("faces", count(mesh.nFaces));
        set("received", bytes(model.nBytes));
        set("frames", count(model.nFrames));
        set("decode", milliseconds(draco().milliseconds - this.dracoBefore));
        set("replay", milliseconds(model.replayMilliseconds));
        set("hash", hex32(mesh.stateHash));
        this.showHeadline(model, mesh.nVertices);
        this.element.dataset["vertices"] = String(mesh.nVertices);
        this.element.dataset["hash"] = hex32(mesh.stateHash);
        this.element.dataset["bytes"] = String(model.nBytes);
        this.element.dataset["requests"] = String(model.nRequests);
    }

    /** What is shown, and what it costs: the prefix that ends with the packet in which these vertices are. */
    private showHeadline(model: Model, nVertices: number): void {
        const { nBytes } = prefixFor({ vertices: nVertices }, model.rows, model.framesBegin);
        const said = `${nVertices} ${nBytes}`;
        if (this.headline.dataset["said"] === said) return;
        this.headline.dataset["said"] = said;
        this.headline.replaceChildren(h("strong", {}, count(nVertices)), ` vertices for ${bytes(nBytes)}`);
        this.plot.setCurrent(nVertices);
        this.element.classList.remove("empty");
    }

    private showDownloads(): void {
        const vertices = this.model?.mesh?.nVertices;
        const formats = [["mesh.ply", "PLY"], ["mesh.obj", "OBJ"], ["mesh.glb", "GLB"], ["log", "Log"]] as const;
        const links = formats.map(([path, label]) => {
            const query = vertices === undefined ? "" : `?vertices=${vertices}`;
            const suffix = path === "log" ? "arl" : path.slice(5);
            const name = `anyrate-${shortId(this.id)}-${vertices ?? "all"}.${suffix}`;
            const link = h("a", { class: "button", href: `/v1/models/${this.id}/${path}${query}`, download: name }, label);
            saveWithToken(link);
            return link;
        });
        this.downloads.replaceChildren(...(this.info && this.info.bytes > 0 ? links : []));
    }

    /** A sentence over the stage, or none. */
    private say(sentence: string, action?: string, act?: () => void, kind = ""): void {
        this.notice.hidden = sentence === "";
        this.notice.dataset["kind"] = kind;
        this.notice.replaceChildren(sentence);
        if (action && act) this.notice.append(" ", h("button", { class: "button quiet", onclick: act }, action));
    }

    private sayFailure(error: unknown, again?: () => void): void {
        if (error instanceof DecodeError) {
            this.say(`The stream is damaged: ${error.message}. What was decoded before stays.`);
        } else if (error instanceof RequestError || error instanceof ServerError) {
            if (error instanceof ServerError) wantsToken(error.status);
            if (error.status === 404 && !this.info) this.say("There is no such model. It may have been deleted.", "All models", () => goTo("/"));
            else this.say(error.message);
        } else if (error instanceof TypeError) {
            this.say("The connection is lost. What has arrived stays.", again && "Try again", again, "connection");
        } else {
            this.say(String(error));
        }
    }

    // --- the photographs

    private async openPhotographs(): Promise<void> {
        const cameras = await getCameras(this.id).catch(() => undefined); // the model is there without them
        if (!cameras || cameras.cameras.length === 0 || this.stop.signal.aborted || !this.view) return;
        this.view.setOrientation(meanUp(cameras.cameras), cameraCentre(cameras.cameras[0]));
        this.photos = new PhotoStrip(cameras, this.stage);
        this.photos.onEnter = (photograph) => {
            this.view?.enterPhotograph(photograph);
            this.remember();
        };
        this.photos.onLeave = () => this.view?.leavePhotograph();
        this.stage.prepend(this.photos.picture);
        this.foot.append(this.photos.blendControl, this.photos.strip);
        this.leaveRoom();
        if (this.shared.photograph !== undefined) void this.photos.enter(this.shared.photograph);
    }

    private leavePhotograph(): void {
        this.photos?.leave();
        this.remember();
    }

    // --- the link

    private get state(): SharedState {
        const photograph = this.photos?.selected;
        return {
            ...(this.budget && { budget: this.budget }),
            ...(this.view && this.model?.mesh && { pose: this.view.pose }),
            ...(photograph !== undefined && { photograph }),
            shading: this.shading,
            edges: this.edges,
        };
    }

    /** Keeps the address up to date, so that it opens the same view. */
    private remember(): void {
        if (this.stop.signal.aborted) return;
        const query = formatShared(this.state);
        history.replaceState(null, "", location.pathname + (query ? `?${query}` : ""));
    }

    private async share(): Promise<void> {
        this.budget ??= this.model?.mesh && { vertices: this.model.mesh.nVertices };
        this.remember();
        await navigator.clipboard?.writeText(location.href).catch(() => {}); // the address bar has it, too
        this.shareButton.replaceChildren(icon(icons.link), "Copied");
        setTimeout(() => this.shareButton.replaceChildren(icon(icons.link), "Copy link"), 1600);
    }

    // --- the furniture

    private newToolbar(): HTMLElement {
        const buttons = shadingNames.map(([shading, label]) =>
            h("button", { class: "segment", "aria-pressed": String(shading === this.shading), onclick: () => choose(shading) }, label),
        );
        const choose = (shading: Shading) => {
            this.shading = shading;
            this.view?.setShading(shading);
            shadingNames.forEach(([name], i) => buttons[i].setAttribute("aria-pressed", String(name === shading)));
            this.remember();
        };
        const edges = h("button", { class: "segment", "aria-pressed": String(this.edges), onclick: () => {
            this.edges = !this.edges;
            edges.setAttribute("aria-pressed", String(this.edges));
            this.view?.setEdges(this.edges);
            this.remember();
        } }, "Edges");
        return h(
            "div",
            { class: "toolbar" },
            h("div", { class: "segments", role: "group", "aria-label": "Shading" }, ...buttons),
            h("div", { class: "segments" }, edges),
            h("button", { class: "icon-button", title: "Fit (F)", "aria-label": "Fit the model", onclick: () => this.view?.fit() }, icon(icons.fit)),
        );
    }

    private side(): HTMLElement {
        const axes = (["vertices", "bytes"] as const).map((axis) =>
            h("button", { class: "segment", "aria-pressed": String(axis === "vertices"), onclick: () => {
                this.plot.setAxis(axis);
                axes.forEach((button) => button.setAttribute("aria-pressed", String(button.textContent === label(axis))));
            } }, label(axis)),
        );
        this.plotPanel.append(
            h("div", { class: "panel-head" }, h("h2", {}, "Distortion Ψ by"), h("div", { class: "segments small" }, ...axes)),
            this.plot.element,
            h("p", { class: "hint" }, "How far the photographs disagree where they see the same surface; lower is better. Click to go there."),
        );
        return h(
            "aside",
            { class: "side" },
            h("div", { class: "title-line" }, h("h1", {}, shortId(this.id)), this.chip, this.shareButton),
            this.headline,
            this.waiting,
            this.budgetPanel.element,
            this.plotPanel,
            this.statisticsPanel(),
            h("section", { class: "panel", "aria-label": "Downloads" }, h("h2", {}, "Download at this budget"), this.downloads),
        );
    }

    private statisticsPanel(): HTMLElement {
        const names = [
            ["vertices", "Vertices"],
            ["faces", "Faces"],
            ["received", "Received"],
            ["frames", "Log frames"],
            ["decode", "Decoding"],
            ["replay", "Replay"],
            ["fps", "Drawn / s"],
            ["hash", "State hash"],
        ] as const;
        const items = names.map(([name, text]) => {
            this.statistics[name] = h("dd", { "data-statistic": name }, "–");
            return h("div", {}, h("dt", {}, text), this.statistics[name]);
        });
        return h("section", { class: "panel", "aria-label": "Statistics" }, h("dl", { class: "statistics" }, ...items));
    }
}

const deletedSentence = "This model was deleted. What was decoded stays until you leave the page.";

function waitingSentence({ state, bytes: nBytes }: ModelInfo): string {
    if (state === "queued") return "Other models come first. The page follows by itself: leave it open, or come back.";
    if (state === "running") return "A first shape appears a second or two after the photographs have been read, and refines from there.";
    return nBytes > 0 ? "The first kilobytes are on their way." : "This model has no mesh.";
}

function failedSentence(error: string | undefined): string {
    return `The reconstruction failed${error ? `: ${error}` : "."}`;
}

function stageSentence(info: ModelInfo): string {
    const parts = [stateSentence(info)];
    if (info.vertices > 0) parts.push(`${count(info.vertices)} vertices`);
    if (info.distortion !== null) parts.push(`Ψ ${significant(info.distortion)}`);
    if (info.seconds_left != null) parts.push(`about ${duration(info.seconds_left)} left`);
    return parts.join(" · ");
}

function label(axis: "vertices" | "bytes"): string {
    return axis === "vertices" ? "Vertices" : "Bytes";
}
