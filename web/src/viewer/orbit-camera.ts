import { PerspectiveCamera, Sphere, Vector3 } from "three";
import type { Camera } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import type { Size } from "./camera-view.js";

/** Position and target, world units. */
export type Pose = readonly [number, number, number, number, number, number];

const fieldOfView = 32; // degrees, from top to bottom

/** A camera that turns about a model, by hand or by whoever calls, and has the model in view until it is told where to look. */
export class OrbitCamera {
    /** Is told before the view is changed by hand, and when that is done. */
    onGrabbed: () => void = () => {};
    onMoved: () => void = () => {};
    /** Is told that the view is another one. */
    onChange: () => void = () => {};

    private readonly canvas: HTMLElement;
    private readonly camera = new PerspectiveCamera(fieldOfView, 1, 0.1, 100);
    private readonly reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");
    private controls: OrbitControls;
    /** Of the model, once there is one. */
    private bounds = new Sphere(new Vector3(), 1);
    private hasModel = false;
    private covered = { top: 0, bottom: 0 };
    private firstEye: Vector3 | undefined;
    private poseWanted: Pose | undefined;
    /** The view was asked for or made by hand: it stays, also if the model or the canvas become others. */
    private hasPose = false;
    private isFadingOut = false;

    constructor(canvas: HTMLElement) {
        this.canvas = canvas;
        this.controls = this.newControls();
    }

    /** Another model; the view is that which was asked for, or has all of it. */
    setBounds(bounds: Sphere): void {
        this.bounds = bounds;
        this.hasModel = true;
        this.controls.minDistance = 0.05 * bounds.radius;
        this.controls.maxDistance = 20 * bounds.radius;
        if (!this.hasPose) this.applyPose();
    }

    /** @param up unit vector @param eye where to look from first, world units; undefined for a view from above */
    setOrientation(up: readonly [number, number, number], eye?: readonly [number, number, number]): void {
        this.camera.up.set(...up);
        // OrbitControls looks at "up" when it is made.
        const { target } = this.controls;
        this.controls.dispose();
        this.controls = this.newControls();
        this.controls.target.copy(target);
        if (eye) this.firstEye = new Vector3(...eye);
        if (!this.hasPose && this.hasModel) this.applyPose();
    }

    /** @param size of what is drawn, any unit */
    setSize({ width, height }: Size): void {
        const aspectBefore = this.camera.aspect;
        this.camera.aspect = width / height;
        this.offset();
        this.camera.updateProjectionMatrix();
        if (!this.hasPose && this.hasModel && aspectBefore !== this.camera.aspect) this.fitFromHere();
        this.onChange();
    }

    /** Leaves room for what lies over the upper and lower ends of the canvas, CSS pixels. */
    setCovered(top: number, bottom: number): void {
        if (top === this.covered.top && bottom === this.covered.bottom) return;
        this.covered = { top, bottom };
        this.offset();
        if (!this.hasPose && this.hasModel) this.fitFromHere();
    }

    get pose(): Pose {
        const [p, t] = [this.camera.position, this.controls.target];
        return [p.x, p.y, p.z, t.x, t.y, t.z];
    }
    setPose(pose: Pose): void {
        this.poseWanted = pose;
        if (this.hasModel) this.applyPose();
    }

    /** The whole model in view, from the side that it is seen from. */
    fit(): void {
        this.grab();
        this.hasPose = false;
        this.poseWanted = undefined;
        const direction = this.direction();
        this.controls.target.copy(this.bounds.center);
        this.moveTo(this.bounds.center.clone().addScaledVector(direction, this.fitDistance()));
        this.onMoved();
    }

    /** The whole model in a picture of this shape, without a word to anybody. */
    fitInto({ width, height }: Size): void {
        this.camera.aspect = width / height;
        this.fitFromHere();
    }

    /** Goes on from another camera's place, about the point of its axis that is nearest to the model. */
    continueFrom(eye: Vector3, axis: Vector3): void {
        const along = Math.max(axis.dot(this.bounds.center.clone().sub(eye)), 0.1 * this.bounds.radius);
        this.hasPose = true;
        this.controls.target.copy(eye).addScaledVector(axis, along);
        this.moveTo(eye);
    }

