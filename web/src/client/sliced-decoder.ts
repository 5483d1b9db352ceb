import { ChangeMarks } from "./change-marks.js";
import type { Range } from "./change-marks.js";
import { decodeAhead } from "./decode-ahead.js";
import type { DracoService } from "./draco-service.js";
import type { DracoDecoder } from "./draco.js";
import { FrameType, hasIndexRow } from "./frame.js";
import type { Frame } from "./frame.js";
import { LogScanner } from "./log-scanner.js";
import type { Platform } from "./platform.js";
import { ProgressiveMesh } from "./progressive-mesh.js";
import type { MeshChanges } from "./progressive-mesh.js";
import { VertexNormals } from "./vertex-normals.js";

/** A frame that waits to be applied; decoded once its turn is near. */
interface Part {
    readonly frame: Frame;
    readonly payload: Uint8Array;
    draco?: Promise<DracoDecoder>;
}

/** What changed since it was last asked, for whoever keeps a copy. A few unchanged elements are among it. */
export interface ModelChanges extends MeshChanges {
    /** Vertices whose normal changed, new ones too. */
    readonly normals: readonly Range[];
}

export interface SlicedDecoderEvents {
    /** takeChanges() has something new; normals are up to date. */
    onChange(): void;
    /** The log is unsound from here on: the mesh stays as it is. */
    onError(error: unknown): void;
}

/** Milliseconds of work before other tasks get their turn: with normals and uploads well below a frame of 16 ms. */
const sliceMilliseconds = 4;
/** Between two calls of onChange(): normals are computed once for what changes several times in between. */
const publishMilliseconds = 30;
/** Vertices replayed between two looks at the clock: well below a millisecond, also before the engine has warmed up. */
const strideVertices = 24;
const normalsPerLook = 1000;
/** No log has more than this. */
const mostVerticesPerByte = 8;
/** Frames that Draco decodes ahead of the replay. */
const framesAhead = 6;
const mergedGap = 64;

/**
 * Decodes a log as bytes arrive, Draco in its service and the replay in slices, so that no task is long; up or down to
 * a vertex budget, and no payload before a budget needs it.
 *
 * Memory: at most 380 bytes a vertex of the finest mesh so far or that its budget will come to, and the bytes of the log that wait: 96 of mesh, normals
 * and marks in arrays of up to twice the size that they need, 79 in each kept state, which together have less than twice
 * its vertices, 25 of records to go back by.
 */
export class SlicedDecoder {
    readonly scanner = new LogScanner();
    private readonly draco: DracoService;
    private readonly platform: Pick<Platform, "now" | "pause">;
    private readonly events: SlicedDecoderEvents;
    private readonly parts: Part[] = [];
    private readonly vertexNormals = new VertexNormals();
    private readonly changed = { vertices: new ChangeMarks(), faces: new ChangeMarks(), colours: new ChangeMarks() };

    private meshRead: ProgressiveMesh | undefined;
    private maxVertices = Infinity;
    /** Vertices after the last frame that was applied. */
    private nVerticesApplied = 0;
    /** Vertices that there is room for. */
    private nVerticesReserved = 0;
    private replayTime = 0;
    /** When onChange() was called last. */
    private published = -Infinity;
    /** Whether something was collected since. */
    private unpublished = false;
    private failure: { readonly error: unknown } | undefined;
    private scanFailure: { readonly error: unknown } | undefined;
    private work: Promise<void> | undefined;
    private woken = false;
    private disposed = false;

    constructor(draco: DracoService, platform: Pick<Platform, "now" | "pause">, events: SlicedDecoderEvents) {
        this.draco = draco;
        this.platform = platform;
        this.events = events;
    }

    /** Undefined before the base has arrived; later always the same object. */
    get mesh(): ProgressiveMesh | undefined {
        return this.meshRead;
    }
    /** As VertexNormals.values. */
    get normals(): Int16Array {
        return this.vertexNormals.values;
    }
    /** Milliseconds that replay has taken so far. */
    get replayMilliseconds(): number {
        return this.replayTime;
    }
    /** What was wrong with the log, if anything. */
    get error(): unknown {
        return this.failure?.error;
    }

    push(bytes: Uint8Array): void {
        if (this.scanFailure) return;
        try {
            this.scanner.push(bytes);
            for (let next = this.scanner.next(); next; next = this.scanner.next()) {
                const { frame, payload } = next;
                if (hasIndexRow(frame.type)) this.parts.push({ frame, payload: payload.slice() });
            }
        } catch (error) {
            this.scanFailure = { error }; // told when the frames before have been replayed
        }
        this.wake();
    }

    /** Refines or coarsens to at most so many vertices, and 2 fewer at least if the frames that are there allow it. */
    setMaxVertices(maxVertices: number): void {
        this.maxVertices = maxVertices;
        this.wake();
    }

    /** Waits until what has arrived is replayed as far as the budget goes. Rejects if the log is unsound. */
    async settled(): Promise<void> {
        while (this.work) await this.work;
        if (this.failure) throw this.failure.error;
    }

