import { Group, LineSegments, Mesh, Scene, Sphere, Vector2, Vector3 } from "three";
import type { Camera } from "three";

import type { Model, ProgressiveMesh } from "../client/index.js";
import { boundingSphere } from "./bounding-sphere.js";
import type { Rectangle, Size } from "./camera-view.js";
import { acquireDrawing, releaseDrawing } from "./drawing.js";
import type { Drawing } from "./drawing.js";
import { FrameRate } from "./frame-rate.js";
import type { Step } from "./heat-legend.js";
import { MorphGeometry } from "./morph-geometry.js";
import { OrbitCamera } from "./orbit-camera.js";
import type { Pose } from "./orbit-camera.js";
import { orbitByKeys } from "./orbit-keys.js";
import { PhotographCamera } from "./photograph-camera.js";
import type { PhotographView } from "./photograph-camera.js";
import type { Shading } from "./shading.js";
import { Transition } from "./transition.js";

/** Changes that wait for the last ones to be drawn: where drawing is slow, one upload for all; more would be a long task. */
const mostPending = 4;
/** A frame that takes longer is dear, as where no graphics card draws it; ms. */
const dearFrame = 35;
/** More of a model is coming if some came no longer ago, ms. */
const comingTime = 100;

/** Draws one model: its surface, as it refines, from any side or through a photograph's camera. */
export class ModelView {
    readonly canvas: HTMLCanvasElement;
    /** Is told when the point of view was changed by hand, and when a photograph's camera was left. */
    onMoved: () => void = () => {};
    onLeftPhotograph: () => void = () => {};
    /** Is told what the step did that the heat map shows; undefined if there was none. */
    onHeat: (step: Step | undefined) => void = () => {};

    private readonly drawing: Drawing = acquireDrawing();
    private readonly renderer = this.drawing.renderer;
    private readonly materials = this.drawing.materials;
    private readonly scene = new Scene();
    private readonly placed = new Group();
    private readonly morphing = new MorphGeometry();
    private readonly morph = new Transition();
    /** From the plain surface to its colours, once it has some. */
    private readonly colouring = new Transition();
    private isColoured = false;
    private readonly edges: LineSegments;
    private readonly orbit: OrbitCamera;
    private readonly releaseKeys: () => void;
    private readonly resize: ResizeObserver;
    private readonly frameRate = new FrameRate();

    private model: Model | undefined;
    private mesh: ProgressiveMesh | undefined;
    private bounds = new Sphere(new Vector3(), 1);
    private photograph: PhotographCamera | undefined;
    private photographPlace: Rectangle = { left: 0, top: 0, width: 1, height: 1 };
    private dirty = true;
    /** Changes that were told and not taken, and whether some were taken and not drawn. */
    private nPending = 0;
    private hasUndrawn = false;
    private lastTold = -Infinity;
    private heatStale = false;
    private showsHeat = false;
    private verticesDrawn = 0;
    private frame = 0;

    /** @throws Error if there is no WebGL */
    constructor(container: HTMLElement) {
        this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        this.canvas = this.renderer.domElement;
        this.canvas.tabIndex = 0;
        this.canvas.setAttribute("role", "img");
        this.canvas.setAttribute("aria-label", "The model. Arrow keys turn it, W A S D move it, + and − zoom, F fits it.");
        container.prepend(this.canvas);
        this.edges = new LineSegments(this.morphing.edgeGeometry, this.materials.edges);
        const surface = new Mesh(this.morphing.geometry, this.materials.surface);
        for (const object of [surface, this.edges]) object.frustumCulled = false;
        this.edges.visible = false;
        this.placed.add(surface, this.edges);
        this.scene.add(this.placed);
        this.orbit = this.newOrbit();
        this.releaseKeys = orbitByKeys(this.canvas, this.orbit);
        this.canvas.addEventListener("webglcontextrestored", this.redraw);
        this.resize = new ResizeObserver(() => this.fitCanvas(container));
        this.resize.observe(container);
        this.fitCanvas(container);
        this.frame = requestAnimationFrame(this.tick);
    }

    /** Frames a second, of the last half second. */
    get framesPerSecond(): number {
        return this.frameRate.perSecond;
    }

    /** Shows a model; take() says when it has something new. */
    setModel(model: Model): void {
        this.model = model;
    }

    /** Another mesh in place of what was there. */
    begin(mesh: ProgressiveMesh): void {
        this.mesh = mesh;
        this.morphing.clear();
        this.morph.end();
        this.nPending = 0;
        this.hasUndrawn = this.isColoured = false;
        const { origin, unit } = mesh.grid;
        this.placed.position.set(...origin);
        this.placed.scale.setScalar(unit);
        this.bounds = boundingSphere(mesh);
        this.orbit.setBounds(this.bounds);
        this.onHeat(undefined);
    }

