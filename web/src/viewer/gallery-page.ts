import { deleteModel, isFinal, listModels, RequestError, watchModel } from "./api.js";
import type { ModelInfo } from "./api.js";
import { h, icon, icons } from "./dom.js";
import { bytes, count, dateOrTime, shortId } from "./format.js";
import type { Page } from "./page.js";
import { stateSentence } from "./stage-list.js";
import { ThumbnailPainter } from "./thumbnail.js";

/** The models of the server, newest first. */
export function galleryPage(): Page {
    const gallery = new Gallery();
    void gallery.load();
    return { element: gallery.element, title: "Models", dispose: () => gallery.dispose() };
}

class Gallery {
    private readonly grid = h("div", { class: "cards" });
    private readonly note = h("p", { class: "notice", role: "status", hidden: true });
    private readonly more = h("button", { class: "button", hidden: true, onclick: () => void this.load() }, "Show more");
    readonly element = h(
        "main",
        { class: "gallery" },
        h("h1", {}, "Models"),
        h("p", { class: "lead" }, "Each is one stream: any beginning of it is a mesh, as fine as its bytes allow."),
        this.note,
        this.grid,
        h("div", { class: "row centred" }, this.more),
    );
    private readonly painter = new ThumbnailPainter();
    private readonly stops: (() => void)[] = [];
    private next: string | undefined;
    private isFirst = true;

    async load(): Promise<void> {
        try {
            const page = await listModels(this.next);
            if (this.isFirst) this.grid.append(newCard());
            this.isFirst = false;
            for (const model of page.models) this.grid.append(this.card(model));
            this.next = page.next;
            this.more.hidden = page.next === undefined;
            this.note.hidden = true;
        } catch (error) {
            this.note.hidden = false;
            const isClosed = error instanceof RequestError && error.status === 401;
            this.note.replaceChildren(
                isClosed ? "The models are shown to those who have a token. " : `The models cannot be shown: ${sentenceOfError(error)} `,
                h("button", { class: "button quiet", onclick: () => void this.load() }, "Try again"),
            );
        }
    }

    dispose(): void {
        for (const stop of this.stops) stop();
        this.painter.dispose();
    }

    private card(model: ModelInfo): HTMLElement {
        const canvas = h("canvas", { class: "thumbnail", "aria-hidden": "true" });
        const state = h("span", { class: "chip" });
        const numbers = h("span", { class: "numbers" });
        const fill = h("span", { class: "fill" });
        const bar = h("span", { class: "bar" }, fill);
        const sentence = h("p", { class: "card-error" });
        const remove = h("button", { class: "icon-button remove", title: "Delete", "aria-label": `Delete model ${shortId(model.id)}` }, icon(icons.remove));
        const card = h(
            "article",
            { class: "card", "data-id": model.id },
            h("a", { class: "card-link", href: `/models/${model.id}`, "aria-label": `Model ${shortId(model.id)}` }, h("span", { class: "card-picture" }, icon(icons.photograph), canvas)),
            h("div", { class: "card-line" }, h("span", { class: "card-name" }, shortId(model.id)), state, remove),
            h("div", { class: "card-line muted" }, numbers, h("time", { datetime: model.created }, dateOrTime(model.created))),
            bar,
            sentence,
        );
        remove.addEventListener("click", () => void this.remove(model, card));
        let painted = "";
        const show = (now: ModelInfo) => {
            state.textContent = now.state === "queued" ? "Waiting" : stateSentence(now);
            state.className = `chip ${now.state}`;
            numbers.replaceChildren(...(now.vertices > 0 ? [h("span", {}, `${count(now.vertices)} vertices`), h("span", {}, bytes(now.bytes))] : [isFinal(now) ? "no mesh" : "no mesh yet"]));
            bar.hidden = isFinal(now);
            fill.style.width = `${100 * now.fraction}%`;
            sentence.textContent = now.error ?? "";
            // Once there is something to see, and again when it is done.
            if (now.vertices > 0 && painted !== now.state && (now.state === "done" || !painted)) {
                painted = now.state;
                this.painter.paint(model.id, canvas);
            }
        };
        show(model);
        if (!isFinal(model)) this.stops.push(watchModel(model.id, show, () => card.remove()));
        return card;
    }

    private async remove(model: ModelInfo, card: HTMLElement): Promise<void> {
        if (!confirm(`Delete model ${shortId(model.id)}? Its photographs and its mesh go with it.`)) return;
        try {
            await deleteModel(model.id);
            card.remove();
        } catch (error) {
            this.note.hidden = false;
            this.note.textContent = sentenceOfError(error);
        }
    }
}

function sentenceOfError(error: unknown): string {
    return error instanceof TypeError ? "the server cannot be reached." : (error as Error).message;
}

function newCard(): HTMLElement {
    return h(
        "a",
        { class: "card new", href: "/?new" },
        h("span", { class: "new-mark" }, icon(icons.add)),
        h("span", { class: "card-name" }, "New model"),
        h("span", { class: "muted" }, "from a folder or a zip of photographs"),
    );
}
