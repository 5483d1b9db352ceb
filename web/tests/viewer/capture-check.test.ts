import assert from "node:assert/strict";

import { test } from "vitest";

import { checkCapture } from "../../src/viewer/capture-check.js";
import { namesInZip, zipOf } from "../../src/viewer/zip-file.js";
import type { NamedFile } from "../../src/viewer/zip-file.js";

/** The head of one; the rest is for the server to look at. */
function png(width: number, height: number): Blob {
    const view = new DataView(new ArrayBuffer(24));
    view.setUint32(0, 0x89504e47);
    view.setUint32(16, width);
    view.setUint32(20, height);
    return new Blob([view.buffer]);
}

const camera = { K: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], R: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], t: [0, 0, 0], width: 64, height: 48 };
const names = ["images/0.png", "images/1.png", "images/2.png"];

function capture(entries: readonly object[], images = names, folder = "scan/"): NamedFile[] {
    const json = { name: `${folder}cameras.json`, file: new Blob([JSON.stringify({ images: entries })]) };
    return [json, ...images.map((name) => ({ name: folder + name, file: png(64, 48) }))];
}

const sound = names.map((file) => ({ file, ...camera }));
const faultsOf = async (files: NamedFile[]) => (await checkCapture(files)).faults.map(({ file, sentence }) => `${file} ${sentence}`);

test("Capture: a sound one is sent by its names inside the folder, masks too, and what no camera names stays", async () => {
    const files = capture(sound, [...names, "masks/0.png", "notes.txt"]);
    const { faults, files: sent, nImages, nLeftOut } = await checkCapture(files);
    assert.deepEqual(faults, []);
    assert.deepEqual(sent.map(({ name }) => name).sort(), ["cameras.json", ...names, "masks/0.png"].sort());
    assert.deepEqual([nImages, nLeftOut], [3, 1]);
});

test("Capture: what is wrong is said of the file that it is wrong with", async () => {
    assert.match((await faultsOf([{ name: "a.png", file: png(1, 1) }]))[0], /^cameras\.json is missing/);
    assert.deepEqual(await faultsOf(capture(sound, names.slice(1))), ["images/0.png is missing: cameras.json lists it"]);
    assert.deepEqual(await faultsOf(capture(sound.slice(1))), ["cameras.json lists 2 images: expected at least 3"]);
    assert.deepEqual(await faultsOf(capture([{ ...sound[0], t: [1, 2] }, ...sound.slice(1)])), [
        'cameras.json images/0.png: expected 3 numbers in "t"',
    ]);
    assert.deepEqual(await faultsOf(capture([{ ...sound[0], width: 65 }, ...sound.slice(1)])), [
        "images/0.png is 64×48: cameras.json says 65×48",
    ]);
    assert.deepEqual(await faultsOf(capture([{ ...sound[0], mask: "masks/x.png" }, ...sound.slice(1)])), [
        "masks/x.png is missing: cameras.json names it as the mask of images/0.png",
    ]);
    const text = capture(sound).map((file) => (file.name.endsWith("0.png") ? { ...file, file: new Blob(["no image"]) } : file));
    assert.deepEqual(await faultsOf(text), ["images/0.png is neither PNG nor JPEG"]);
    assert.match((await faultsOf([{ name: "cameras.json", file: new Blob(["{"]) }]))[0], /^cameras\.json is no JSON/);
});

test("Capture: a zip is one if its list of files says so", async () => {
    const files = capture(sound);
    const zip = await zipOf(files);
    assert.deepEqual(await namesInZip(zip), files.map(({ name }) => name));
    assert.deepEqual(await faultsOf([{ name: "scan.zip", file: zip }]), []);
    assert.match((await faultsOf([{ name: "scan.zip", file: zip.slice(0, zip.size - 30) }]))[0], /^scan\.zip is no zip file, or was cut/);
    assert.deepEqual(await faultsOf([{ name: "scan.zip", file: await zipOf(files.slice(1)) }]), ["scan.zip has no cameras.json in it"]);
});
