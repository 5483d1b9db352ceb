import { Camera, Matrix4, Vector3 } from "three";
import type { Sphere } from "three";

import { cameraCentre, projectionMatrix, viewMatrix } from "./camera-view.js";
import type { PinholeCamera, Rectangle, Size } from "./camera-view.js";

/** A photograph that is looked through. */
export interface PhotographView {
    readonly camera: PinholeCamera;
    readonly pixelCentre: readonly number[];
    readonly image: Size;
}

/** Sees a model as a photograph does. */
export class PhotographCamera {
    /** Where the photograph was taken, world units. */
    readonly eye: Vector3;
    /** Unit vector along which it looks. */
    readonly axis: Vector3;
    private readonly view: PhotographView;
    private readonly camera = new Camera();

    constructor(view: PhotographView) {
        this.view = view;
        this.eye = new Vector3(...cameraCentre(view.camera));
        this.axis = new Vector3(...(view.camera.R[2] as [number, number, number]));
        this.camera.matrixWorldAutoUpdate = false;
        this.camera.matrixWorldInverse.fromArray(viewMatrix(view.camera));
        this.camera.matrixWorld.copy(this.camera.matrixWorldInverse).invert();
    }

    /**
     * The camera to draw with, so that a pixel of the photograph is seen where it lies in its rectangle.
     * @param place, canvas CSS pixels
     * @param bounds of the model, which depth is to hold
     */
    at(place: Rectangle, canvas: Size, { center, radius }: Sphere): Camera {
        const { camera, pixelCentre, image } = this.view;
        const distance = this.eye.distanceTo(center);
        const near = Math.max(distance - 2 * radius, 0.01 * radius);
        this.camera.projectionMatrix.fromArray(projectionMatrix(camera, pixelCentre, image, place, canvas, near, distance + 2 * radius));
        this.camera.projectionMatrixInverse = new Matrix4().copy(this.camera.projectionMatrix).invert();
        return this.camera;
    }
}
