import type { Budget } from "./budget.js";
import type { DracoService } from "./draco-service.js";
import type { LiveOptions, LiveStatus } from "./live-connection.js";
import type { Model } from "./model.js";
import type { AbortSignalLike, Platform } from "./platform.js";
import type { ProgressiveMesh } from "./progressive-mesh.js";

export type ModelEvent =
    /** There is a mesh, or another one in place of it: keep nothing of what was before. */
    | { readonly type: "mesh"; readonly mesh: ProgressiveMesh }
    /** takeChanges() has something new. */
    | { readonly type: "change" }
    /** Bytes have arrived. */
    | { readonly type: "progress" }
    | { readonly type: "live"; readonly status: LiveStatus }
    /** The log is unsound: the mesh stays as it is. */
    | { readonly type: "error"; readonly error: unknown };

export interface ModelOptions {
    /** Of Draco in a worker, see dracoInWorker(); in this thread if left out. The model does not dispose of it. */
    readonly draco?: DracoService;
    /** Goes on to this budget once the first request is answered; without it, openModel() stops there. */
    readonly budget?: Budget;
    /**
     * Bytes of the log that the budget is known to need, from elsewhere: openModel() asks for those behind the first
     * request at once, without waiting for its answer. Too few only cost another request.
     */
    readonly bytesWanted?: number;
    /** Bearer token, where the server wants one for reading. */
    readonly token?: string;
    /** Disposes of the model. */
    readonly signal?: AbortSignalLike;
    /** What the engine lacks, or tests replace. */
    readonly platform?: Partial<Platform>;
    readonly live?: Partial<LiveOptions>;
    readonly onEvent?: (event: ModelEvent) => void;
    /** Is given the model before its first bytes arrive, for whoever shows it while it is opened. */
    readonly onModel?: (model: Model) => void;
}
