// What a log may hold at most: proto/FORMAT.md, "Limits". A reader refuses more before it allocates.

export const maxLogVertices = 2 ** 24;
export const maxLogFaces = 2 ** 25;
export const maxPayloadBytes = 2 ** 26;
export const maxRefinePayloadBytes = 2 ** 20;
export const maxSplitsPerFrame = 2048;
/** No split or flip takes a vertex beyond this many edges, so that the work of one operation is bounded. */
export const maxValence = 64;
/** What a base payload can ask for: even a regular sphere takes more than a bit a vertex. */
export const maxBaseVerticesPerByte = 64;
export const maxBaseFacesPerByte = 128;
/** Of every integer that Draco gives back. */
export const maxDracoMagnitude = 2 ** 25;
/** Of a colour residual: no two chroma values differ by more. */
export const maxColourResidual = 511;
