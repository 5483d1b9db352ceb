// Files of the server in elements that can send no token: then they are fetched, and shown from memory.
import { authorisation, token } from "./token.js";

/** Shows a picture of the server in an image, and waits until it is there. @throws if it cannot be had */
export async function showPicture(image: HTMLImageElement, url: string): Promise<void> {
    const source = token() === undefined ? url : await fromMemory(url);
    image.src = source;
    await image.decode();
    if (source !== url) URL.revokeObjectURL(source);
}

/** A link that saves a file of the server, under the name that it has as a `download`. */
export function saveWithToken(link: HTMLAnchorElement): void {
    link.addEventListener("click", (event) => {
        if (token() === undefined || link.protocol === "blob:") return;
        event.preventDefault();
        void fromMemory(link.href).then((source) => {
            const saved = link.cloneNode() as HTMLAnchorElement;
            saved.href = source;
            saved.click();
            setTimeout(() => URL.revokeObjectURL(source), 60_000);
        });
    });
}

async function fromMemory(url: string): Promise<string> {
    const response = await fetch(url, { headers: authorisation() });
    if (!response.ok) throw new Error(`${url}: the server answered ${response.status}`);
    return URL.createObjectURL(await response.blob());
}
