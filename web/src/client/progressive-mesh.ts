import { decodeBase } from "./base-codec.js";
import type { Range } from "./change-marks.js";
import { decodeColour } from "./colour-codec.js";
import { ColourState } from "./colour-state.js";
import type { ColourSnapshot } from "./colour-state.js";
import { DecodeError } from "./decode-error.js";
import type { DracoDecoder } from "./draco.js";
import { flagNewBatch, FrameType } from "./frame.js";
import type { Frame } from "./frame.js";
import { prev } from "./halfedge.js";
import type { Grid, Header } from "./header.js";
import { decodeResiduals, taken } from "./packet.js";
import type { Packet, Waiting } from "./packet.js";
import { RefinableMesh } from "./refinable-mesh.js";
import type { RefinableMeshState, SplitRecords } from "./refinable-mesh.js";
import { decodeRefine, noPreviousFace } from "./refine-codec.js";
import { sumRing } from "./ring-sums.js";

/** What changed in a mesh, for whoever keeps a copy of it on a graphics card. A few unchanged elements are among it. */
export interface MeshChanges {
    /** Vertices whose position changed, new ones too. */
    readonly vertices: readonly Range[];
    /** Faces whose corners changed, new ones too. */
    readonly faces: readonly Range[];
    /** Vertices whose colour changed, new ones too. */
    readonly colours: readonly Range[];
}

/** A state of the mesh to which coarsen() can go back. */
interface Snapshot {
    readonly mesh: RefinableMeshState;
    readonly colours: ColourSnapshot;
    /** Where the log stood: splits and colours of the packet of this number. */
    readonly packet: number;
    readonly nReplayed: number;
    readonly nColoured: number;
}

export interface ProgressiveMeshOptions {
    /**
     * Keeps what coarsen() needs: the records of every split, and the mesh at the base and whenever it has doubled.
     * Takes about 105 bytes a vertex more.
     */
    readonly keepsHistory?: boolean;
}

/**
 * The mesh of a log, refined frame by frame as far as a vertex budget goes, and checked against the state hash of every
 * frame. At any time it is a closed manifold. Draws nothing and fetches nothing.
 */
export class ProgressiveMesh {
    readonly grid: Grid;
    private readonly draco: DracoDecoder;
    private readonly mesh: RefinableMesh;
    private readonly colourState: ColourState;
    private coloursSeen = false;
    private maxVertices = Infinity;
    /** Not wholly replayed, and the last one, whose colours may come; with a history all of them. */
    private readonly packets: Packet[] = [];
    /** The one that is being replayed. */
    private current = 0;
    /** By their sizes, ascending; none without a history. */
    private readonly snapshots: Snapshot[] = [];
    private readonly keepsHistory: boolean;
    private readonly ringOffset = new Float64Array(3);
    private previousFace = noPreviousFace;
    private changedColoursFrom = 0;

    /** @throws DecodeError if the payload of the base frame is not the closed manifold that header and hash promise */
    constructor(
        header: Header,
        baseFrame: Frame,
        payload: Uint8Array,
        draco: DracoDecoder,
        options: ProgressiveMeshOptions = {},
    ) {
        this.keepsHistory = options.keepsHistory ?? false;
        this.grid = header.grid;
        this.draco = draco;
        this.mesh = new RefinableMesh(decodeBase(payload, header, draco), header.grid.bits, header.rules);
        checkHash(baseFrame, "state", this.mesh.stateHash);
        this.colourState = new ColourState(header.colourSteps, header.nBaseVertices);
    }

    get nVertices(): number {
        return this.mesh.nVertices;
    }
    get nFaces(): number {
        return this.mesh.nFaces;
    }
    get stateHash(): number {
        return this.mesh.stateHash;
    }
    /** Whether the log has shown a colour frame so far. */
    get hasColours(): boolean {
        return this.coloursSeen;
    }

    // The arrays below are views of what the mesh works on: valid until the next change, not to be written.

