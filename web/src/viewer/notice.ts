import { h } from "./dom.js";

/** A sentence, and what a visitor can do about it. */
export interface Message {
    readonly sentence: string;
    readonly action?: { readonly label: string; readonly run: () => void };
    /** It is over as soon as a request succeeds. */
    readonly isOfConnection?: boolean;
}

/** One message at a time over a stage, or none. */
export class Notice {
    readonly element = h("div", { class: "notice", role: "status", hidden: true });
    private message: Message | undefined;

    show(message: Message): void {
        const { sentence, action } = message;
        this.message = message;
        this.element.hidden = false;
        this.element.replaceChildren(sentence);
        if (action) this.element.append(" ", h("button", { class: "button quiet", onclick: action.run }, action.label));
    }

    say(sentence: string): void {
        this.show({ sentence });
    }

    clear(): void {
        this.message = undefined;
        this.element.hidden = true;
        this.element.replaceChildren();
    }

    /** Takes back a message that the connection is lost. */
    clearConnection(): void {
        if (this.message?.isOfConnection) this.clear();
    }
}
