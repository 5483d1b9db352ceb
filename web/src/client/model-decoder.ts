import type { DracoDecoder } from "./draco.js";
import { FrameType } from "./frame.js";
import type { Frame } from "./frame.js";
import type { Header } from "./header.js";
import type { IndexRow } from "./log-index.js";
import { LogScanner } from "./log-scanner.js";
import type { ScannedFrame } from "./log-scanner.js";
import { ProgressiveMesh } from "./progressive-mesh.js";

/** Decodes a log frame by frame as bytes arrive, at once and in this thread. */
export class ModelDecoder {
    private readonly draco: DracoDecoder;
    private readonly scanner = new LogScanner();
    private maxVertices = Infinity;
    private failure: { readonly error: unknown } | undefined;
    private meshRead: ProgressiveMesh | undefined;
    private sequenceRead: number | undefined;

    constructor(draco: DracoDecoder) {
        this.draco = draco;
    }

    /** Undefined before it has arrived. */
    get header(): Header | undefined {
        return this.scanner.header;
    }
    /** Of a sealed log. */
    get index(): readonly IndexRow[] | undefined {
        return this.scanner.index;
    }
    /** Undefined before the base has arrived; later always the same object. */
    get mesh(): ProgressiveMesh | undefined {
        return this.meshRead;
    }
    /** Of the last whole frame: where a live stream goes on. */
    get lastSequence(): number | undefined {
        return this.sequenceRead;
    }
    /** Bytes of the log up to the end of the last whole header or frame. */
    get wholeBytes(): number {
        return this.scanner.wholeBytes;
    }
    /** Whether the end frame has arrived. */
    get ended(): boolean {
        return this.scanner.ended;
    }

    /**
     * Takes the next bytes of a log, of any length, and replays every frame that is whole by then, but no split beyond
     * the vertex budget.
     * @returns the frames that became whole
     * @throws DecodeError: the mesh stays as before the split or frame at fault, and every later call throws the same
     */
    feed(bytes: Uint8Array): Frame[] {
        return this.guarded(() => {
            this.scanner.push(bytes);
            const frames: Frame[] = [];
            for (let scanned = this.scanner.next(); scanned; scanned = this.scanner.next()) {
                this.take(scanned);
                frames.push(scanned.frame);
            }
            return frames;
        });
    }

    /** As ProgressiveMesh.setMaxVertices(); the base need not be there yet. @throws DecodeError as feed() */
    setMaxVertices(maxVertices: number): void {
        this.guarded(() => {
            this.maxVertices = maxVertices;
            this.meshRead?.setMaxVertices(maxVertices);
        });
    }

    /** Runs a step that may throw; what was thrown once is thrown again by every later step. */
    private guarded<T>(step: () => T): T {
        if (this.failure) throw this.failure.error;
        try {
            return step();
        } catch (error) {
            this.failure = { error };
            throw error;
        }
    }

    private take({ frame, payload }: ScannedFrame): void {
        if (frame.type === FrameType.index) return;
        if (frame.type === FrameType.base) {
            this.meshRead = new ProgressiveMesh(this.scanner.header!, frame, payload, this.draco);
            this.meshRead.setMaxVertices(this.maxVertices);
        } else {
            this.meshRead!.apply(frame, payload);
        }
        this.sequenceRead = frame.sequence;
    }
}
