// Pages and addresses: "/" the gallery, "/?new" an upload, "/models/ID" a model.

export interface Page {
    readonly element: HTMLElement;
    readonly title: string;
    /** Goes on by itself, or by its visitor, once there is another token; else it is made anew. */
    readonly keepsForToken?: boolean;
    dispose(): void;
}

/** Goes to another page of the viewer. */
export function goTo(address: string): void {
    history.pushState(null, "", address);
    dispatchEvent(new PopStateEvent("popstate"));
}

/** Lets links between pages be followed without loading the page's files again. */
export function followLinks(): void {
    addEventListener("click", (event) => {
        const link = (event.target as Element | null)?.closest("a");
        if (!link || link.origin !== location.origin || link.hasAttribute("download") || event.defaultPrevented) return;
        if (event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey || !isPage(link)) return;
        event.preventDefault();
        goTo(link.pathname + link.search);
    });
}

function isPage({ pathname }: URL | HTMLAnchorElement): boolean {
    return pathname === "/" || pathname.startsWith("/models/");
}
