import { checkBaseSize } from "./base-codec.js";
import { colourComponents } from "./colour-codec.js";
import type { DracoService } from "./draco-service.js";
import type { DracoDecoder } from "./draco.js";
import { FrameType } from "./frame.js";
import type { Frame } from "./frame.js";
import type { Header } from "./header.js";
import { refineComponents } from "./refine-codec.js";

/**
 * Has a service decode the payload of a base, refine or colour frame.
 * @returns a decoder that has the answer to the one question about this payload
 */
export async function decodeAhead(
    frame: Frame,
    payload: Uint8Array,
    header: Header,
    service: DracoService,
): Promise<DracoDecoder> {
    if (frame.type === FrameType.base) {
        checkBaseSize(payload, header);
        const mesh = await service.decodeMesh(payload, header.nBaseVertices, header.nBaseFaces);
        return { decodeMesh: () => mesh, decodePointCloud: notAsked };
    }
    const components = frame.type === FrameType.refine ? refineComponents : colourComponents;
    const cloud = await service.decodePointCloud(payload, nPointsOf(frame, header), components);
    return { decodePointCloud: () => cloud, decodeMesh: notAsked };
}

function nPointsOf({ type, nSplits }: Frame, { nBaseVertices }: Header): number {
    if (type === FrameType.refine) return nSplits;
    return nSplits === 0 ? nBaseVertices : 3 * nSplits;
}

function notAsked(): never {
    throw new Error("this payload is of another kind");
}
