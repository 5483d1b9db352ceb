import type { CameraInfo, Cameras } from "./api.js";
import { fittedRectangle } from "./camera-view.js";
import type { Rectangle, Size } from "./camera-view.js";
import { h, icon, icons } from "./dom.js";
import type { PhotographView } from "./photograph-camera.js";
import { showPicture } from "./server-file.js";

/** The input photographs as a strip, and the one that is looked through, behind the mesh or blended over it. */
export class PhotoStrip {
    /** For the foot of the stage. */
    readonly strip = h("div", { class: "strip", role: "listbox", "aria-label": "Input photographs" });
    /** For the stage itself: under or over the canvas. */
    readonly picture = h("img", { class: "photograph", alt: "", hidden: true });
    readonly blendControl: HTMLElement;
    onEnter: (view: PhotographView, place: Rectangle) => void = () => {};
    /** Is told where the photograph lies now, if one is looked through. */
    onPlace: (place: Rectangle) => void = () => {};
    onLeave: () => void = () => {};

    private readonly cameras: Cameras;
    private readonly buttons: HTMLButtonElement[];
    private readonly blend: HTMLInputElement;
    private readonly freePlace: () => Rectangle;
    private readonly resize: ResizeObserver;
    private readonly inView: IntersectionObserver;
    private current: number | undefined;
    private image: Size | undefined;
    private showsPictures = false;

    /** @param freePlace what of the stage nothing else covers */
    constructor(cameras: Cameras, stage: HTMLElement, freePlace: () => Rectangle) {
        this.cameras = cameras;
        this.freePlace = freePlace;
        this.buttons = cameras.cameras.map((camera, i) => this.button(camera, i));
        this.strip.append(...this.buttons);
        this.blend = h("input", { type: "range", min: 0, max: 100, value: 50, "aria-label": "Blend", oninput: () => this.setBlend() });
        this.blendControl = h(
            "div",
            { class: "blend", hidden: true },
            h("span", {}, "Mesh"),
            this.blend,
            h("span", {}, "Photograph"),
            h("button", { class: "icon-button", title: "Leave this photograph", onclick: () => this.onLeave() }, icon(icons.close)),
        );
        this.resize = new ResizeObserver(() => this.place());
        this.resize.observe(stage);
        this.inView = new IntersectionObserver((entries) => this.load(entries), { root: this.strip, rootMargin: "0px 200px" });
    }

    /** Loads the small pictures as they come into view, from now on. */
    showPictures(): void {
        if (this.showsPictures) return;
        this.showsPictures = true;
        for (const button of this.buttons) this.inView.observe(button);
    }

    get selected(): number | undefined {
        return this.current;
    }

    /** Looks through a photograph's camera. */
    async enter(index: number): Promise<void> {
        const camera = this.cameras.cameras[index];
        if (!camera) return;
        this.select(index);
        await showPicture(this.picture, camera.photograph).catch(() => {}); // the page then has its view without its picture
        if (this.current !== index) return;
        const natural = { width: this.picture.naturalWidth, height: this.picture.naturalHeight };
        this.image = { width: camera.width ?? natural.width, height: camera.height ?? natural.height };
        if (!this.image.width || !this.image.height) return;
        this.picture.hidden = false;
        this.blendControl.hidden = false;
        this.setBlend();
        this.onEnter({ camera, pixelCentre: this.cameras.pixel_center, image: this.image }, this.rectangle(this.image));
        this.place();
    }

    leave(): void {
        this.select(undefined);
        this.picture.hidden = true;
        this.blendControl.hidden = true;
        this.image = undefined;
    }

    dispose(): void {
        this.resize.disconnect();
        this.inView.disconnect();
    }

    private load(entries: readonly IntersectionObserverEntry[]): void {
        for (const { isIntersecting, target } of entries) {
            if (!isIntersecting) continue;
            this.inView.unobserve(target);
            const camera = this.cameras.cameras[this.buttons.indexOf(target as HTMLButtonElement)];
            const image = target.querySelector("img")!;
            void showPicture(image, camera.thumbnail)
                .catch(() => showPicture(image, camera.photograph)) // of a model that was made before there were thumbnails
                .catch(() => target.classList.add("missing"));
        }
    }

    private select(index: number | undefined): void {
        this.current = index;
        this.buttons.forEach((button, i) => button.setAttribute("aria-selected", String(i === index)));
    }

    /** At 0 the photograph is behind the mesh; from there on it is blended over it. */
    private setBlend(): void {
        const share = Number(this.blend.value) / 100;
        this.picture.classList.toggle("behind", share === 0);
        this.picture.style.opacity = String(share === 0 ? 1 : share);
        this.blend.style.setProperty("--share", `${this.blend.value}%`);
    }

    /** Puts the photograph where there is room for it, after the room has changed. */
    place(): void {
        if (!this.image) return;
        const place = this.rectangle(this.image);
        const { left, top, width, height } = place;
        Object.assign(this.picture.style, { left: `${left}px`, top: `${top}px`, width: `${width}px`, height: `${height}px` });
        this.onPlace(place);
    }

    private rectangle(image: Size): Rectangle {
        return fittedRectangle(image, this.freePlace());
    }

    private button(camera: CameraInfo, index: number): HTMLButtonElement {
        const name = camera.name.replace(/^.*\//, "");
        return h(
            "button",
            {
                class: "thumb",
                role: "option",
                "aria-selected": "false",
                title: `Look through ${name}`,
                onclick: () => void (this.current === index ? this.onLeave() : this.enter(index)),
            },
            h("img", { alt: name, decoding: "async", width: 72, height: 54 }),
        );
    }
}
