import { authorisation, wantsToken } from "./token.js";

const retryMilliseconds = 1000;

/**
 * Reads Server-Sent Events (WHATWG HTML, 9.2) of one server, each a name and one line of data; connects again when the
 * connection breaks. In place of EventSource, which can send no token.
 * @param onEvent is told an event; `false` ends it
 * @param onGone  the server knows the address no longer
 */
export async function readEvents(
    url: string,
    signal: AbortSignal,
    onEvent: (name: string, data: string) => boolean,
    onGone: () => void,
): Promise<void> {
    while (!signal.aborted) {
        try {
            const response = await fetch(url, { headers: authorisation(), signal });
            if (response.status === 404) return onGone();
            if (wantsToken(response.status)) return;
            if (response.ok && response.body && !(await readOnce(response.body, onEvent))) return;
        } catch {
            // it broke: once more, unless it was stopped
        }
        await new Promise((resolve) => setTimeout(resolve, retryMilliseconds));
    }
}

/** @returns whether more is wanted */
async function readOnce(body: ReadableStream<Uint8Array>, onEvent: (name: string, data: string) => boolean): Promise<boolean> {
    const reader = body.getReader();
    const decoder = new TextDecoder();
    let text = "";
    for (;;) {
        const { done, value } = await reader.read();
        if (done) return true;
        text += decoder.decode(value, { stream: true });
        for (let end = text.indexOf("\n\n"); end >= 0; end = text.indexOf("\n\n")) {
            const lines = text.slice(0, end).split("\n");
            text = text.slice(end + 2);
            const field = (name: string) => lines.find((line) => line.startsWith(`${name}:`))?.slice(name.length + 1).trim();
            const data = field("data");
            if (data === undefined || onEvent(field("event") ?? "message", data)) continue;
            void reader.cancel();
            return false;
        }
    }
}
