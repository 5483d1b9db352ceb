// What passes between dracoInWorker() and the worker that runs serveDraco().
import type { IntegerMesh } from "./integer-mesh.js";

export type DracoRequest =
    | { readonly type: "start"; readonly wasm: string | undefined }
    | {
          readonly type: "cloud";
          readonly id: number;
          readonly bytes: Uint8Array;
          readonly nPoints: number;
          readonly nComponents: readonly number[];
      }
    | {
          readonly type: "mesh";
          readonly id: number;
          readonly bytes: Uint8Array;
          readonly nVertices: number;
          readonly nFaces: number;
      };

export type DracoReply =
    | {
          readonly id: number;
          readonly answer: Int32Array[] | IntegerMesh;
          /** That the decoding took. */
          readonly milliseconds: number;
      }
    | { readonly id: number; readonly error: string; readonly isDecodeError: boolean };
