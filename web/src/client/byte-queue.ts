/** Bytes that arrive at one end and are taken from the other. */
export class ByteQueue {
    private buffer = new Uint8Array(0);
    private begin = 0;
    private end = 0;

    /** What is there: a view, valid until the next push(). */
    get bytes(): Uint8Array {
        return this.buffer.subarray(this.begin, this.end);
    }

    push(bytes: Uint8Array): void {
        const waiting = this.bytes;
        if (this.end + bytes.length > this.buffer.length) {
            const needed = waiting.length + bytes.length;
            // Moved to the front, into a larger buffer only if less than half of this one would be free.
            if (2 * needed > this.buffer.length) this.buffer = new Uint8Array(2 * needed);
            this.buffer.set(waiting);
            this.begin = 0;
            this.end = waiting.length;
        }
        this.buffer.set(bytes, this.end);
        this.end += bytes.length;
    }

    drop(nBytes: number): void {
        this.begin += nBytes;
    }
}
