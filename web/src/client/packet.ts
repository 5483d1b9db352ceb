import { decodeColour } from "./colour-codec.js";
import type { ColourResiduals } from "./colour-codec.js";
import type { DracoDecoder } from "./draco.js";
import type { Frame } from "./frame.js";
import type { SplitRecords } from "./refinable-mesh.js";

/** A frame that waits for its turn; its payload is decoded only then, so that waiting takes no more than its bytes. */
export interface Waiting<Decoded> {
    readonly frame: Frame;
    /** Until it is decoded. */
    payload: Uint8Array | undefined;
    draco: DracoDecoder | undefined;
    decoded?: Decoded;
}

/** A refine frame that is being replayed, with its colours once they are there. */
export interface Packet {
    readonly refine: Waiting<SplitRecords>;
    nReplayed: number;
    colour?: Waiting<ColourResiduals>;
    nColoured: number;
}

/** The residuals of a colour frame of splits. */
export function decodeResiduals(waiting: Waiting<ColourResiduals>): ColourResiduals {
    const { payload, draco } = taken(waiting);
    return decodeColour(payload, 3 * waiting.frame.nSplits, draco);
}

/** The payload and its decoder, which are needed no longer once it is decoded. */
export function taken(waiting: Waiting<unknown>): { payload: Uint8Array; draco: DracoDecoder } {
    const { payload, draco } = waiting;
    waiting.payload = waiting.draco = undefined;
    return { payload: payload!, draco: draco! };
}
