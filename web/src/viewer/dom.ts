// Making elements. Text is only ever set as text, so nothing that a server or a file says becomes markup.

type Child = Node | string | undefined | false;

interface Properties {
    readonly class?: string;
    readonly [attribute: string]: string | number | boolean | undefined | ((event: Event) => void);
}

/**
 * An element with attributes and children. `on...` properties are listeners; `true` is an empty attribute; `false` and
 * undefined are none.
 */
export function h<Tag extends keyof HTMLElementTagNameMap>(
    tag: Tag,
    properties: Properties = {},
    ...children: readonly Child[]
): HTMLElementTagNameMap[Tag] {
    return furnish(document.createElement(tag), properties, children);
}

/** The same for a drawing. */
export function svg<Tag extends keyof SVGElementTagNameMap>(
    tag: Tag,
    properties: Properties = {},
    ...children: readonly Child[]
): SVGElementTagNameMap[Tag] {
    return furnish(document.createElementNS("http://www.w3.org/2000/svg", tag), properties, children);
}

function furnish<E extends Element>(element: E, properties: Properties, children: readonly Child[]): E {
    for (const [name, value] of Object.entries(properties)) {
        if (typeof value === "function") element.addEventListener(name.slice(2), value);
        else if (value === true) element.setAttribute(name, "");
        else if (value !== undefined && value !== false) element.setAttribute(name, String(value));
    }
    for (const child of children) if (child) element.append(child);
    return element;
}

/** An icon of 24 by 24, drawn in strokes. */
export function icon(path: string): SVGSVGElement {
    return svg("svg", { class: "icon", viewBox: "0 0 24 24", "aria-hidden": "true" }, svg("path", { d: path }));
}

export const icons = {
    add: "M12 5v14M5 12h14",
    back: "M15 5l-7 7 7 7",
    close: "M6 6l12 12M18 6L6 18",
    download: "M12 4v11m0 0l-4.5-4.5M12 15l4.5-4.5M5 19.5h14",
    fit: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
    link: "M10 14a4 4 0 0 0 6 0l3-3a4.2 4.2 0 0 0-6-6l-1 1M14 10a4 4 0 0 0-6 0l-3 3a4.2 4.2 0 0 0 6 6l1-1",
    theme: "M12 3a9 9 0 1 0 9 9 7 7 0 0 1-9-9z",
    photograph: "M4 7h3l2-2.5h6L17 7h3v12H4zM12 16.5a3.5 3.5 0 1 0 0-7 3.5 3.5 0 0 0 0 7z",
    remove: "M5 7h14M10 7V4.5h4V7M7 7l1 13h8l1-13",
} as const;
