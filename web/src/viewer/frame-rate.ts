const period = 500; // ms

/** Counts frames. */
export class FrameRate {
    private rate = 0;
    private nFrames = 0;
    private since = performance.now();
    private last = -Infinity;
    private lastInterval = 0;

    /** Frames a second, of the last half second. */
    get perSecond(): number {
        return this.rate;
    }

    /** Between the last two frames, ms. */
    get interval(): number {
        return this.lastInterval;
    }

    /** @param now ms, of performance.now() */
    count(now: number): void {
        this.lastInterval = now - this.last;
        this.last = now;
        ++this.nFrames;
        if (now - this.since < period) return;
        this.rate = (1000 * this.nFrames) / (now - this.since);
        this.nFrames = 0;
        this.since = now;
    }
}
