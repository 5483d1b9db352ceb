import { DecodeError } from "./decode-error.js";
import { flagAncillary, flagNewBatch, frameTypeName, FrameType, indexSequence } from "./frame.js";
import type { Frame } from "./frame.js";
import type { Header } from "./header.js";
import { maxLogVertices } from "./limits.js";

/**
 * The grammar of a log: which frame may follow which, with sequence numbers and vertex counts that fit together
 * (proto/FORMAT.md, "File" and "Frame"). Knows no payload.
 */
export class LogOrder {
    private readonly nBaseVertices: number;
    private stage: "index" | "base" | "body" | "ended";
    private nVertices = 0;
    private nextSequence = 0;
    private stateHash = 0;
    private batchStarted = false;
    /** The frame directly before, if it is base or refine. */
    private colourable: Frame | undefined;

    constructor(header: Header) {
        this.nBaseVertices = header.nBaseVertices;
        this.stage = header.sealed ? "index" : "base";
    }

    get ended(): boolean {
        return this.stage === "ended";
    }

    /**
     * Takes the next frame. @returns the vertices after it, 0 for an index frame
     * @throws DecodeError if it may not stand here; then nothing changes
     */
    accept(frame: Frame): number {
        this.check(frame);
        if (frame.type === FrameType.index) {
            this.stage = "base";
            return 0;
        }
        ++this.nextSequence;
        if (frame.type === FrameType.base) this.nVertices = this.nBaseVertices;
        if (frame.type === FrameType.refine) {
            this.nVertices += 3 * frame.nSplits;
            this.batchStarted = true;
        }
        const isGeometry = frame.type === FrameType.base || frame.type === FrameType.refine;
        if (isGeometry) this.stateHash = frame.hash;
        this.colourable = isGeometry ? frame : undefined;
        this.stage = frame.type === FrameType.end ? "ended" : "body";
        return this.nVertices;
    }

    private check(frame: Frame): void {
        const isIndex = frame.type === FrameType.index;
        const sequence = isIndex ? indexSequence : this.nextSequence;
        require(frame, !this.ended, "nothing behind the end frame");
        checkFlags(frame);
        require(frame, frame.sequence === sequence, `sequence number ${sequence}`);
        require(frame, isIndex === (this.stage === "index"), "an index exactly behind the header of a sealed log");
        require(
            frame,
            isIndex || (frame.type === FrameType.base) === (this.stage === "base"),
            "the base first, and once",
        );
        this.checkType(frame);
    }

    private checkType(frame: Frame): void {
        switch (frame.type) {
            case FrameType.index:
            case FrameType.base:
                require(frame, frame.nVerticesBefore === 0 && frame.nSplits === 0, "no vertices before and no splits");
                break;
            case FrameType.refine:
                require(
                    frame,
                    frame.nVerticesBefore === this.nVertices,
                    `${this.nVertices} vertices before, got ${frame.nVerticesBefore}`,
                );
                require(frame, this.nVertices + 3 * frame.nSplits <= maxLogVertices, "at most 2^24 vertices");
                require(
                    frame,
                    this.batchStarted || (frame.flags & flagNewBatch) !== 0,
                    "the first packet to start a batch",
                );
                break;
            case FrameType.colour:
                require(
                    frame,
                    this.colourable !== undefined &&
                        frame.nVerticesBefore === this.colourable.nVerticesBefore &&
                        frame.nSplits === this.colourable.nSplits,
                    "the base or refine frame that it colours directly before",
                );
                break;
            case FrameType.end:
                require(
                    frame,
                    frame.nVerticesBefore === this.nVertices &&
                        frame.nSplits === 0 &&
                        frame.payloadBytes === 0 &&
                        frame.hash === this.stateHash,
                    "the vertices and the hash of the log, and no payload",
                );
                break;
        }
    }
}

function checkFlags(frame: Frame): void {
    const ancillary = (frame.flags & flagAncillary) !== 0;
    if (frame.type > FrameType.colour) {
        require(frame, ancillary, "a known frame type, or one that geometry does not need");
        return;
    }
    require(frame, ancillary === (frame.type === FrameType.colour), "the ancillary flag on colour frames only");
    const others = frame.flags & ~flagAncillary;
    require(
        frame,
        others === 0 || (others === flagNewBatch && frame.type === FrameType.refine),
        "no flag that this version does not know",
    );
}

function require(frame: Frame, holds: boolean, expectation: string): void {
    if (holds) return;
    throw new DecodeError(
        `${frameTypeName(frame.type)} frame ${frame.sequence} at offset ${frame.begin}: expected ${expectation}`,
    );
}
