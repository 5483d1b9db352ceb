import { h } from "./dom.js";

/** Buttons side by side of which one is pressed. */
export class Segments<Value extends string> {
    readonly element: HTMLElement;
    onChoose: (value: Value) => void = () => {};
    private readonly buttons: ReadonlyMap<Value, HTMLButtonElement>;

    /**
     * @param choices each with its label
     * @param name    for those who do not see it; none if the labels say it
     */
    constructor(choices: readonly (readonly [Value, string])[], pressed: Value, name?: string) {
        this.buttons = new Map(choices.map(([value, label]) => [value, this.button(value, label)]));
        this.element = h("div", { class: "segments", role: name && "group", "aria-label": name }, ...this.buttons.values());
        this.press(pressed);
    }

    /** Shows a choice as the pressed one. */
    press(value: Value): void {
        for (const [other, button] of this.buttons) button.setAttribute("aria-pressed", String(other === value));
    }

    setEnabled(value: Value, enabled: boolean): void {
        this.buttons.get(value)!.disabled = !enabled;
    }

    private button(value: Value, label: string): HTMLButtonElement {
        const choose = () => {
            this.press(value);
            this.onChoose(value);
        };
        return h("button", { class: "segment", onclick: choose }, label);
    }
}
