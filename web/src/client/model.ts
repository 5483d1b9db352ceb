import { prefixFor } from "./budget.js";
import type { Budget } from "./budget.js";
import type { DracoService } from "./draco-service.js";
import type { Header } from "./header.js";
import { LiveConnection, defaultLiveOptions } from "./live-connection.js";
import type { LivePosition, LiveStatus } from "./live-connection.js";
import { LogDownload } from "./log-download.js";
import type { IndexRow } from "./log-index.js";
import { decodeSideIndex } from "./log-index.js";
import type { ModelEvent, ModelOptions } from "./model-options.js";
import type { ModelUrls } from "./model-urls.js";
import { fetchWith, newAbortController, platformWith } from "./platform.js";
import type { AbortControllerLike, Platform } from "./platform.js";
import type { ProgressiveMesh } from "./progressive-mesh.js";
import { serverError } from "./server-problem.js";
import { SlicedDecoder } from "./sliced-decoder.js";
import type { ModelChanges } from "./sliced-decoder.js";

/** Bytes of the first request: header, index and base of most models. */
export const firstRequestBytes = 8192;

/** A model of a server, as far as it has been fetched and replayed. Made by openModel() or followModel(). */
export class Model {
    private readonly urls: ModelUrls;
    private readonly draco: DracoService;
    private readonly options: ModelOptions;
    private readonly platform: Platform;
    private readonly abort: AbortControllerLike = newAbortController();
    private readonly download: LogDownload;
    private decoder: SlicedDecoder;
    /** The mesh of a log that was begun anew, until the new one has its base. */
    private meshBefore: ProgressiveMesh | undefined;
    private connection: LiveConnection | undefined;
    private liveLogId: string | undefined;
    private liveBytes = 0;
    private sideIndex: readonly IndexRow[] | undefined;
    private budget: Budget | undefined;
    private turn: Promise<void> = Promise.resolve();
    private replayBefore = 0;

    constructor(urls: ModelUrls, draco: DracoService, options: ModelOptions) {
        this.urls = urls;
        this.draco = draco;
        this.options = options;
        const { token, platform = {} } = options;
        this.platform = platformWith(token === undefined ? platform : { ...platform, fetch: fetchWith(token, platform) });
        this.decoder = this.newDecoder();
        this.download = new LogDownload(urls.log, this.platform.fetch, this.abort.signal, {
            bytes: (bytes) => this.take(bytes),
            begunAnew: () => this.beginAnew(),
        });
        options.signal?.addEventListener("abort", this.dispose);
        if (options.signal?.aborted) this.dispose();
    }

    /** Undefined before the base has arrived. */
    get mesh(): ProgressiveMesh | undefined {
        return this.decoder.mesh ?? this.meshBefore;
    }
    /** x y z 0 of each vertex as 16-bit fractions of 32767; may be longer than the mesh. */
    get normals(): Int16Array {
        return this.decoder.normals;
    }
    get header(): Header | undefined {
        return this.decoder.scanner.header;
    }
    /** One row a frame: of the whole log if its index has arrived, else of what has arrived, without distortions. */
    get rows(): readonly IndexRow[] {
        return this.decoder.scanner.index ?? this.sideIndex ?? this.decoder.scanner.rows;
    }
    /** Frames of the log that have arrived, index and end not counted. */
    get nFrames(): number {
        return this.decoder.scanner.rows.length;
    }
    /** Bytes of the log that have arrived, those of a preview too. */
    get nBytes(): number {
        return this.download.nBytes + this.liveBytes;
    }
    get nRequests(): number {
        return this.download.nRequests;
    }
    /** Offset of the base in the file, to tell the bytes of a prefix by its row. */
    get framesBegin(): number {
        const { scanner } = this.decoder;
        return scanner.wholeBytes - (scanner.rows.at(-1)?.end ?? 0);
    }
    get replayMilliseconds(): number {
        return this.replayBefore + this.decoder.replayMilliseconds;
    }
    get isSealed(): boolean {
        return this.header?.sealed ?? false;
    }
    /** Whether the log has arrived to its end. */
    get isWhole(): boolean {
        return this.decoder.scanner.ended;
    }

    /**
     * Goes to a budget, up or down: fetches what that needs by one request, unless it is there or live() brings it, and
     * replays. A later call takes over from an earlier one that still waits. With live(), a budget holds for what is
     * there; of what is to come only `vertices` is known.
     * @throws as openModel(): what was decoded stays, and the next call tries again
     */
    setBudget(budget: Budget): Promise<void> {
        this.budget = budget;
        if ("vertices" in budget) this.decoder.setMaxVertices(budget.vertices);
        this.turn = this.turn.catch(() => {}).then(() => this.meet(this.budget!));
        return this.turn;
    }

    /**
     * Follows the log over a WebSocket while it is made, from where it stands; a sealed log has nothing to follow.
     * Connects again by itself. Resolves when the server has sent all, or gave up.
     */
    async live(): Promise<void> {
        if (this.isSealed || this.connection || this.urls.live === undefined) return;
        const live = { ...defaultLiveOptions, ...this.options.live };
        this.connection = new LiveConnection(this.urls.live, this.platform, this.liveFollower(), live, this.options.token);
        try {
            await this.connection.run();
        } catch (error) {
            this.emit({ type: "error", error });
        } finally {
            this.connection = undefined;
        }
    }

