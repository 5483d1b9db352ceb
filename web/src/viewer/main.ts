import "./style.css";

import { h, icon, icons } from "./dom.js";
import { draco } from "./draco.js";
import { galleryPage } from "./gallery-page.js";
import { modelPage } from "./model-page.js";
import { followLinks } from "./page.js";
import type { Page } from "./page.js";
import { TokenDialog } from "./token-dialog.js";
import { onTokenWanted } from "./token.js";
import { uploadPage } from "./upload-page.js";

const root = document.getElementById("app")!;
const themeKey = "anyrate-theme";
let current: Page | undefined;
let currentPath = "";

function pageAt({ pathname, searchParams }: URL): Page {
    const id = /^\/models\/([a-z2-7]{26})$/.exec(pathname)?.[1];
    if (id !== undefined) return modelPage(id, location.search);
    return searchParams.has("new") ? uploadPage() : galleryPage();
}

function show(): void {
    const url = new URL(location.href);
    const path = url.pathname + (url.searchParams.has("new") ? "?new" : "");
    if (path === currentPath && current) return; // the page itself has changed what its address says
    currentPath = path;
    open(url);
}

function open(url: URL): void {
    current?.dispose();
    current = pageAt(url);
    document.title = `${current.title} – Anyrate`;
    root.replaceChildren(header(), current.element);
    scrollTo(0, 0);
}

function header(): HTMLElement {
    return h(
        "header",
        { class: "top" },
        h("a", { class: "wordmark", href: "/" }, mark(), "Anyrate"),
        h("nav", {}, h("a", { class: "button quiet", href: "/?new" }, icon(icons.add), "New model")),
        h("button", { class: "icon-button", title: "Light or dark", "aria-label": "Light or dark", onclick: switchTheme }, icon(icons.theme)),
    );
}

function mark(): SVGSVGElement {
    return icon("M12 2.5 21.5 19.5H2.5zM7.2 11.2h9.6L12 19.5zM9.6 15.3h4.8");
}

function isDark(): boolean {
    const chosen = document.documentElement.dataset["theme"];
    return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

function switchTheme(): void {
    const theme = isDark() ? "light" : "dark";
    document.documentElement.dataset["theme"] = theme;
    localStorage.setItem(themeKey, theme);
}

const chosen = localStorage.getItem(themeKey);
if (chosen) document.documentElement.dataset["theme"] = chosen;
const tokenDialog = new TokenDialog(() => {
    if (!current?.keepsForToken) open(new URL(location.href));
});
onTokenWanted((sentence) => tokenDialog.ask(sentence));
followLinks();
draco(); // starts while the visitor looks around
addEventListener("popstate", show);
show();
