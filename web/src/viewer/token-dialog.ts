import { h } from "./dom.js";
import { setToken } from "./token.js";

/** Asks for a token in front of the page, once at a time. */
export class TokenDialog {
    private readonly sentence = h("p", { id: "token-sentence" });
    private readonly field = h("input", {
        type: "password",
        name: "token",
        autocomplete: "off",
        required: true,
        pattern: "[A-Za-z0-9_.~+\\-]+",
        title: "letters, digits, - and _",
        "aria-label": "Token",
        "aria-describedby": "token-sentence",
    });
    private readonly dialog: HTMLDialogElement;

    /** @param onToken is told that there is another token */
    constructor(onToken: () => void) {
        const form = h(
            "form",
            { method: "dialog", onsubmit: (event) => {
                event.preventDefault(); // the token must not get into an address
                setToken(this.field.value.trim());
                this.dialog.close();
                onToken();
            } },
            h("h2", {}, "A token, please"),
            this.sentence,
            h("div", { class: "row" }, this.field, h("button", { class: "button primary", type: "submit" }, "Continue")),
            h("p", { class: "muted" }, "It stays in this tab and goes to this server only."),
        );
        this.dialog = h("dialog", { class: "token-dialog", "aria-labelledby": "token-sentence" }, form);
        document.body.append(this.dialog);
    }

    ask(sentence: string): void {
        this.sentence.textContent = sentence;
        if (this.dialog.open) return;
        this.field.value = "";
        this.dialog.showModal();
    }
}
