import { authorisation } from "./token.js";

/**
 * Sends a request and says how far it has come; with fetch, a page is not told that.
 * @param onProgress is told the bytes that have left
 * @throws TypeError the connection broke, DOMException (AbortError)
 */
export function sendBody(
    method: "POST" | "PUT",
    url: string,
    body: Blob | undefined,
    headers: Readonly<Record<string, string>>,
    signal: AbortSignal,
    onProgress: (nBytes: number) => void = () => {},
): Promise<{ status: number; body: string }> {
    return new Promise((resolve, reject) => {
        const request = new XMLHttpRequest();
        const stop = () => request.abort();
        request.open(method, url);
        for (const [name, value] of Object.entries({ ...headers, ...authorisation() })) request.setRequestHeader(name, value);
        request.upload.onprogress = ({ loaded }) => onProgress(loaded);
        request.onload = () => resolve({ status: request.status, body: request.responseText });
        request.onerror = () => reject(new TypeError("the connection broke"));
        request.onabort = () => reject(new DOMException("stopped", "AbortError"));
        request.onloadend = () => signal.removeEventListener("abort", stop);
        signal.addEventListener("abort", stop);
        request.send(body ?? null);
    });
}
