import wasm from "draco3d/draco_decoder.wasm?url";

import { dracoInWorker } from "../client/index.js";
import type { DracoService } from "../client/index.js";

let service: DracoService | undefined;

/** Draco in its worker, one for every model of the page. */
export function draco(): DracoService {
    service ??= dracoInWorker(
        new Worker(new URL("../client/draco-worker.ts", import.meta.url), { type: "module" }) as never,
        { wasm: new URL(wasm, location.href).href },
    );
    return service;
}
