import { h, icon, icons } from "./dom.js";

const copiedMilliseconds = 1600;

/** Copies the page's address. */
export class ShareButton {
    readonly element = h("button", { class: "button quiet", onclick: () => void this.copy() });
    /** Brings the address up to date. */
    onBeforeCopy: () => void = () => {};

    constructor() {
        this.show("Copy link");
    }

    private async copy(): Promise<void> {
        this.onBeforeCopy();
        await navigator.clipboard?.writeText(location.href).catch(() => {}); // the address bar has it, too
        this.show("Copied");
        setTimeout(() => this.show("Copy link"), copiedMilliseconds);
    }

    private show(text: string): void {
        this.element.replaceChildren(icon(icons.link), text);
    }
}
