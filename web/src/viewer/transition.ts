const duration = 420; // ms
const reducedDuration = 1; // ms

/** How far what is drawn has gone from one state to the next; for those who want less motion, all the way at once. */
export class Transition {
    private readonly reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");
    private began = -Infinity;

    /** @param now ms, of performance.now() */
    begin(now: number): void {
        this.began = now;
    }

    /** Goes to its end. */
    end(): void {
        this.began = -Infinity;
    }

    /** From 0 to 1, quick at first, soft at the end. */
    at(now: number): number {
        const elapsed = (now - this.began) / this.duration;
        const t = Math.min(Math.max(elapsed, 0), 1); // a frame's time may be a little before the change that it shows
        return 1 - (1 - t) ** 3;
    }

    /** Whether frames have to be drawn for it, its last one too. */
    isRunning(now: number): boolean {
        return now - this.began < this.duration + 50;
    }

    private get duration(): number {
        return this.reducedMotion.matches ? reducedDuration : duration;
    }
}