    /** x y z of each vertex in grid units; see worldPositions(). */
    get positions(): Int32Array {
        return this.mesh.positions.subarray(0, 3 * this.nVertices);
    }
    /** Three vertices of each face, counter-clockwise from outside. */
    get triangles(): Uint32Array {
        return new Uint32Array(this.mesh.connectivity.corners.buffer, 0, 3 * this.nFaces);
    }
    /** r g b of each vertex; grey and its like while hasColours is false. */
    get colours(): Uint8Array {
        return this.colourState.colours.subarray(0, 3 * this.nVertices);
    }
    /** The two ends of the edge that each vertex was put on; of the base's vertices, twice the vertex itself. */
    get parents(): Int32Array {
        return this.mesh.parents.subarray(0, 2 * this.nVertices);
    }

    /** Makes room for so many vertices, where it is known that they will come: growing then copies nothing. */
    reserve(nVertices: number): void {
        this.mesh.reserve(nVertices);
        this.colourState.reserve(nVertices);
    }

    /** Calls back with every vertex that shares an edge with this one. */
    forEachNeighbour(vertex: number, visit: (neighbour: number) => void): void {
        const { corners, twins, outgoing } = this.mesh.connectivity;
        let spoke = outgoing[vertex];
        do {
            const back = prev(spoke);
            visit(corners[back]);
            spoke = twins[back];
        } while (spoke !== outgoing[vertex]);
    }

    /** Puts the sum of the normals of a vertex's faces, each as long as twice its area in grid units, into `sum`. */
    ringNormal(vertex: number, sum: Float64Array): void {
        sumRing(this.mesh.positions, this.mesh.connectivity, vertex, sum, this.ringOffset);
    }

    /**
     * Writes x y z of a range of vertices in world units to `into`, at three times their numbers.
     * @param into as long as the mesh, at least
     */
    writeWorldPositions(into: Float32Array | Float64Array, { first, count }: Range): void {
        const { positions } = this.mesh;
        const { origin, unit } = this.grid;
        for (let i = 3 * first; i < 3 * (first + count); i += 3) {
            into[i] = origin[0] + unit * positions[i];
            into[i + 1] = origin[1] + unit * positions[i + 1];
            into[i + 2] = origin[2] + unit * positions[i + 2];
        }
    }

    /** x y z of each vertex in world units. */
    worldPositions(): Float32Array {
        const world = new Float32Array(3 * this.nVertices);
        this.writeWorldPositions(world, { first: 0, count: this.nVertices });
        return world;
    }

    /**
     * Takes the next refine or colour frame, in the order that LogOrder accepts, and replays what the budget allows.
     * @param draco decodes this payload, when its turn comes; the decoder of the base if left out
     * @throws DecodeError: the mesh stays as before the split or frame at fault, and is to be given no more frames
     */
    apply(frame: Frame, payload: Uint8Array, draco = this.draco): void {
        if (frame.type === FrameType.refine) {
            const refine = { frame, payload: payload.slice(), draco };
            this.packets.push({ refine, nReplayed: 0, nColoured: 0 });
            if (this.keepsHistory && this.snapshots.length === 0) this.keep();
            this.replay();
        } else if (frame.type === FrameType.colour) {
            this.coloursSeen = true;
            if (frame.nSplits === 0) {
                this.colourBase(frame, payload, draco);
            } else {
                this.packets[this.packets.length - 1].colour = { frame, payload: payload.slice(), draco };
                this.replay();
            }
        }
    }

    /**
     * Sets the vertex budget and replays what it newly allows of the frames that are there. Splits already replayed
     * stay, so lowering it only holds back later ones. Infinity, the default, is all.
     * @throws DecodeError as apply()
     */
    setMaxVertices(maxVertices: number): void {
        this.maxVertices = maxVertices;
        this.replay();
    }

    /**
     * Goes back to the largest kept state of at most so many vertices, or else to the base, if the mesh has more; then
     * setMaxVertices() replays up to the budget again, from records that are decoded already. All counts as changed.
     * @returns whether the mesh has changed
     */
    coarsen(maxVertices: number): boolean {
        const fitting = this.snapshots.filter(({ mesh }) => mesh.connectivity.nVertices <= maxVertices);
        const state = fitting.at(-1) ?? this.snapshots[0];
        if (!state || this.nVertices <= Math.max(maxVertices, state.mesh.connectivity.nVertices)) return false;
        this.mesh.restore(state.mesh);
        this.colourState.restore(state.colours);
        for (const packet of this.packets.slice(state.packet)) packet.nReplayed = packet.nColoured = 0;
        this.current = state.packet;
        const packet = this.packets[this.current];
        packet.nReplayed = state.nReplayed;
        packet.nColoured = state.nColoured;
        this.maxVertices = this.nVertices;
        this.changedColoursFrom = 0;
        return true;
    }

