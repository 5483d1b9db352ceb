import assert from "node:assert/strict";

import { test } from "vitest";

import { Matrix4, Vector3, Vector4 } from "three";

import { cameraCentre, fittedRectangle, meanUp, projectionMatrix, viewMatrix } from "../../src/viewer/camera-view.js";

const [c, s] = [Math.cos(0.4), Math.sin(0.4)];
const camera = {
    K: [[500, 0.7, 310], [0, 480, 250], [0, 0, 1]],
    R: [[c, 0, s], [0, 1, 0], [-s, 0, c]],
    t: [0.1, -0.2, 5],
};
const image = { width: 640, height: 480 };

test("Photograph: it lies in the middle of the free place, as large as fits", () => {
    const place = { left: 10, top: 50, width: 320, height: 400 };
    assert.deepEqual(fittedRectangle(image, place), { left: 10, top: 130, width: 320, height: 240 });
    assert.deepEqual(fittedRectangle(image, { ...place, height: 120 }), { left: 90, top: 50, width: 160, height: 120 });
});

test("Photograph: a point of the world is drawn where the photograph shows it", () => {
    const canvas = { width: 900, height: 700 };
    const place = fittedRectangle(image, { left: 20, top: 60, width: 860, height: 500 });
    const pixelCentre = [0.5, 0.5];
    const view = new Matrix4().fromArray(viewMatrix(camera));
    const projection = new Matrix4().fromArray(projectionMatrix(camera, pixelCentre, image, place, canvas, 0.1, 100));
    for (const point of [[0, 0, 0], [0.7, -0.4, 0.3], [-0.5, 0.9, -0.8]]) {
        const [x, y, z] = camera.R.map((row, i) => row[0] * point[0] + row[1] * point[1] + row[2] * point[2] + camera.t[i]);
        const pixel = [(camera.K[0][0] * x + camera.K[0][1] * y) / z + camera.K[0][2], (camera.K[1][1] * y) / z + camera.K[1][2]];
        const scale = place.width / image.width;
        const expected = [place.left + scale * (pixel[0] - pixelCentre[0] + 0.5), place.top + scale * (pixel[1] - pixelCentre[1] + 0.5)];
        const clip = new Vector4(...(point as [number, number, number]), 1).applyMatrix4(view).applyMatrix4(projection);
        const drawn = [(0.5 + (0.5 * clip.x) / clip.w) * canvas.width, (0.5 - (0.5 * clip.y) / clip.w) * canvas.height];
        drawn.forEach((value, axis) => assert.ok(Math.abs(value - expected[axis]) < 1e-3, `${drawn} for ${expected}`));
        assert.ok(Math.abs(clip.z) < clip.w, "between the planes");
    }
});

test("Photograph: the camera's centre is seen at the origin of its axes, and up is against its y", () => {
    const centre = new Vector3(...cameraCentre(camera)).applyMatrix4(new Matrix4().fromArray(viewMatrix(camera)));
    assert.ok(centre.length() < 1e-12);
    assert.deepEqual(meanUp([camera, camera]).map((x) => x + 0), [0, -1, 0]);
});
