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
        this.show((await isCopied(location.href)) ? "Copied" : "It is in the address bar");
        setTimeout(() => this.show("Copy link"), copiedMilliseconds);
    }

    private show(text: string): void {
        this.element.replaceChildren(icon(icons.link), text);
    }
}

/** Browsers let a page copy only if it came by HTTPS or from this machine. */
async function isCopied(text: string): Promise<boolean> {
    if (!navigator.clipboard) return false;
    return navigator.clipboard.writeText(text).then(
        () => true,
        () => false,
    );
}
