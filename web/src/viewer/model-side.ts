import type { Budget, Model } from "../client/index.js";
import type { ModelInfo } from "./api.js";
import { BudgetPanel } from "./budget-panel.js";
import { h } from "./dom.js";
import { DownloadsPanel } from "./downloads-panel.js";
import { shortId } from "./format.js";
import { Headline } from "./headline.js";
import { waitingSentence } from "./model-sentences.js";
import { RatePanel } from "./rate-panel.js";
import { ShareButton } from "./share-button.js";
import { stateSentence } from "./stage-list.js";
import { StatisticsPanel } from "./statistics-panel.js";

/** What stands beside a model: its name and state, its budget, what that costs, and what can be taken along. */
export class ModelSide {
    readonly element: HTMLElement;
    onBudget: (budget: Budget) => void = () => {};
    /** Is told when the page's address is about to be copied. */
    onShare: () => void = () => {};

    private readonly shareButton = new ShareButton();
    private readonly chip = h("span", { class: "chip" });
    private readonly headline = new Headline();
    /** In place of everything about a mesh while there is none. */
    private readonly waiting = h("p", { class: "waiting" });
    private readonly budgetPanel = new BudgetPanel();
    private readonly ratePanel = new RatePanel();
    private readonly statistics = new StatisticsPanel();
    private readonly downloads = new DownloadsPanel();

    constructor(id: string) {
        this.shareButton.onBeforeCopy = () => this.onShare();
        this.budgetPanel.onBudget = (budget) => this.onBudget(budget);
        this.ratePanel.onChoose = (vertices) => {
            this.budgetPanel.show({ vertices });
            this.onBudget({ vertices });
        };
        this.element = h(
            "aside",
            { class: "side" },
            h("div", { class: "title-line" }, h("h1", {}, shortId(id)), this.chip, this.shareButton.element),
            this.headline.element,
            this.waiting,
            this.budgetPanel.element,
            this.ratePanel.element,
            this.statistics.element,
            this.downloads.element,
        );
    }

    showState(info: ModelInfo): void {
        this.chip.textContent = stateSentence(info);
        this.chip.className = `chip ${info.state}`;
        this.waiting.textContent = waitingSentence(info);
    }

    /** Offers the budgets that a log has. @param budget the one that was asked for; undefined for all */
    showRows({ rows, framesBegin }: Model, budget: Budget | undefined): void {
        if (rows.length === 0) return;
        this.budgetPanel.setRows(rows, framesBegin);
        this.ratePanel.setRows(rows, framesBegin);
        this.budgetPanel.show(budget ?? { vertices: rows.at(-1)!.nVertices });
    }

    /** @param framesPerSecond undefined where nothing is drawn */
    showStatistics(model: Model | undefined, framesPerSecond: number | undefined): void {
        this.statistics.update(model, framesPerSecond);
        if (!model?.mesh) return;
        this.headline.update(model, model.mesh.nVertices);
        this.ratePanel.setCurrent(model.mesh.nVertices);
    }

    /** @param vertices of the mesh that is shown; undefined for all that the model has */
    showDownloads(info: ModelInfo, vertices: number | undefined): void {
        this.downloads.update(info, vertices);
    }
}
