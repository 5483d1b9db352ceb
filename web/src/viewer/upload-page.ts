import { remember, RequestError } from "./api.js";
import type { Fault } from "./api.js";
import { checkCapture } from "./capture-check.js";
import type { CheckedCapture } from "./capture-check.js";
import { h, icon, icons } from "./dom.js";
import { bytes, count } from "./format.js";
import type { Page } from "./page.js";
import { goTo } from "./page.js";
import { wantsToken } from "./token.js";
import { newUploader } from "./uploader.js";
import type { Uploader } from "./uploader.js";
import type { NamedFile } from "./zip-file.js";

const shownFaults = 12;

/** Where a capture is dropped, looked at, and sent. */
export function uploadPage(): Page {
    const page = new UploadPage();
    return { element: page.element, title: "New model", keepsForToken: true, dispose: () => page.dispose() };
}

class UploadPage {
    readonly element: HTMLElement;
    private readonly result = h("div", { class: "upload-result", "aria-live": "polite" });
    private readonly vertices = h("input", { type: "number", id: "vertices", min: 100, max: 1_000_000, step: 100, value: 10_000, inputmode: "numeric" });
    private readonly drop: HTMLElement;
    private readonly stop = new AbortController();

    constructor() {
        const folder = h("input", { type: "file", multiple: true, webkitdirectory: true, hidden: true, onchange: () => void this.look(picked(folder)) });
        const files = h("input", { type: "file", multiple: true, hidden: true, accept: ".zip,.json,image/png,image/jpeg", onchange: () => void this.look(picked(files)) });
        this.drop = h(
            "div",
            { class: "drop" },
            h("div", { class: "drop-mark" }, icon(icons.photograph)),
            h("h2", {}, "Drop a folder or a zip here"),
            h("p", {}, "images/, masks/ and cameras.json, as anyrate simulate writes them. At least three photographs."),
            h(
                "div",
                { class: "row" },
                h("button", { class: "button primary", onclick: () => folder.click() }, "Choose a folder"),
                h("button", { class: "button", onclick: () => files.click() }, "Choose a zip or files"),
            ),
            folder,
            files,
        );
        this.takeDrops();
        this.element = h(
            "main",
            { class: "upload" },
            h("h1", {}, "New model"),
            h("p", { class: "lead" }, "Calibrated, segmented photographs become a mesh that streams at any size. You can watch it grow."),
            this.drop,
            this.result,
        );
    }

    dispose(): void {
        this.stop.abort();
    }

    /** Anywhere on the page: a browser would open what is dropped beside the place for it, and leave. */
    private takeDrops(): void {
        const { signal } = this.stop;
        const hover = (event: DragEvent, over: boolean) => {
            event.preventDefault();
            this.drop.classList.toggle("over", over);
        };
        addEventListener("dragover", (event) => hover(event, true), { signal });
        addEventListener("dragleave", (event) => hover(event, event.relatedTarget !== null), { signal });
        addEventListener("drop", (event) => hover(event, false), { signal });
        addEventListener("drop", (event) => void dropped(event).then((list) => this.look(list)), { signal });
    }

    private async look(files: NamedFile[]): Promise<void> {
        if (files.length === 0) return;
        this.result.replaceChildren(h("p", { class: "muted" }, `Looking at ${count(files.length)} files…`));
        const capture = await checkCapture(files);
        this.result.replaceChildren(capture.faults.length > 0 ? faultList("This is not ready to be sent", capture.faults) : this.offer(capture));
    }

    private offer(capture: CheckedCapture): HTMLElement {
        const what = capture.nImages === undefined ? "A zip" : `${count(capture.nImages)} photographs`;
        const leftOut = capture.nLeftOut > 0 ? `; ${leftOutSentence(capture.nLeftOut)}` : "";
        const uploader = () => newUploader(capture, Math.min(Math.max(Number(this.vertices.value) || 10_000, 100), 1_000_000));
        let current: Uploader | undefined;
        const bar = h("span", { class: "fill" });
        const note = h("p", { class: "muted" });
        const trouble = h("div", { class: "trouble", role: "alert" });
        const start = h("button", { class: "button primary", onclick: () => void send() }, "Upload and reconstruct");
        const progress = h("div", { class: "progress", hidden: true }, h("span", { class: "bar" }, bar), note);
        const send = async () => {
            current ??= uploader();
            start.disabled = this.vertices.disabled = true;
            progress.hidden = false;
            trouble.replaceChildren();
            try {
                const model = await current.send(({ phase, share }) => {
                    bar.style.width = `${100 * share}%`;
                    note.textContent =
                        phase === "packing" ? "Packing…" : `Sending: ${bytes(share * capture.nBytes)} of ${bytes(capture.nBytes)}`;
                }, this.stop.signal);
                remember(model);
                goTo(`/models/${model.id}`);
            } catch (error) {
                start.disabled = false;
                start.textContent = "Try again";
                trouble.replaceChildren(sayFailure(error));
                if (error instanceof RequestError) wantsToken(error.status);
            }
        };
        return h(
            "div",
            { class: "offer" },
            h("p", { class: "ready" }, `${what}, ${bytes(capture.nBytes)}, ready to go${leftOut}.`),
            h("div", { class: "row" }, h("label", { for: "vertices" }, "Vertices of the finest mesh"), this.vertices, start),
            progress,
            trouble,
        );
    }
}

function leftOutSentence(n: number): string {
    return n === 1 ? "a file that no camera names stays here" : `${count(n)} files that no camera names stay here`;
}

function faultList(title: string, faults: readonly Fault[]): HTMLElement {
    const items = faults.slice(0, shownFaults).map(({ file, sentence }) => h("li", {}, h("code", {}, file), ` ${sentence}.`));
    const rest = faults.length - items.length;
    if (rest > 0) items.push(h("li", {}, `and ${count(rest)} more`));
    return h("div", { class: "faults", role: "alert" }, h("h3", {}, title), h("ul", {}, ...items));
}

function sayFailure(error: unknown): string | HTMLElement {
    if (error instanceof RequestError && error.faults.length > 0) {
        const faults = error.faults.map(({ file, sentence }) => ({ file: `${file}:`, sentence }));
        return faultList("The server refuses these files. Mend them and choose the capture again: what has arrived is not sent again.", faults);
    }
    if (error instanceof RequestError) return error.message;
    if (error instanceof TypeError) return "The connection broke. What has arrived is not lost: try again, and the upload goes on.";
    return String(error);
}

function picked(input: HTMLInputElement): NamedFile[] {
    return [...(input.files ?? [])].map((file) => ({ name: file.webkitRelativePath || nameInCapture(file.name), file }));
}

/** Of a file that was picked without its folder. */
function nameInCapture(name: string): string {
    return /\.(png|jpe?g)$/i.test(name) ? `images/${name}` : name;
}

async function dropped(event: DragEvent): Promise<NamedFile[]> {
    event.preventDefault();
    const entries = [...(event.dataTransfer?.items ?? [])].map((item) => item.webkitGetAsEntry());
    const found: NamedFile[] = [];
    for (const entry of entries) if (entry) await collect(entry, "", found);
    return found;
}

async function collect(entry: FileSystemEntry, folder: string, found: NamedFile[]): Promise<void> {
    if (entry.isFile) {
        const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
        found.push({ name: folder + entry.name, file });
        return;
    }
    const reader = (entry as FileSystemDirectoryEntry).createReader();
    for (;;) {
        // A reader gives a hundred entries at a time.
        const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
        if (some.length === 0) return;
        for (const child of some) await collect(child, `${folder}${entry.name}/`, found);
    }
}
