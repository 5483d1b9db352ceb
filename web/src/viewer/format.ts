// Numbers as a reader wants them.

const grouped = new Intl.NumberFormat("en");

/** 12,345 */
export function count(n: number): string {
    return grouped.format(Math.round(n));
}

/** 812 B, 40.5 KB, 1.23 MB (of 1000) */
export function bytes(n: number): string {
    if (n < 1000) return `${Math.round(n)} B`;
    const [scaled, unit] = n < 999_500 ? [n / 1e3, "KB"] : [n / 1e6, "MB"];
    return `${significant(scaled)} ${unit}`;
}

/** 0.84 ms, 12 ms, 1.24 s */
export function milliseconds(n: number): string {
    return n < 1000 ? `${significant(n)} ms` : `${significant(n / 1000)} s`;
}

/** 40 s, 3 min */
export function duration(seconds: number): string {
    return seconds < 90 ? `${Math.max(1, Math.round(seconds))} s` : `${Math.round(seconds / 60)} min`;
}

/** Three digits, more before the point if there are. */
export function significant(n: number): string {
    if (!Number.isFinite(n)) return "–";
    const digits = Math.max(0, 2 - Math.floor(Math.log10(Math.max(Math.abs(n), 1e-9))));
    return n.toLocaleString("en", { maximumFractionDigits: Math.min(digits, 3) });
}

/** 14:05 if it was today, else 23 Nov. */
export function dateOrTime(iso: string): string {
    const date = new Date(iso);
    const isToday = date.toDateString() === new Date().toDateString();
    return date.toLocaleString("en-GB", isToday ? { hour: "2-digit", minute: "2-digit" } : { day: "numeric", month: "short" });
}

/** A model's id, as short as still tells it apart. */
export function shortId(id: string): string {
    return id.slice(0, 6);
}

export function hex32(word: number): string {
    return word.toString(16).padStart(8, "0");
}
