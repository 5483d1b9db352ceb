import { DecodeError } from "./decode-error.js";

/** Takes little-endian numbers from a byte string, with every read checked against what remains. */
export class ByteReader {
    private readonly bytes: Uint8Array;
    private readonly view: DataView;
    private readonly what: string;
    private position = 0;

    /** @param what names the string in errors */
    constructor(bytes: Uint8Array, what: string) {
        this.bytes = bytes;
        this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
        this.what = what;
    }

    get remaining(): number {
        return this.bytes.length - this.position;
    }

    u8(): number {
        return this.view.getUint8(this.advance(1));
    }
    u16(): number {
        return this.view.getUint16(this.advance(2), true);
    }
    u32(): number {
        return this.view.getUint32(this.advance(4), true);
    }
    u64(): bigint {
        return this.view.getBigUint64(this.advance(8), true);
    }
    f32(): number {
        return this.view.getFloat32(this.advance(4), true);
    }
    f64(): number {
        return this.view.getFloat64(this.advance(8), true);
    }
    /** The next n bytes: a view, not a copy. */
    take(n: number): Uint8Array {
        const begin = this.advance(n);
        return this.bytes.subarray(begin, begin + n);
    }

    /** Steps over n bytes. @returns where they start @throws DecodeError if fewer remain */
    private advance(n: number): number {
        if (n > this.remaining) {
            throw new DecodeError(
                `${this.what}: expected ${n} more bytes at offset ${this.position}, got ${this.remaining}`,
            );
        }
        this.position += n;
        return this.position - n;
    }
}

/** Whether a byte string starts with these bytes. */
export function startsWith(bytes: Uint8Array, start: readonly number[]): boolean {
    return bytes.length >= start.length && start.every((byte, i) => bytes[i] === byte);
}
