/** Bytes that are no sound log. The message says where, what was expected and, where it helps, what was found. */
export class DecodeError extends Error {
    override readonly name = "DecodeError";
}