    takeChanges(): ModelChanges {
        const mesh = this.meshRead;
        if (!mesh) return { vertices: [], faces: [], colours: [], normals: [] };
        this.collect(mesh);
        this.vertexNormals.updateNew(mesh);
        return {
            vertices: this.changed.vertices.take(mesh.nVertices, mergedGap),
            faces: this.changed.faces.take(mesh.nFaces, mergedGap),
            colours: this.changed.colours.take(mesh.nVertices, mergedGap),
            normals: this.vertexNormals.takeChanges(mesh.nVertices, mergedGap),
        };
    }

    /** Stops the work. The mesh stays as it is. */
    dispose(): void {
        this.disposed = true;
    }

    private wake(): void {
        if (this.failure) return;
        this.woken = true;
        this.work ??= this.runToEnd();
    }

    private async runToEnd(): Promise<void> {
        try {
            await this.platform.pause(); // several pushes and budgets of one task make one run
            while (this.woken) {
                this.woken = false;
                await this.run();
            }
        } catch (error) {
            this.failure = { error };
            if (!this.disposed) this.events.onError(error);
        } finally {
            this.work = undefined;
        }
    }

    private async run(): Promise<void> {
        let deadline = this.newDeadline();
        while (!this.disposed) {
            if (this.meshRead?.coarsen(this.maxVertices)) await this.publish();
            else if (this.wantsPart()) await this.takePart();
            else if (!this.replay(deadline)) break;
            if (this.platform.now() < deadline) continue;
            if (this.platform.now() - this.published >= publishMilliseconds) {
                await this.platform.pause();
                await this.publish();
            }
            await this.platform.pause();
            deadline = this.newDeadline();
        }
        await this.publish();
        if (this.scanFailure && !this.wantsPart()) throw this.scanFailure.error;
    }

    private newDeadline(): number {
        return this.platform.now() + sliceMilliseconds;
    }

    /** A frame is wanted while there are vertices to come; colours are wanted with the vertices they belong to. */
    private wantsPart(): boolean {
        const part = this.parts[0];
        if (!part) return false;
        return part.frame.type !== FrameType.refine || this.nVerticesApplied < this.maxVertices;
    }

    private async takePart(): Promise<void> {
        const header = this.scanner.header!;
        for (const part of this.parts.slice(0, framesAhead)) {
            part.draco ??= decodeAhead(part.frame, part.payload, header, this.draco);
            part.draco.catch(() => {}); // told when it is the part's turn
        }
        if (this.meshRead) await this.reserve(this.meshRead);
        const { frame, payload, draco } = this.parts[0];
        const decoder = await draco!;
        if (this.disposed) return;
        this.parts.shift();
        const begin = this.platform.now();
        if (frame.type === FrameType.base) {
            this.meshRead = new ProgressiveMesh(header, frame, payload, decoder, { keepsHistory: true });
            this.meshRead.setMaxVertices(0);
            this.nVerticesApplied = this.meshRead.nVertices;
        } else {
            this.meshRead!.apply(frame, payload, decoder);
            this.nVerticesApplied = frame.nSplits === 0 ? this.nVerticesApplied : frame.nVerticesBefore + 3 * frame.nSplits;
        }
        this.replayTime += this.platform.now() - begin;
    }

    /** Makes room for what is to come, as far as the bytes that are there make it credible; that takes a slice of its own. */
    private async reserve(mesh: ProgressiveMesh): Promise<void> {
        const { index, wholeBytes } = this.scanner;
        const expected = Math.min(this.maxVertices, index?.at(-1)?.nVertices ?? 0, mostVerticesPerByte * wholeBytes);
        if (expected <= Math.max(this.nVerticesReserved, mesh.nVertices)) return;
        this.nVerticesReserved = expected;
        await this.platform.pause();
        mesh.reserve(expected);
        this.vertexNormals.reserve(expected);
        await this.platform.pause();
    }

    /** Replays until the deadline, at least one stride. @returns whether there was anything to replay */
    private replay(deadline: number): boolean {
        const mesh = this.meshRead;
        if (!mesh) return false;
        const begin = this.platform.now();
        const nBefore = mesh.nVertices;
        let [n, now] = [nBefore, begin];
        do {
            n = mesh.nVertices;
            mesh.setMaxVertices(Math.min(n + strideVertices, this.maxVertices));
            now = this.platform.now();
        } while (mesh.nVertices > n && now < deadline);
        this.replayTime += now - begin;
        return mesh.nVertices > nBefore;
    }

    /** Notes what the mesh says has changed. */
    private collect(mesh: ProgressiveMesh): void {
        const changes = mesh.takeChanges(0);
        const { vertices, faces, colours } = this.changed;
        for (const range of changes.vertices) vertices.markRange(range);
        for (const range of changes.faces) faces.markRange(range);
        for (const range of changes.colours) colours.markRange(range);
        this.vertexNormals.note(mesh, changes);
        this.unpublished ||= changes.vertices.length + changes.faces.length + changes.colours.length > 0;
    }

    private async publish(): Promise<void> {
        const mesh = this.meshRead;
        if (!mesh) return;
        this.collect(mesh);
        if (!this.unpublished) return;
        for (let deadline = this.newDeadline(); !this.vertexNormals.update(mesh, normalsPerLook); ) {
            if (this.platform.now() < deadline) continue;
            await this.platform.pause();
            deadline = this.newDeadline();
        }
        await this.platform.pause(); // who listens may take as long again
        this.unpublished = false;
        this.published = this.platform.now();
        if (!this.disposed) this.events.onChange();
    }
}
