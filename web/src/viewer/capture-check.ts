// What can be said of a capture before it is uploaded; the server looks at all of it again.
import type { Fault } from "./api.js";
import { namesInZip } from "./zip-file.js";
import type { NamedFile } from "./zip-file.js";

export interface CheckedCapture {
    /** What is to be sent, by names inside the capture; a zip as it is. */
    readonly files: readonly NamedFile[];
    readonly zip: Blob | undefined;
    readonly nImages: number | undefined;
    readonly nBytes: number;
    readonly faults: readonly Fault[];
    /** Files that no camera names: they are not sent. */
    readonly nLeftOut: number;
}

const camerasFile = "cameras.json";

export async function checkCapture(files: readonly NamedFile[]): Promise<CheckedCapture> {
    const [only] = files;
    if (files.length === 1 && only.name.toLowerCase().endsWith(".zip")) return checkZip(only);
    const folder = topFolder(files.map(({ name }) => name));
    if (folder === undefined) {
        const sentence = "is missing: expected the list of images and their cameras in it";
        return { files, zip: undefined, nImages: undefined, nBytes: 0, faults: [{ file: camerasFile, sentence }], nLeftOut: 0 };
    }
    const byName = new Map(files.map(({ name, file }) => [name.slice(folder.length), file]));
    return checkFolder(byName);
}

async function checkZip({ name, file }: NamedFile): Promise<CheckedCapture> {
    const names = await namesInZip(file);
    const faults: Fault[] = [];
    if (!names) faults.push({ file: name, sentence: "is no zip file, or was cut: its list of files is not there" });
    else if (topFolder(names) === undefined) faults.push({ file: name, sentence: `has no ${camerasFile} in it` });
    return { files: [], zip: file, nImages: undefined, nBytes: file.size, faults, nLeftOut: 0 };
}

/** The folder that has cameras.json in it, with a '/' behind it; undefined if there is none. */
function topFolder(names: readonly string[]): string | undefined {
    const found = names.filter((name) => name === camerasFile || name.endsWith(`/${camerasFile}`));
    const shortest = found.sort((a, b) => a.length - b.length)[0];
    return shortest?.slice(0, -camerasFile.length);
}

async function checkFolder(files: ReadonlyMap<string, Blob>): Promise<CheckedCapture> {
    const faults: Fault[] = [];
    const sent = new Map([[camerasFile, files.get(camerasFile)!]]);
    const entries = await entriesOf(files.get(camerasFile)!, faults);
    for (const [i, entry] of entries.entries()) {
        const { file, mask } = checkEntry(entry, i, faults);
        if (file === undefined) continue;
        await checkImage(file, files.get(file), entry, faults);
        if (files.has(file)) sent.set(file, files.get(file)!);
        const maskFile = mask ?? [file.replace(/^images\//, "masks/"), file.replace(/^images\//, "masks/").replace(/\.[^.]*$/, ".png")].find((name) => name !== file && files.has(name));
        if (maskFile === undefined) continue;
        if (files.has(maskFile)) sent.set(maskFile, files.get(maskFile)!);
        else faults.push({ file: maskFile, sentence: `is missing: ${camerasFile} names it as the mask of ${file}` });
    }
    if (faults.length === 0 && entries.length < 3) {
        faults.push({ file: camerasFile, sentence: `lists ${entries.length} images: expected at least 3` });
    }
    const list = [...sent].map(([name, file]) => ({ name, file }));
    return {
        files: list,
        zip: undefined,
        nImages: entries.length,
        nBytes: list.reduce((sum, { file }) => sum + file.size, 0),
        faults,
        nLeftOut: files.size - sent.size,
    };
}

type Entry = Readonly<Record<string, unknown>>;

async function entriesOf(cameras: Blob, faults: Fault[]): Promise<Entry[]> {
    let json: unknown;
    try {
        json = JSON.parse(await cameras.text());
    } catch (error) {
        faults.push({ file: camerasFile, sentence: `is no JSON: ${(error as Error).message}` });
        return [];
    }
    for (const key of ["images", "cameras", "views", "frames"]) {
        const list = (json as Entry | null)?.[key];
        if (Array.isArray(list)) return list as Entry[];
    }
    faults.push({ file: camerasFile, sentence: 'has no list "images"' });
    return [];
}

function checkEntry(entry: Entry, i: number, faults: Fault[]): { file: string | undefined; mask: string | undefined } {
    const where = typeof entry["file"] === "string" ? entry["file"] : `entry ${i}`;
    const expect = (holds: boolean, sentence: string) => {
        if (!holds) faults.push({ file: camerasFile, sentence: `${where}: ${sentence}` });
    };
    expect(typeof entry["file"] === "string", 'expected the name of an image in "file"');
    for (const name of ["K", "R"]) expect(isMatrix(entry[name]), `expected 3 rows of 3 numbers in "${name}"`);
    expect(isNumbers(entry["t"]), 'expected 3 numbers in "t"');
    const text = (value: unknown) => (typeof value === "string" ? value : undefined);
    return { file: text(entry["file"]), mask: text(entry["mask"]) };
}

function isMatrix(value: unknown): boolean {
    return Array.isArray(value) && value.length === 3 && value.every(isNumbers);
}

function isNumbers(value: unknown): boolean {
    return Array.isArray(value) && value.length === 3 && value.every((x) => typeof x === "number" && Number.isFinite(x));
}

async function checkImage(name: string, file: Blob | undefined, entry: Entry, faults: Fault[]): Promise<void> {
    if (!file) {
        faults.push({ file: name, sentence: `is missing: ${camerasFile} lists it` });
        return;
    }
    const head = new DataView(await file.slice(0, 24).arrayBuffer());
    const isPng = head.byteLength >= 24 && head.getUint32(0) === 0x89504e47;
    const isJpeg = head.byteLength >= 3 && head.getUint16(0) === 0xffd8;
    if (!isPng && !isJpeg) faults.push({ file: name, sentence: "is neither PNG nor JPEG" });
    if (!isPng) return;
    const [width, height] = [head.getUint32(16), head.getUint32(20)];
    const { width: toldWidth, height: toldHeight } = entry as { width?: unknown; height?: unknown };
    if ((typeof toldWidth === "number" && toldWidth !== width) || (typeof toldHeight === "number" && toldHeight !== height)) {
        faults.push({ file: name, sentence: `is ${width}×${height}: ${camerasFile} says ${toldWidth}×${toldHeight}` });
    }
}
