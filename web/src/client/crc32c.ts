const table = Int32Array.from({ length: 256 }, (_, byte) => {
    let remainder = byte;
    for (let bit = 0; bit < 8; ++bit) remainder = (remainder >>> 1) ^ (remainder & 1 ? 0x82f63b78 : 0);
    return remainder;
});

/** CRC-32C (Castagnoli) of byte strings one behind the other: crc32c(b, crc32c(a)) is that of a followed by b. */
export function crc32c(bytes: Uint8Array, crcBefore = 0): number {
    let crc = ~crcBefore;
    for (let i = 0; i < bytes.length; ++i) crc = (crc >>> 8) ^ table[(crc ^ bytes[i]) & 0xff];
    return ~crc >>> 0;
}
