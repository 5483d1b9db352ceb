import {
    Camera,
    Group,
    LineSegments,
    Matrix4,
    Mesh,
    PerspectiveCamera,
    Scene,
    Vector2,
    Vector3,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import type { Model, ProgressiveMesh } from "../client/index.js";
import { cameraCentre, projectionMatrix, viewMatrix } from "./camera-view.js";
import type { PinholeCamera, Rectangle, Size } from "./camera-view.js";
import { acquireDrawing, releaseDrawing } from "./drawing.js";
import type { Drawing } from "./drawing.js";
import { MorphGeometry } from "./morph-geometry.js";
import type { Shading } from "./shading.js";

/** A photograph that is looked through. */
export interface PhotographView {
    readonly camera: PinholeCamera;
    readonly pixelCentre: readonly number[];
    readonly image: Size;
}

/** Position and target, world units. */
export type Pose = readonly [number, number, number, number, number, number];

const fieldOfView = 32; // degrees
const morphMilliseconds = 420;
/** Changes that wait for the last ones to be drawn: where drawing is slow, one upload for all; more would be a long task. */
const mostPending = 4;

/** Draws one model: its surface, as it refines, from any side or through a photograph's camera. */
export class ModelView {
    readonly canvas: HTMLCanvasElement;
    /** Is told when the point of view was changed by hand, and when a photograph's camera was left. */
    onMoved: () => void = () => {};
    onLeftPhotograph: () => void = () => {};

    private readonly drawing: Drawing = acquireDrawing();
    private readonly renderer = this.drawing.renderer;
    private readonly materials = this.drawing.materials;
    private readonly scene = new Scene();
    private readonly placed = new Group();
    private readonly camera = new PerspectiveCamera(fieldOfView, 1, 0.1, 100);
    private readonly throughPhotograph = new Camera();
    private readonly morphing = new MorphGeometry();
    private readonly edges: LineSegments;
    private controls: OrbitControls;
    private readonly resize: ResizeObserver;
    private readonly reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");

    private model: Model | undefined;
    private mesh: ProgressiveMesh | undefined;
    private photograph: PhotographView | undefined;
    private covered = { top: 0, bottom: 0 };
    private centre = new Vector3();
    private radius = 1;
    private firstEye: Vector3 | undefined;
    private poseWanted: Pose | undefined;
    private hasPose = false;
    private morphBegan = -Infinity;
    private dirty = true;
    /** Changes that were told and not taken. */
    private nPending = 0;
    private heatStale = false;
    private showsHeat = false;
    private verticesDrawn = 0;
    private frame = 0;
    private nTicks = 0;
    private ticksSince = performance.now();
    private rate = 0;

    /** @throws Error if there is no WebGL */
    constructor(container: HTMLElement) {
        this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        this.canvas = this.renderer.domElement;
        this.canvas.tabIndex = 0;
        this.canvas.setAttribute("role", "img");
        this.canvas.setAttribute("aria-label", "The model. Arrow keys turn it, + and − zoom, F fits it.");
        container.prepend(this.canvas);
        this.edges = new LineSegments(this.morphing.edgeGeometry, this.materials.edges);
        const surface = new Mesh(this.morphing.geometry, this.materials.surface);
        for (const object of [surface, this.edges]) object.frustumCulled = false;
        this.edges.visible = false;
        this.placed.add(surface, this.edges);
        this.scene.add(this.placed);
        this.throughPhotograph.matrixWorldAutoUpdate = false;
        this.controls = this.newControls();
        this.resize = new ResizeObserver(() => this.fitCanvas(container));
        this.resize.observe(container);
        this.fitCanvas(container);
        this.canvas.addEventListener("keydown", this.onKey);
        this.frame = requestAnimationFrame(this.tick);
    }

    /** Frames a second, of the last half second. */
    get framesPerSecond(): number {
        return this.rate;
    }

    /** Shows a model; take() says when it has something new. */
    setModel(model: Model): void {
        this.model = model;
    }

    /** Another mesh in place of what was there. */
    begin(mesh: ProgressiveMesh): void {
        this.mesh = mesh;
        this.morphing.clear();
        this.nPending = 0;
        const { origin, unit } = mesh.grid;
        this.placed.position.set(...origin);
        this.placed.scale.setScalar(unit);
        this.measure(mesh);
        if (!this.hasPose) this.applyPose();
        this.morphBegan = -Infinity;
    }

    /** The model has changed: the next frames go there. */
    take(): void {
        ++this.nPending;
        if (!this.dirty || this.nPending >= mostPending) this.upload(performance.now());
    }

    /** The next heat map is measured from the mesh as it is now. */
    beginStep(): void {
        if (this.mesh) this.morphing.beginStep(this.mesh);
    }
    endStep(): void {
        this.heatStale = true;
        this.dirty = true;
    }

    setShading(shading: Shading): void {
        this.showsHeat = shading === "heat";
        this.materials.setShading(shading);
        this.dirty = true;
    }

    setEdges(shown: boolean): void {
        this.edges.visible = shown;
        this.morphing.showEdges(shown);
        this.dirty = true;
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
        if (!this.hasPose && this.mesh) this.applyPose();
    }

    /** Leaves room for what lies over the upper and lower ends of the canvas, CSS pixels. */
    setCovered(top: number, bottom: number): void {
        if (top === this.covered.top && bottom === this.covered.bottom) return;
        this.covered = { top, bottom };
        this.offsetCamera();
        if (!this.hasPose && this.mesh) this.fitQuietly();
    }

    get pose(): Pose {
        const [p, t] = [this.camera.position, this.controls.target];
        return [p.x, p.y, p.z, t.x, t.y, t.z];
    }
    setPose(pose: Pose): void {
        this.poseWanted = pose;
        if (this.mesh) this.applyPose();
    }

    /** The whole model in view, from the side that it is seen from. */
    fit(): void {
        this.leavePhotograph();
        const direction = this.camera.position.clone().sub(this.controls.target).normalize();
        this.controls.target.copy(this.centre);
        this.camera.position.copy(this.centre).addScaledVector(direction, this.fitDistance());
        this.controls.update();
        this.dirty = true;
        this.onMoved();
    }

    /** Looks through a photograph's camera until the view is turned. */
    enterPhotograph(photograph: PhotographView): void {
        this.photograph = photograph;
        this.dirty = true;
    }

    leavePhotograph(): void {
        if (!this.photograph) return;
        const { camera } = this.photograph;
        // Goes on from where the photograph was taken, about the point of its axis that is nearest to the model.
        this.photograph = undefined;
        const eye = new Vector3(...cameraCentre(camera));
        const axis = new Vector3(...(camera.R[2] as [number, number, number]));
        const along = Math.max(axis.dot(this.centre.clone().sub(eye)), 0.1 * this.radius);
        this.camera.position.copy(eye);
        this.controls.target.copy(eye).addScaledVector(axis, along);
        this.controls.update();
        this.dirty = true;
        this.onLeftPhotograph();
    }

    /**
     * Draws what there is at once, without a morph, into the lower left corner of the canvas: for a picture.
     * @param size CSS pixels
     * @returns where it is in the canvas, its own pixels
     */
    drawPicture({ width, height }: Size): Rectangle {
        const whole = this.renderer.getSize(new Vector2());
        this.camera.aspect = width / height;
        this.fitQuietly();
        this.upload(-Infinity);
        this.materials.setMorph(1);
        this.renderer.setViewport(0, 0, width, height);
        this.renderer.render(this.scene, this.orbitCamera());
        this.renderer.setViewport(0, 0, whole.x, whole.y);
        const ratio = this.renderer.getPixelRatio();
        return { left: 0, top: this.canvas.height - ratio * height, width: ratio * width, height: ratio * height };
    }

    dispose(): void {
        cancelAnimationFrame(this.frame);
        this.resize.disconnect();
        this.controls.dispose();
        this.morphing.dispose();
        this.canvas.removeEventListener("keydown", this.onKey);
        releaseDrawing(this.drawing);
    }

    private newControls(): OrbitControls {
        const controls = new OrbitControls(this.camera, this.canvas);
        controls.enableDamping = !this.reducedMotion.matches;
        controls.dampingFactor = 0.12;
        controls.rotateSpeed = 0.9;
        controls.addEventListener("start", () => this.leavePhotograph());
        controls.addEventListener("end", () => this.onMoved());
        controls.addEventListener("change", () => (this.dirty = true));
        return controls;
    }

    private readonly tick = (now: number): void => {
        this.frame = requestAnimationFrame(this.tick);
        this.count(now);
        this.controls.update();
        if (this.nPending > 0) {
            this.upload(now);
        } else if (this.heatStale && this.showsHeat && this.mesh) {
            this.heatStale = false;
            this.morphing.measureHeat(this.mesh);
        }
        if (now - this.morphBegan < this.morphDuration() + 50) this.dirty = true;
        if (!this.dirty || !this.mesh) return;
        this.dirty = false;
        this.materials.setMorph(ease(clamped((now - this.morphBegan) / this.morphDuration())));
        this.renderer.render(this.scene, this.photograph ? this.photographCamera(this.photograph) : this.orbitCamera());
        this.markDrawn(this.morphing.vertexCount);
    };

    /** For whoever measures: when how many vertices were drawn first. */
    private markDrawn(vertices: number): void {
        if (vertices === this.verticesDrawn) return;
        this.verticesDrawn = vertices;
        performance.mark("drawn", { detail: vertices });
    }

    /** Takes what has changed, and begins a morph from where the last one has come to. */
    private upload(now: number): void {
        if (!this.model?.mesh || this.model.mesh !== this.mesh) return;
        this.nPending = 0;
        const morphed = (now - this.morphBegan) / this.morphDuration();
        const isFirst = this.morphing.vertexCount === 0; // it has nothing to come from
        this.morphing.update(this.model, this.model.takeChanges(), ease(clamped(morphed)));
        this.morphBegan = isFirst ? -Infinity : now;
        this.dirty = true;
    }

    private morphDuration(): number {
        return this.reducedMotion.matches ? 1 : morphMilliseconds;
    }

    private count(now: number): void {
        ++this.nTicks;
        if (now - this.ticksSince < 500) return;
        this.rate = (1000 * this.nTicks) / (now - this.ticksSince);
        this.nTicks = 0;
        this.ticksSince = now;
    }

    /** Bounds of the mesh, world units. */
    private measure(mesh: ProgressiveMesh): void {
        const { origin, unit } = mesh.grid;
        const [low, high] = [new Vector3().setScalar(Infinity), new Vector3().setScalar(-Infinity)];
        const { positions } = mesh;
        const point = new Vector3();
        for (let i = 0; i < positions.length; i += 3) {
            point.set(positions[i], positions[i + 1], positions[i + 2]);
            low.min(point);
            high.max(point);
        }
        this.centre = low.clone().add(high).multiplyScalar(0.5 * unit).add(new Vector3(...origin));
        this.radius = 0.5 * unit * high.distanceTo(low);
    }

    private fitDistance(): number {
        const { top, bottom } = this.covered;
        const tangent = Math.tan((fieldOfView / 2) * (Math.PI / 180));
        const vertical = tangent * Math.max(1 - (top + bottom) / this.canvas.clientHeight, 0.3);
        return (0.92 * this.radius) / Math.sin(Math.atan(Math.min(vertical, tangent * this.camera.aspect)));
    }

    private applyPose(): void {
        if (this.poseWanted) {
            const [x, y, z, tx, ty, tz] = this.poseWanted;
            this.camera.position.set(x, y, z);
            this.controls.target.set(tx, ty, tz);
            this.hasPose = true;
        } else {
            const toEye = this.firstEye?.clone().sub(this.centre) ?? new Vector3(0.6, 0.45, 1);
            this.controls.target.copy(this.centre);
            this.camera.position.copy(this.centre).addScaledVector(toEye.normalize(), this.fitDistance());
        }
        this.controls.minDistance = 0.05 * this.radius;
        this.controls.maxDistance = 20 * this.radius;
        this.controls.update();
        this.dirty = true;
    }

    private orbitCamera(): Camera {
        const distance = this.camera.position.distanceTo(this.centre);
        this.camera.near = Math.max(distance - 1.5 * this.radius, 0.005 * this.radius);
        this.camera.far = distance + 1.5 * this.radius;
        this.camera.updateProjectionMatrix();
        return this.camera;
    }

    private photographCamera({ camera, pixelCentre, image }: PhotographView): Camera {
        const seen = this.throughPhotograph;
        const distance = new Vector3(...cameraCentre(camera)).distanceTo(this.centre);
        const near = Math.max(distance - 2 * this.radius, 0.01 * this.radius);
        const canvas = { width: this.canvas.clientWidth, height: this.canvas.clientHeight };
        seen.matrixWorldInverse.fromArray(viewMatrix(camera));
        seen.matrixWorld.copy(seen.matrixWorldInverse).invert();
        seen.projectionMatrix.fromArray(
            projectionMatrix(camera, pixelCentre, image, canvas, near, distance + 2 * this.radius),
        );
        seen.projectionMatrixInverse = new Matrix4().copy(seen.projectionMatrix).invert();
        return seen;
    }

    private fitCanvas(container: HTMLElement): void {
        const [width, height] = [Math.max(container.clientWidth, 1), Math.max(container.clientHeight, 1)];
        const had = this.renderer.getSize(new Vector2());
        if (had.x !== width || had.y !== height) this.renderer.setSize(width, height); // makes new buffers
        const hadAspect = this.camera.aspect;
        this.camera.aspect = width / height;
        this.offsetCamera();
        this.camera.updateProjectionMatrix();
        if (!this.hasPose && this.mesh && hadAspect !== this.camera.aspect) this.fitQuietly();
        this.dirty = true;
    }

    /** The middle of the view is the middle of what is not covered. */
    private offsetCamera(): void {
        const { clientWidth, clientHeight } = this.canvas;
        const down = (this.covered.top - this.covered.bottom) / 2;
        if (down === 0) this.camera.clearViewOffset();
        else this.camera.setViewOffset(clientWidth, clientHeight, 0, -down, clientWidth, clientHeight);
        this.dirty = true;
    }

    /** As fit(), of a view that nobody has touched yet. */
    private fitQuietly(): void {
        const direction = this.camera.position.clone().sub(this.controls.target).normalize();
        this.camera.position.copy(this.centre).addScaledVector(direction, this.fitDistance());
        this.controls.update();
    }

    private readonly onKey = (event: KeyboardEvent): void => {
        const turn = event.shiftKey ? 0.3 : 0.1; // radians
        const action = {
            ArrowLeft: () => this.turn(turn, 0),
            ArrowRight: () => this.turn(-turn, 0),
            ArrowUp: () => this.turn(0, turn),
            ArrowDown: () => this.turn(0, -turn),
            "+": () => this.zoom(0.88),
            "=": () => this.zoom(0.88),
            "-": () => this.zoom(1 / 0.88),
            f: () => this.fit(),
        }[event.key];
        if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        action();
    };

    private turn(sideways: number, upwards: number): void {
        this.leavePhotograph();
        const { up } = this.camera;
        const offset = this.camera.position.clone().sub(this.controls.target);
        const right = new Vector3().crossVectors(up, offset).normalize();
        const elevation = Math.asin(Math.min(Math.max(offset.clone().normalize().dot(up), -1), 1));
        const rise = Math.min(Math.max(elevation + upwards, -1.5), 1.5) - elevation;
        offset.applyAxisAngle(right, -rise).applyAxisAngle(up, -sideways);
        this.camera.position.copy(this.controls.target).add(offset);
        this.controls.update();
        this.dirty = true;
        this.onMoved();
    }

    private zoom(factor: number): void {
        this.leavePhotograph();
        const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
        this.camera.position.copy(this.controls.target).add(offset);
        this.controls.update();
        this.dirty = true;
        this.onMoved();
    }
}

/** To 0 .. 1: a frame's time may be a little before the change that it shows. */
function clamped(t: number): number {
    return Math.min(Math.max(t, 0), 1);
}

/** Quick at first, soft at the end. */
function ease(t: number): number {
    return 1 - (1 - t) ** 3;
}
