// The token that a server may want: of this tab only, sent in headers and never in an address.
const key = "anyrate-token";

/** Undefined if none was given. */
export function token(): string | undefined {
    return sessionStorage.getItem(key) ?? undefined;
}

export function setToken(token: string): void {
    sessionStorage.setItem(key, token);
}

/** For every request. */
export function authorisation(): Record<string, string> {
    const given = token();
    return given === undefined ? {} : { Authorization: `Bearer ${given}` };
}

/** For the client library. */
export function tokenOption(): { token?: string } {
    const given = token();
    return given === undefined ? {} : { token: given };
}

let ask: (sentence: string) => void = () => {};

/** Sets who asks for a token; see wantsToken(). */
export function onTokenWanted(asks: (sentence: string) => void): void {
    ask = asks;
}

/** Has the visitor asked for a token if that is why a request was refused. @returns whether it was */
export function wantsToken(status: number): boolean {
    if (status !== 401 && status !== 403) return false;
    if (status === 403) ask("This token may read, but not write. Give one that may.");
    else if (token() === undefined) ask("This server wants a token. Whoever runs it makes one with: anyrate token");
    else ask("The server does not know this token. It may be mistyped, or was taken back.");
    return true;
}
