/** Elements first, first + 1, .. first + count - 1. */
export interface Range {
    readonly first: number;
    readonly count: number;
}

/** Remembers which elements of a growing array have changed, to tell them as ranges. */
export class ChangeMarks {
    private flags = new Uint8Array(0);
    private lowest = Infinity;
    private highest = -1;

    /** Makes room for marks below n. */
    reserve(n: number): void {
        if (n <= this.flags.length) return;
        const flags = this.flags;
        this.flags = new Uint8Array(Math.max(n, 2 * flags.length));
        this.flags.set(flags);
    }

    mark(element: number): void {
        this.flags[element] = 1;
        if (element < this.lowest) this.lowest = element;
        if (element > this.highest) this.highest = element;
    }

    markRange({ first, count }: Range): void {
        if (count <= 0) return;
        this.reserve(first + count);
        this.flags.fill(1, first, first + count);
        this.lowest = Math.min(this.lowest, first);
        this.highest = Math.max(this.highest, first + count - 1);
    }

    /**
     * What was marked since the last call, ascending, and forgets it. Ranges that no more than `mergedGap` unchanged
     * elements keep apart are told as one: a few large uploads to a graphics card cost less than many small ones.
     * @param n elements that exist: marks beyond are those of an operation that was undone
     */
    take(n: number, mergedGap: number): Range[] {
        const ranges: Range[] = [];
        let first = -1;
        let end = -1; // of the range that starts at `first`
        const close = () => {
            if (end > first) ranges.push({ first, count: end - first });
        };
        const last = Math.min(this.highest, n - 1);
        for (let i = this.lowest; i <= last; ++i) {
            if (this.flags[i] === 0) continue;
            if (end < 0 || i > end + mergedGap) {
                close();
                first = i;
            }
            end = i + 1;
        }
        close();
        if (this.highest >= 0) this.flags.fill(0, this.lowest, this.highest + 1);
        this.lowest = Infinity;
        this.highest = -1;
        return ranges;
    }
}