    /** Connects again without waiting for its time. */
    retryNow(): void {
        this.connection?.retryNow();
    }

    /** Waits until what has arrived is replayed as far as the budget goes. @throws DecodeError */
    settled(): Promise<void> {
        return this.decoder.settled();
    }

    /** What changed in mesh and normals since the last call. */
    takeChanges(): ModelChanges {
        return this.decoder.takeChanges();
    }

    /** Fetches the rows with distortions of a log that has no index in it. */
    async loadIndex(): Promise<void> {
        if (this.decoder.scanner.index) return;
        const { fetch } = this.platform;
        const response = await fetch(this.urls.index, { headers: {}, signal: this.abort.signal });
        if (response.status === 404) return;
        if (response.status !== 200) throw await serverError(response, this.urls.index);
        const { logId, rows } = decodeSideIndex(new Uint8Array(await response.arrayBuffer()));
        if (logId === this.header?.logId) this.sideIndex = rows;
    }

    /** Stops every request, connection and replay. What is decoded stays readable. */
    readonly dispose = (): void => {
        this.options.signal?.removeEventListener("abort", this.dispose);
        this.abort.abort();
        this.connection?.close();
        this.decoder.dispose();
        void this.download.dispose();
    };

    /** What openModel() does. */
    async readFirst(): Promise<void> {
        const first = this.download.readTo(firstRequestBytes);
        this.download.askAhead(firstRequestBytes, this.options.bytesWanted ?? 0);
        await first;
        await this.decoder.settled();
        const { scanner } = this.decoder;
        const { budget } = this.options;
        if (budget) await this.setBudget(budget);
        else if (scanner.header && !scanner.rows.length) await this.fetchFor({ bytes: 0 }); // a base beyond 8 KB
        await this.decoder.settled();
    }

    private async meet(budget: Budget): Promise<void> {
        if (this.abort.signal.aborted || budget !== this.budget) return;
        if (!this.connection && !this.isWhole && this.liveBytes === 0) await this.fetchFor(budget);
        const rows = this.rows;
        const target = "vertices" in budget ? budget.vertices : verticesOf(budget, rows, this.framesBegin);
        if (budget === this.budget) this.decoder.setMaxVertices(target);
        await this.decoder.settled();
    }

    private async fetchFor(budget: Budget): Promise<void> {
        const { decoder } = this;
        if (!this.isSealed) await this.loadIndex();
        // An index that is longer than the first request.
        for (let n = 2; this.isSealed && !this.decoder.scanner.index; n *= 2) {
            const before = this.download.nBytes;
            await this.download.readTo(n * firstRequestBytes);
            if (this.download.nBytes === before) break; // cut; settled() says what is wrong, if anything
        }
        const rows = this.decoder.scanner.index ?? this.sideIndex;
        const end = rows ? prefixFor(budget, rows, this.framesBegin).nBytes : Infinity;
        await this.download.readTo(end);
        if (decoder !== this.decoder) await this.fetchFor(budget); // begun anew: another log, other rows
    }

    private newDecoder(): SlicedDecoder {
        let hasMesh = false;
        const decoder: SlicedDecoder = new SlicedDecoder(this.draco, this.platform, {
            onChange: () => {
                if (decoder !== this.decoder) return;
                if (!hasMesh) {
                    hasMesh = true;
                    this.meshBefore = undefined;
                    this.emit({ type: "mesh", mesh: decoder.mesh! });
                }
                this.emit({ type: "change" });
            },
            onError: (error) => decoder === this.decoder && this.emit({ type: "error", error }),
        });
        return decoder;
    }

    private beginAnew(): void {
        this.meshBefore = this.mesh;
        this.replayBefore += this.decoder.replayMilliseconds;
        this.decoder.dispose();
        this.decoder = this.newDecoder();
        this.sideIndex = undefined;
        if (this.budget && "vertices" in this.budget) this.decoder.setMaxVertices(this.budget.vertices);
    }

    private take(bytes: Uint8Array): void {
        this.decoder.push(bytes);
        this.emit({ type: "progress" });
    }

    private liveFollower() {
        return {
            position: (): LivePosition => {
                const { scanner } = this.decoder;
                scanner.dropPartialFrame();
                this.liveLogId ??= scanner.header?.logId.toString(16).padStart(16, "0");
                const next = scanner.lastSequence === undefined ? 0 : scanner.lastSequence + 1;
                return { logId: next > 0 ? this.liveLogId : undefined, next };
            },
            begin: (logId: string) => {
                if (this.header) this.beginAnew();
                this.liveLogId = logId;
            },
            frames: (bytes: Uint8Array) => {
                this.liveBytes += bytes.length;
                this.take(bytes);
            },
            status: (status: LiveStatus) => this.emit({ type: "live", status }),
        };
    }

    private emit(event: ModelEvent): void {
        if (!this.abort.signal.aborted) this.options.onEvent?.(event);
    }
}

/** Vertices after the prefix that answers a budget. */
function verticesOf(budget: Budget, rows: readonly IndexRow[], framesBegin: number): number {
    return rows[prefixFor(budget, rows, framesBegin).nRows - 1]?.nVertices ?? Infinity;
}