    /**
     * What changed since the last call; at the first, all.
     * @param mergedGap ranges with no more than so many unchanged elements between them are told as one
     */
    takeChanges(mergedGap = 64): MeshChanges {
        const coloured = { first: this.changedColoursFrom, count: this.nVertices - this.changedColoursFrom };
        this.changedColoursFrom = this.nVertices;
        return {
            vertices: this.mesh.changedVertices.take(this.nVertices, mergedGap),
            faces: this.mesh.connectivity.changedFaces.take(this.nFaces, mergedGap),
            colours: coloured.count > 0 ? [coloured] : [],
        };
    }

    private colourBase(frame: Frame, payload: Uint8Array, draco: DracoDecoder): void {
        this.colourState.correctBase(this.mesh, decodeColour(payload, this.nVertices, draco));
        this.changedColoursFrom = 0;
        checkHash(frame, "colour", this.colourState.hash);
    }

    private replay(): void {
        while (this.current < this.packets.length) {
            const packet = this.packets[this.current];
            this.split(packet);
            this.colour(packet);
            if (this.isDueToKeep()) this.keep();
            if (packet.nReplayed < packet.refine.frame.nSplits || this.current + 1 === this.packets.length) return;
            if (this.keepsHistory) ++this.current;
            else this.packets.shift();
        }
    }

    private isDueToKeep(): boolean {
        const last = this.snapshots.at(-1);
        return last !== undefined && this.nVertices >= 2 * last.mesh.connectivity.nVertices;
    }

    private keep(): void {
        const { nReplayed, nColoured } = this.packets[this.current];
        const [mesh, colours] = [this.mesh.snapshot(), this.colourState.snapshot(this.nVertices)];
        this.snapshots.push({ mesh, colours, packet: this.current, nReplayed, nColoured });
    }

    private split(packet: Packet): void {
        const { frame } = packet.refine;
        if (packet.nReplayed === frame.nSplits) return;
        const records = (packet.refine.decoded ??= this.decodeRecords(packet.refine));
        const first = this.nVertices;
        try {
            while (packet.nReplayed < frame.nSplits && this.nVertices + 3 <= this.maxVertices) {
                this.mesh.apply(records, packet.nReplayed);
                ++packet.nReplayed;
            }
        } finally {
            this.colourState.predict(first, this.nVertices, this.mesh.parents);
        }
        if (packet.nReplayed === frame.nSplits) checkHash(frame, "state", this.stateHash);
    }

    private decodeRecords(waiting: Waiting<SplitRecords>): SplitRecords {
        const { frame } = waiting;
        const { payload, draco } = taken(waiting);
        const startsBatch = (frame.flags & flagNewBatch) !== 0;
        const previousFace = startsBatch ? noPreviousFace : this.previousFace;
        const records = decodeRefine(payload, frame.nSplits, previousFace, this.mesh.nFaces, draco);
        this.previousFace = records.faces[frame.nSplits - 1];
        return records;
    }

    /** Corrects the colours of what has been replayed. */
    private colour(packet: Packet): void {
        const { colour, nColoured, nReplayed } = packet;
        if (!colour || nColoured === 3 * nReplayed) return;
        const { frame } = colour;
        const residuals = (colour.decoded ??= decodeResiduals(colour));
        const first = frame.nVerticesBefore + nColoured;
        const end = frame.nVerticesBefore + 3 * nReplayed;
        this.colourState.predictAndCorrect(first, end, this.mesh.parents, residuals, nColoured);
        this.changedColoursFrom = Math.min(this.changedColoursFrom, first);
        packet.nColoured = 3 * nReplayed;
        if (nReplayed === frame.nSplits) checkHash(frame, "colour", this.colourState.hash);
    }
}

function checkHash(frame: Frame, what: string, computed: number): void {
    if (computed === frame.hash) return;
    const hex = (hash: number) => hash.toString(16).padStart(8, "0");
    throw new DecodeError(
        `frame ${frame.sequence}: expected the ${what} hash ${hex(frame.hash)} after it, got ${hex(computed)}; ` +
            "the decoder computes differently or the log is wrong",
    );
}
