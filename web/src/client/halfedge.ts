// Half-edge 3f + i runs from corner i of face f to corner i + 1: proto/FORMAT.md, "State".

/** The half-edge behind h in its face. */
export function next(h: number): number {
    return h % 3 === 2 ? h - 2 : h + 1;
}

/** The half-edge before h in its face. */
export function prev(h: number): number {
    return h % 3 === 0 ? h + 2 : h - 1;
}