    /** @param sideways, upwards radians */
    turn(sideways: number, upwards: number): void {
        this.grab();
        const { up } = this.camera;
        const offset = this.camera.position.clone().sub(this.controls.target);
        const right = new Vector3().crossVectors(up, offset).normalize();
        const elevation = Math.asin(Math.min(Math.max(offset.clone().normalize().dot(up), -1), 1));
        const rise = Math.min(Math.max(elevation + upwards, -1.5), 1.5) - elevation;
        offset.applyAxisAngle(right, -rise).applyAxisAngle(up, -sideways);
        this.moveTo(offset.add(this.controls.target));
        this.onMoved();
    }

    /** Moves what is seen. @param sideways, upwards of the view's height, at the target */
    pan(sideways: number, upwards: number): void {
        this.grab();
        const { position, quaternion } = this.camera;
        const height = 2 * Math.tan((fieldOfView / 2) * (Math.PI / 180)) * position.distanceTo(this.controls.target);
        const step = new Vector3(-sideways * height, -upwards * height, 0).applyQuaternion(quaternion);
        this.controls.target.add(step);
        this.moveTo(position.clone().add(step));
        this.onMoved();
    }

    /** @param factor of the distance to the target */
    zoom(factor: number): void {
        this.grab();
        const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
        this.moveTo(offset.add(this.controls.target));
        this.onMoved();
    }

    /** Goes on with a movement that fades out; once a frame. */
    update(): void {
        const moves = this.controls.update();
        if (this.isFadingOut && !moves) this.onMoved();
        this.isFadingOut = moves;
    }

    /** The camera to draw with, its depth about the model. */
    toCamera(): Camera {
        const { center, radius } = this.bounds;
        const distance = this.camera.position.distanceTo(center);
        this.camera.near = Math.max(distance - 1.5 * radius, 0.005 * radius);
        this.camera.far = distance + 1.5 * radius;
        this.camera.updateProjectionMatrix();
        return this.camera;
    }

    dispose(): void {
        this.controls.dispose();
    }

    private newControls(): OrbitControls {
        const controls = new OrbitControls(this.camera, this.canvas);
        controls.enableDamping = !this.reducedMotion.matches;
        controls.dampingFactor = 0.12;
        controls.rotateSpeed = 0.9;
        controls.addEventListener("start", () => this.grab());
        controls.addEventListener("end", () => this.onMoved());
        controls.addEventListener("change", () => this.onChange());
        return controls;
    }

    private grab(): void {
        this.hasPose = true;
        this.onGrabbed();
    }

    private applyPose(): void {
        const { center } = this.bounds;
        if (this.poseWanted) {
            const [x, y, z, ...target] = this.poseWanted;
            this.controls.target.set(...target);
            this.hasPose = true;
            this.moveTo(new Vector3(x, y, z));
        } else {
            const toEye = this.firstEye?.clone().sub(center) ?? new Vector3(0.6, 0.45, 1);
            this.controls.target.copy(center);
            this.moveTo(center.clone().addScaledVector(toEye.normalize(), this.fitDistance()));
        }
    }

    /** As fit(), of a view that nobody has touched yet. */
    private fitFromHere(): void {
        this.moveTo(this.bounds.center.clone().addScaledVector(this.direction(), this.fitDistance()));
    }

    /** Unit vector from the target to the camera. */
    private direction(): Vector3 {
        return this.camera.position.clone().sub(this.controls.target).normalize();
    }

    private moveTo(position: Vector3): void {
        this.camera.position.copy(position);
        this.controls.update();
        this.onChange();
    }

    private fitDistance(): number {
        const { top, bottom } = this.covered;
        const tangent = Math.tan((fieldOfView / 2) * (Math.PI / 180));
        const vertical = tangent * Math.max(1 - (top + bottom) / this.canvas.clientHeight, 0.3);
        return (0.92 * this.bounds.radius) / Math.sin(Math.atan(Math.min(vertical, tangent * this.camera.aspect)));
    }

    /** The middle of the view is the middle of what is not covered. */
    private offset(): void {
        const { clientWidth, clientHeight } = this.canvas;
        const down = (this.covered.top - this.covered.bottom) / 2;
        if (down === 0) this.camera.clearViewOffset();
        else this.camera.setViewOffset(clientWidth, clientHeight, 0, -down, clientWidth, clientHeight);
        this.onChange();
    }
}
