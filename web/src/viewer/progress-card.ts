import { isFinal } from "./api.js";
import type { ModelInfo } from "./api.js";
import { h } from "./dom.js";
import { progressSentence } from "./model-sentences.js";
import { StageList } from "./stage-list.js";

/** How far a reconstruction has come, with the way to cancel it; hidden once it is over. */
export class ProgressCard {
    readonly element = h("div", { class: "stage-line", hidden: true });
    onCancel: () => void = () => {};
    private readonly stages = new StageList();
    private readonly text = h("p", { class: "stage-text", "aria-live": "polite" });

    constructor() {
        const cancel = h("button", { class: "button quiet", onclick: () => this.onCancel() }, "Cancel");
        this.element.append(this.stages.element, h("div", { class: "stage-foot" }, this.text, cancel));
    }

    update(info: ModelInfo): void {
        this.element.hidden = isFinal(info);
        this.stages.update(info);
        this.text.textContent = progressSentence(info);
    }
}
