import type { ResponseLike } from "./platform.js";

/** What a server answered in place of what was asked for. */
export class ServerError extends Error {
    override readonly name = "ServerError";
    readonly status: number;

    constructor(status: number, sentence: string) {
        super(sentence);
        this.status = status;
    }
}

/** The server's own sentence, if it sent a problem document (RFC 9457). */
export async function serverError(response: ResponseLike, url: string): Promise<ServerError> {
    const text = await response.text().catch(() => "");
    return new ServerError(response.status, detailOf(text) ?? `${url}: the server answered ${response.status}`);
}

function detailOf(text: string): string | undefined {
    try {
        const problem: unknown = JSON.parse(text);
        const detail = typeof problem === "object" && problem !== null && "detail" in problem && problem.detail;
        return typeof detail === "string" ? detail : undefined;
    } catch {
        return undefined; // no JSON: the status says it
    }
}
