/** The array itself if it has room for n numbers, else a larger copy; numbers behind the old ones are 0. */
export function withRoomFor(n: number, array: Int32Array): Int32Array {
    if (n <= array.length) return array;
    const larger = new Int32Array(Math.max(n, 2 * array.length));
    larger.set(array);
    return larger;
}
