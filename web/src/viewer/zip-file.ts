// Zip archives as a capture's upload needs them (PKWARE, .ZIP File Format Specification 6.3): stored, not compressed,
// for images are compressed already; below 4 GB and 65,535 files.

export interface NamedFile {
    /** Parts joined by '/'. */
    readonly name: string;
    readonly file: Blob;
}

const crcTable = Uint32Array.from({ length: 256 }, (_, n) => {
    for (let bit = 0; bit < 8; ++bit) n = n & 1 ? (n >>> 1) ^ 0xedb88320 : n >>> 1;
    return n >>> 0;
});

function crc32(bytes: Uint8Array): number {
    let crc = 0xffffffff;
    for (const byte of bytes) crc = (crc >>> 8) ^ crcTable[(crc ^ byte) & 0xff];
    return ~crc >>> 0;
}

/** @param onProgress is told the share that is done, 0 to 1 */
export async function zipOf(files: readonly NamedFile[], onProgress: (share: number) => void = () => {}): Promise<Blob> {
    const parts: BlobPart[] = [];
    const directory: Uint8Array<ArrayBuffer>[] = [];
    let offset = 0;
    for (const [i, { name, file }] of files.entries()) {
        const crc = crc32(new Uint8Array(await file.arrayBuffer()));
        const encoded = new TextEncoder().encode(name);
        const local = record([[4, 0x04034b50], [2, 20], ...common(crc, file.size, encoded.length)], encoded);
        directory.push(
            record(
                [[4, 0x02014b50], [2, 20], [2, 20], ...common(crc, file.size, encoded.length), [2, 0], [2, 0], [2, 0], [4, 0], [4, offset]],
                encoded,
            ),
        );
        parts.push(local, file);
        offset += local.length + file.size;
        onProgress((i + 1) / files.length);
    }
    const directoryBytes = directory.reduce((sum, { length }) => sum + length, 0);
    const end = record([[4, 0x06054b50], [2, 0], [2, 0], [2, files.length], [2, files.length], [4, directoryBytes], [4, offset], [2, 0]]);
    return new Blob([...parts, ...directory, end], { type: "application/zip" });
}

/** Names of the files in a zip, from its central directory; undefined if it has none. */
export async function namesInZip(zip: Blob): Promise<string[] | undefined> {
    const tail = new DataView(await zip.slice(Math.max(0, zip.size - 65_557)).arrayBuffer());
    let end = tail.byteLength - 22;
    while (end >= 0 && tail.getUint32(end, true) !== 0x06054b50) --end;
    if (end < 0) return undefined;
    const [size, begin] = [tail.getUint32(end + 12, true), tail.getUint32(end + 16, true)];
    const directory = new DataView(await zip.slice(begin, begin + size).arrayBuffer());
    const names: string[] = [];
    for (let at = 0; at + 46 <= directory.byteLength && directory.getUint32(at, true) === 0x02014b50; ) {
        const length = directory.getUint16(at + 28, true);
        if (at + 46 + length > directory.byteLength) break;
        names.push(new TextDecoder().decode(new Uint8Array(directory.buffer, at + 46, length)));
        at += 46 + length + directory.getUint16(at + 30, true) + directory.getUint16(at + 32, true);
    }
    return names;
}

type Field = readonly [nBytes: number, value: number];

/** Flags (names are UTF-8), method, time (1980-01-01), checksum, sizes, lengths of name and of nothing. */
function common(crc: number, size: number, nameLength: number): Field[] {
    return [[2, 0x0800], [2, 0], [2, 0], [2, 0x21], [4, crc], [4, size], [4, size], [2, nameLength], [2, 0]];
}

function record(fields: readonly Field[], name: Uint8Array = new Uint8Array(0)): Uint8Array<ArrayBuffer> {
    const size = fields.reduce((sum, [nBytes]) => sum + nBytes, 0);
    const bytes = new Uint8Array(size + name.length);
    const view = new DataView(bytes.buffer);
    let at = 0;
    for (const [nBytes, value] of fields) {
        if (nBytes === 2) view.setUint16(at, value, true);
        else view.setUint32(at, value, true);
        at += nBytes;
    }
    bytes.set(name, size);
    return bytes;
}