    /** The model has changed: the next frames go there. */
    take(): void {
        ++this.nPending;
        this.lastTold = performance.now();
        if (!this.hasUndrawn || this.nPending >= mostPending) this.copyChanges();
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

    /** As OrbitCamera. */
    setOrientation(up: readonly [number, number, number], eye?: readonly [number, number, number]): void {
        this.orbit.setOrientation(up, eye);
    }
    setCovered(top: number, bottom: number): void {
        this.orbit.setCovered(top, bottom);
    }
    get pose(): Pose {
        return this.orbit.pose;
    }
    setPose(pose: Pose): void {
        this.orbit.setPose(pose);
    }
    fit(): void {
        this.orbit.fit();
    }

    /** Looks through a photograph's camera until the view is turned. @param place of the photograph, CSS pixels of the canvas */
    enterPhotograph(photograph: PhotographView, place: Rectangle): void {
        this.photograph = new PhotographCamera(photograph);
        this.placePhotograph(place);
    }
    placePhotograph(place: Rectangle): void {
        this.photographPlace = place;
        this.dirty = true;
    }

    leavePhotograph(): void {
        if (!this.photograph) return;
        const { eye, axis } = this.photograph;
        this.photograph = undefined;
        this.orbit.continueFrom(eye, axis);
        this.onLeftPhotograph();
    }

    /**
     * Draws what there is at once, without a morph, into the lower left corner of the canvas: for a picture.
     * @param size CSS pixels
     * @returns where it is in the canvas, its own pixels
     */
    drawPicture(size: Size): Rectangle {
        const { width, height } = size;
        const whole = this.renderer.getSize(new Vector2());
        this.orbit.fitInto(size);
        this.copyChanges();
        this.morph.end();
        this.colouring.end();
        this.renderer.setViewport(0, 0, width, height);
        this.draw(performance.now(), this.orbit.toCamera());
        this.renderer.setViewport(0, 0, whole.x, whole.y);
        const ratio = this.renderer.getPixelRatio();
        return { left: 0, top: this.canvas.height - ratio * height, width: ratio * width, height: ratio * height };
    }

    dispose(): void {
        this.model = undefined;
        cancelAnimationFrame(this.frame);
        this.resize.disconnect();
        this.releaseKeys();
        this.canvas.removeEventListener("webglcontextrestored", this.redraw);
        this.orbit.dispose();
        this.morphing.dispose();
        releaseDrawing(this.drawing);
    }

    private newOrbit(): OrbitCamera {
        const orbit = new OrbitCamera(this.canvas);
        orbit.onGrabbed = () => this.leavePhotograph();
        orbit.onMoved = () => this.onMoved();
        orbit.onChange = () => (this.dirty = true);
        return orbit;
    }

    private readonly redraw = (): void => {
        this.dirty = true;
    };

    private readonly tick = (now: number): void => {
        this.frame = requestAnimationFrame(this.tick);
        this.frameRate.count(now);
        this.orbit.update();
        if (this.nPending === 0 && this.heatStale && this.showsHeat && this.mesh) {
            this.heatStale = false;
            this.onHeat(this.morphing.measureHeat(this.mesh));
        }
        if (this.morph.isRunning(now) || this.colouring.isRunning(now)) this.dirty = true;
        if (!this.dirty || !this.mesh || this.sparesFrame(now)) return;
        this.dirty = false;
        this.draw(now, this.photograph?.at(this.photographPlace, this.canvasSize, this.bounds) ?? this.orbit.toCamera());
        this.hasUndrawn = false;
        this.markDrawn(this.morphing.vertexCount);
        if (this.nPending > 0) setTimeout(this.copyPending); // in a task of its own, not in that of a frame
    };

    /** A dear frame that would only show more of a morph, while the next change is near, is left out: it would delay that. */
    private sparesFrame(now: number): boolean {
        return !this.hasUndrawn && this.frameRate.interval > dearFrame && now - this.lastTold < comingTime;
    }

    private draw(now: number, camera: Camera): void {
        this.materials.setMorph(this.morph.at(now));
        this.materials.setColoured(this.isColoured ? this.colouring.at(now) : 0);
        this.renderer.render(this.scene, camera);
    }

    private readonly copyPending = (): void => {
        if (this.nPending > 0) this.copyChanges();
    };

    /** For whoever measures: when how many vertices were drawn first. */
    private markDrawn(vertices: number): void {
        if (vertices === this.verticesDrawn) return;
        this.verticesDrawn = vertices;
        performance.mark("drawn", { detail: vertices });
    }

    /** Takes what has changed, and begins a morph from where the last one has come to. */
    private copyChanges(): void {
        if (!this.model?.mesh || this.model.mesh !== this.mesh) return;
        this.nPending = 0;
        const now = performance.now();
        const isFirst = this.morphing.vertexCount === 0; // it has nothing to come from
        this.morphing.update(this.model, this.model.takeChanges(), this.morph.at(now));
        if (isFirst) this.morph.end();
        else this.morph.begin(now);
        if (this.mesh.hasColours && !this.isColoured) {
            this.isColoured = true;
            if (isFirst) this.colouring.end();
            else this.colouring.begin(now);
        }
        this.dirty = this.hasUndrawn = true;
    }

    private get canvasSize(): Size {
        return { width: this.canvas.clientWidth, height: this.canvas.clientHeight };
    }

    private fitCanvas(container: HTMLElement): void {
        const size = { width: Math.max(container.clientWidth, 1), height: Math.max(container.clientHeight, 1) };
        const had = this.renderer.getSize(new Vector2());
        if (had.x !== size.width || had.y !== size.height) this.renderer.setSize(size.width, size.height); // makes new buffers
        this.orbit.setSize(size);
    }
}
