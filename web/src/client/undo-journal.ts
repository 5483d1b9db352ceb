/** Remembers the integers that one operation overwrites, so that an operation that fails half-way leaves no trace. */
export class UndoJournal {
    private readonly arrays: Int32Array[] = [];
    private slots = new Int32Array(256);
    private values = new Int32Array(256);
    private length = 0;

    /** Writes a value. The array must be in use until the undo() or clear() that ends the operation. */
    set(array: Int32Array, slot: number, value: number): void {
        if (this.length === this.slots.length) this.grow();
        this.arrays[this.length] = array;
        this.slots[this.length] = slot;
        this.values[this.length] = array[slot];
        ++this.length;
        array[slot] = value;
    }

    /** Puts the old values back, newest first. */
    undo(): void {
        while (this.length > 0) {
            --this.length;
            this.arrays[this.length][this.slots[this.length]] = this.values[this.length];
        }
    }

    clear(): void {
        this.length = 0;
    }

    /** As clear(), and lets go of the arrays that were written: they may have been replaced by larger ones. */
    release(): void {
        this.length = 0;
        this.arrays.length = 0;
    }

    private grow(): void {
        const [slots, values] = [this.slots, this.values];
        this.slots = new Int32Array(2 * slots.length);
        this.slots.set(slots);
        this.values = new Int32Array(2 * values.length);
        this.values.set(values);
    }
}
