// What the first bytes of a Draco string announce, read before Draco allocates by them. The layouts are those of the
// Draco bitstreams 2.3 (point cloud) and 2.2 (mesh); the values behind them are for Draco alone to read.
import { ByteReader } from "./byte-reader.js";
import { DecodeError } from "./decode-error.js";

const dracoMagic = "DRACO";
const pointCloud = { name: "a point cloud", minor: 3, type: 0, method: 0 }; // method 1, a kd-tree, reorders points
const mesh = { name: "a mesh", minor: 2, type: 1, method: 1 };
const typeInt32 = 5;

/** @throws DecodeError unless `bytes` announce a sequential cloud of nPoints with exactly these int32 attributes */
export function checkPointCloudLayout(bytes: Uint8Array, nPoints: number, nComponents: readonly number[]): void {
    const reader = openDraco(bytes, pointCloud);
    expect("points", reader.u32(), nPoints);
    expect("groups of attributes", reader.u8(), 1);
    expect("attributes", varint(reader), nComponents.length);
    for (const n of nComponents) {
        reader.u8(); // what the attribute is for
        expect("the type int32 (5)", reader.u8(), typeInt32);
        expect("components", reader.u8(), n);
        reader.u8(); // normalised
        varint(reader); // unique id
    }
}

/** @throws DecodeError unless `bytes` announce an edgebreaker mesh of these counts, with positions only */
export function checkMeshLayout(bytes: Uint8Array, nVertices: number, nFaces: number): void {
    const reader = openDraco(bytes, mesh);
    reader.u8(); // traversal
    expect("vertices", varint(reader), nVertices);
    expect("faces", varint(reader), nFaces);
    expect("attributes beside the position", reader.u8(), 0);
}

function openDraco(bytes: Uint8Array, geometry: typeof mesh): ByteReader {
    const reader = new ByteReader(bytes, "Draco payload");
    const start = String.fromCharCode(...reader.take(dracoMagic.length));
    if (start !== dracoMagic) throw new DecodeError(`Draco payload: expected it to start with ${dracoMagic}`);
    const [major, minor, type, method] = [reader.u8(), reader.u8(), reader.u8(), reader.u8()];
    if (major !== 2 || minor !== geometry.minor || type !== geometry.type || method !== geometry.method) {
        throw new DecodeError(
            `Draco payload: expected ${geometry.name} (version 2.${geometry.minor}, type ${geometry.type}, ` +
                `method ${geometry.method}), got version ${major}.${minor}, type ${type}, method ${method}`,
        );
    }
    expect("flags", reader.u16(), 0);
    return reader;
}

/** Seven bits a byte, the lowest first; at most 32 bits. */
function varint(reader: ByteReader): number {
    let value = 0;
    for (let shift = 1; shift <= 2 ** 28; shift *= 128) {
        const byte = reader.u8();
        value += (byte & 0x7f) * shift;
        if (byte < 0x80) return value;
    }
    throw new DecodeError("Draco payload: expected a number of at most five bytes");
}

function expect(what: string, found: number, expected: number): void {
    if (found !== expected) throw new DecodeError(`Draco payload: expected ${expected} as ${what}, got ${found}`);
}
