// GLB files as `anyrate decode` writes them: valid by Khronos' validator, and what loaders rely on holds.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

// @ts-expect-error no types
import validator from "gltf-validator";

import { decodeLog } from "../src/client/index.js";
import type { ProgressiveMesh } from "../src/client/index.js";
import { decodeGeometry } from "./draco3d-all.js";
import type { DecodedGeometry } from "./draco3d-all.js";
import { draco, icosphere, repository } from "./golden.js";
import { anyrate, inScratchFolder, noProgram, testUnless } from "./program.js";

const model = fileURLToPath(new URL("tests/golden/icosphere.arl", repository));
const extension = "KHR_draco_mesh_compression";

interface Accessor {
    readonly bufferView?: number;
    readonly componentType: number;
    readonly count: number;
    readonly type: string;
    readonly min?: number[];
    readonly max?: number[];
}

interface Glb {
    readonly json: any;
    readonly accessors: readonly Accessor[];
    readonly primitive: any;
    /** Bytes of a view. */
    readonly view: (number: number) => Uint8Array;
}

/** A file's bytes, and what they are. */
async function written(words: readonly string[], use: (file: Uint8Array, glb: Glb) => void | Promise<void>) {
    await inScratchFolder(async (folder) => {
        const mesh = join(folder, "mesh.glb");
        await anyrate("decode", model, "-o", mesh, ...words);
        const file = new Uint8Array(readFileSync(mesh));
        await use(file, parsed(file));
    });
}

function parsed(file: Uint8Array): Glb {
    const words = new DataView(file.buffer);
    assert.equal(words.getUint32(8, true), file.length);
    const jsonBytes = words.getUint32(12, true);
    assert.equal(jsonBytes % 4, 0);
    const json = JSON.parse(new TextDecoder().decode(file.subarray(20, 20 + jsonBytes)));
    const binBegin = 28 + jsonBytes;
    assert.equal(words.getUint32(20 + jsonBytes, true) % 4, 0);
    const view = (number: number) => {
        const { byteOffset, byteLength } = json.bufferViews[number];
        assert.equal(byteOffset % 4, 0);
        return file.slice(binBegin + byteOffset, binBegin + byteOffset + byteLength);
    };
    return { json, accessors: json.accessors, primitive: json.meshes[0].primitives[0], view };
}

/** What the validator has to say: errors and warnings must be none. */
async function complaints(file: Uint8Array, ignored: readonly string[] = []): Promise<string[]> {
    const report = await validator.validateBytes(file, { maxIssues: 100, ignoredIssues: ignored });
    return report.issues.messages.map((m: { code: string; pointer: string }) => `${m.code} ${m.pointer}`);
}

const budgets = [["--vertices", "42"], ["--vertices", "333"], ["--bytes", "9000"], ["--distortion", "20"], []];

testUnless(noProgram)("GLB: the validator finds nothing to say about plain files", async () => {
    for (const budget of budgets) await written(budget, async (file) => assert.deepEqual(await complaints(file), []));
});

testUnless(noProgram)("GLB: the validator accepts compressed files, whose extension it does not look into", async () => {
    for (const budget of budgets) {
        await written([...budget, "--draco"], async (file) =>
            assert.deepEqual(await complaints(file, ["UNSUPPORTED_EXTENSION", "UNUSED_OBJECT"]), []),
        );
    }
});

testUnless(noProgram)("GLB: the validator would tell of a fault", async () => {
    await written([], async (file, { json, primitive }) => {
        const [min] = json.accessors[primitive.attributes.POSITION].min;
        const text = new TextDecoder("latin1").decode(file);
        const at = text.indexOf(`"min":[${min}`) + '"min":[-'.length;
        file[at] = file[at] === 0x39 ? 0x38 : 0x39;
        assert.ok((await complaints(file)).some((text) => /MIN_MISMATCH/.test(text)));
    });
});

testUnless(noProgram)("GLB: indices are 32-bit and inside, bounds are those of the floats", async () => {
    await written(["--vertices", "333"], (_, { accessors, primitive, view }) => {
        const { mesh } = decodeLog(icosphere, draco, { vertices: 333 });
        const indices = accessors[primitive.indices];
        assert.deepEqual([indices.componentType, indices.count, indices.type], [5125, 3 * mesh.nFaces, "SCALAR"]);
        assert.deepEqual(new Uint32Array(view(indices.bufferView!).buffer), Uint32Array.from(mesh.triangles));
        const position = accessors[primitive.attributes.POSITION];
        const floats = new Float32Array(view(position.bufferView!).buffer);
        assert.deepEqual(floats, mesh.worldPositions());
        checkBounds(position, floats);
    });
});

function checkBounds({ min, max }: Accessor, positions: Float32Array): void {
    for (let axis = 0; axis < 3; ++axis) {
        const along = positions.filter((_, i) => i % 3 === axis);
        assert.equal(Math.fround(min![axis]), along.reduce((a, b) => Math.min(a, b)));
        assert.equal(Math.fround(max![axis]), along.reduce((a, b) => Math.max(a, b)));
    }
}

testUnless(noProgram)("GLB: the stock decoder finds what the accessors of a compressed file promise", async () => {
    await written(["--vertices", "333", "--draco"], (_, { accessors, primitive, view }) => {
        const { bufferView, attributes } = primitive.extensions[extension];
        const decoded = decodeGeometry(view(bufferView), attributes);
        assert.deepEqual(Object.keys(attributes), ["POSITION", "NORMAL", "COLOR_0"]);
        for (const name of Object.keys(attributes)) {
            const { componentType, count, type } = accessors[primitive.attributes[name]];
            assert.deepEqual([componentType, count, type], [5126, decoded.nVertices, "VEC3"]);
        }
        const indices = accessors[primitive.indices];
        assert.deepEqual([indices.componentType, indices.count], [5125, decoded.triangles.length]);
        checkBounds(accessors[primitive.attributes.POSITION], decoded.vectors.get("POSITION")!);
        checkSameSurface(decoded, decodeLog(icosphere, draco, { vertices: 333 }).mesh);
    });
});

/** Draco renumbers: each decoded vertex is looked up by its place. */
function checkSameSurface(decoded: DecodedGeometry, mesh: ProgressiveMesh): void {
    const [positions, colours] = [decoded.vectors.get("POSITION")!, decoded.vectors.get("COLOR_0")!];
    const expected = mesh.worldPositions();
    assert.equal(decoded.nVertices, mesh.nVertices);
    const seen = new Set<number>();
    for (let v = 0; v < decoded.nVertices; ++v) {
        const distance = (w: number) =>
            Math.max(...[0, 1, 2].map((axis) => Math.abs(positions[3 * v + axis] - expected[3 * w + axis])));
        const w = [...Array(mesh.nVertices).keys()].reduce((a, b) => (distance(a) <= distance(b) ? a : b));
        assert.ok(distance(w) < 2 / 65535);
        seen.add(w);
        for (let channel = 0; channel < 3; ++channel) {
            assert.ok(Math.abs(toSrgb(colours[3 * v + channel]) - mesh.colours[3 * w + channel]) < 0.6);
        }
        const normal = decoded.vectors.get("NORMAL")!.subarray(3 * v, 3 * v + 3);
        assert.ok(Math.abs(Math.hypot(...normal) - 1) < 1e-3);
    }
    assert.equal(seen.size, mesh.nVertices);
}

/** Linear light as an sRGB channel, 0 .. 255. */
function toSrgb(linear: number): number {
    return 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055);
}
