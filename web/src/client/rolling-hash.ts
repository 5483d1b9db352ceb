/**
 * A rolling 32-bit hash, one multiplication a word (proto/FORMAT.md, "State hash"). A differing word always shows: each
 * step is a bijection of the hash for a given word, and of the word for a given hash.
 */
export class RollingHash {
    // An array of one: a number field that does not fit a small integer would be boxed in some engines.
    private readonly word = new Int32Array(1);

    mix(word: number): void {
        const h = Math.imul(this.word[0] ^ word, 0x9e3779b1);
        this.word[0] = h ^ (h >>> 15);
    }

    /** The hash, 0 to 2^32 - 1; set to go back to an earlier one. */
    get value(): number {
        return this.word[0] >>> 0;
    }
    set value(value: number) {
        this.word[0] = value;
    }
}
