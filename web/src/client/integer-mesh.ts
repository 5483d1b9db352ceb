/** A triangle mesh on integer positions. */
export interface IntegerMesh {
    /** x y z of each vertex. */
    readonly positions: Int32Array;
    /** Three vertices of each face. */
    readonly triangles: Int32Array;
}
