import assert from "node:assert/strict";

/** Which frames came over the page's WebSockets, by the log they belong to. */
export function framesOfSockets(page) {
    const frames = []; // {logId, sequence}
    page.on("websocket", (socket) => {
        let logId;
        socket.on("framereceived", ({ payload }) => {
            if (typeof payload === "string") {
                logId = JSON.parse(payload).log_id ?? logId;
                return;
            }
            for (let at = payload.readUInt16LE(0) === 0x4c50 ? 0 : 96; at + 28 <= payload.length; at += 28 + payload.readUInt32LE(at + 4)) {
                frames.push({ logId, sequence: payload.readUInt32LE(at + 8) });
            }
        });
    });
    return {
        assertEachOnce: () => {
            const keys = frames.map(({ logId, sequence }) => `${logId} ${sequence}`);
            assert.deepEqual(keys.filter((key, i) => keys.indexOf(key) !== i), [], "no frame came twice");
            const last = frames.filter(({ logId }) => logId === frames.at(-1).logId).map(({ sequence }) => sequence);
            assert.deepEqual(last, last.map((_, i) => i), "and none was left out");
        },
    };
}
