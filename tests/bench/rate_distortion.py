#!/usr/bin/env python3
"""What the prefixes of a log take, beside single meshes in Draco; prints JSON, and writes CSV and SVG too with --out.

usage: tests/bench/rate_distortion.py [--captures NAME...] [--meshes FILE...] [--out FOLDER] [--build build] [--work FOLDER]

Captures are reconstructed, meshes (closed surfaces) encoded with `anyrate encode-mesh`. At every budget of vertices:
bytes     of the geometry: header, index, base and refine frames with all their framing; colours are told apart. "bytes" is
          what a download takes, which ends at a frame; "bytes_share" counts of the last frame only the splits replayed, as
          if the frame ended there. Ratios are of the latter
single    the same decoded mesh, on the same grid, in single-rate Draco (edgebreaker, level 10)
error     mean distance both ways, in parts of the diagonal, to the given mesh, or to the whole log's mesh for a capture
same_error  the fewest bytes of any simplified mesh of that error: the reference simplified by quadrics to many counts, each
          on grids of 10, 11, 12 and 14 bits in single-rate Draco; straight lines between the counts in logarithmic scales
same_count  the simplified mesh of as many vertices, on the coarsest grid that costs it no more than a fifth of its error
ladder    all meshes of same_count up to here together: what a client takes that first loads the small ones
framing   frame headers, index, header and Draco's own headers, in parts of the geometry's bytes

Bytes depend on no machine; the seconds told are those of this one as it is.
"""
import csv
import json
import math
import pathlib

from measuring import find_capture, finish, in_work_folder, machine, note, parser, run, start
from svg_plot import Series, line_plot

GRIDS = (10, 11, 12, 14)
FINEST = GRIDS[-1]
FRAME_HEADER = 28
DRACO_HEADERS = {"base": 32, "refine": 62}  # bytes of a packet whose every symbol is 0

# (what, at which vertices, of every log or of given meshes alone) -> (target, limit)
TARGETS = [
    ("over_single", 5000, 0.65, 0.85),
    ("over_single", 10000, 0.55, 0.85),
    ("over_single", 20000, 0.50, 0.70),
    ("over_single", 40000, 0.50, 0.70),
    ("bits_per_vertex", 40000, 10.5, 13),
    ("over_ladder", 10000, 0.35, 0.5),
    ("over_ladder", 40000, 0.35, 0.5),
    ("over_same_error", 10000, 1.0, 1.15),
    ("over_same_error", 20000, 1.0, 1.15),
    ("over_same_error", 40000, 1.0, 1.15),
    ("framing", 40000, 0.06, 0.08),
]
FIRST_PICTURE = (8192, 12288)


def error_of(bench, mesh, reference):
    return json.loads(run(bench.anyrate, "compare", mesh, reference, "--json").stdout)["mean"]


class Log:
    """The frames of a model as `anyrate info` lists them."""

    def __init__(self, bench, model):
        told = json.loads(run(bench.anyrate, "info", model, "--json").stdout)
        self.model, self.grid_bits = model, told["grid_bits"]
        self.header_bytes = told["header_bytes"]
        self.frames = told["frames"]
        self.index_bytes = self.sum_of("index", self.frames)
        self.n_vertices = max(frame["vertices"] for frame in self.frames)

    @staticmethod
    def sum_of(kind, frames):
        return sum(frame["bytes"] for frame in frames if frame["type"] == kind)

    def prefix(self, n_vertices):
        """Bytes of the prefix that answers a budget of vertices."""
        geometry = [frame for frame in self.frames if frame["type"] in ("base", "refine")]
        last = next((i for i, frame in enumerate(geometry) if frame["vertices"] >= n_vertices - 2), len(geometry) - 1)
        taken, ahead = geometry[: last + 1], self.header_bytes + self.index_bytes
        n_bytes = ahead + sum(frame["bytes"] for frame in taken)
        share = n_bytes
        if last > 0:
            before, after = geometry[last - 1]["vertices"], geometry[last]["vertices"]
            unused = 1 - (min(n_vertices, after) - before) / (after - before)
            share -= unused * geometry[last]["bytes"]
        framing = ahead + sum(FRAME_HEADER + DRACO_HEADERS[frame["type"]] for frame in taken)
        colours = [frame for frame in self.frames if frame["type"] == "colour"]
        return {
            "bytes": n_bytes,
            "bytes_share": share,
            "colour_bytes": sum(frame["bytes"] for frame in colours if frame["vertices"] <= geometry[last]["vertices"]),
            "framing": framing / n_bytes,
        }

    def first_picture_bytes(self):
        return self.header_bytes + self.index_bytes + self.sum_of("base", self.frames)


def simplified(bench, reference, counts):
    """Bytes and errors of the reference simplified to each count, on each grid."""
    points = []
    for n in counts:
        simple = bench.simplify(reference, n)
        for bits in GRIDS:
            arrived = bench.work / f"{simple.stem}-{bits}.ply"
            told = bench.tool("single_rate", simple, "--bits", bits, "-o", arrived)
            points.append({**told, "bits": bits, "wanted": n, "error": error_of(bench, arrived, reference)})
            arrived.unlink()
    return points


def bytes_for_error(points, error):
    """The fewest bytes at which a simplified mesh has this error; None beyond what was measured."""
    found = []
    for bits in GRIDS:
        curve = sorted((p for p in points if p["bits"] == bits), key=lambda p: p["bytes"])
        for a, b in zip(curve, curve[1:]):
            if a["error"] >= error >= b["error"] and a["error"] > b["error"]:
                part = math.log(a["error"] / error) / math.log(a["error"] / b["error"])
                found.append(a["bytes"] * (b["bytes"] / a["bytes"]) ** part)
    return min(found, default=None)


def rung(points, n_vertices):
    """The simplified mesh of a count, on the coarsest grid that costs it no more than a fifth of its error."""
    grids = {p["bits"]: p for p in points if p["wanted"] == n_vertices}
    good = [bits for bits in GRIDS if grids and grids[bits]["error"] <= 1.2 * grids[FINEST]["error"]]
    return grids[good[0]] if good else None


def counts_between(budgets, most):
    """Budgets and a count in the middle of each two, as far as the reference can be simplified to them."""
    middles = [round(math.sqrt(a * b)) for a, b in zip(budgets, budgets[1:])]
    return [n for n in sorted({budgets[0] // 2, *budgets, *middles, round(1.4 * budgets[-1])}) if n < 0.9 * most]


def over(a, b):
    return None if b is None else a / b


def measure_log(bench, model, reference, budgets):
    log = Log(bench, model)
    reference = reference or bench.decode(model)
    n_reference = bench.tool("mesh_report", reference)["vertices"]
    base = next(frame for frame in log.frames if frame["type"] == "base")
    budgets = [n for n in budgets if base["vertices"] <= n <= log.n_vertices + 2]
    points = simplified(bench, reference, counts_between(budgets, n_reference))
    rows, ladder = [], 0
    for n in budgets:
        mesh = bench.decode(model, n)
        row = {"vertices": n, **log.prefix(n)}
        single = bench.tool("single_rate", mesh, "--model", model)["bytes"]
        error = error_of(bench, mesh, reference)
        row.update(bits_per_vertex=8 * row["bytes_share"] / n, single_bytes=single, over_single=row["bytes_share"] / single)
        is_reference = error < 1e-7  # a capture's whole log
        row.update(error=error, same_error_bytes=None if is_reference else bytes_for_error(points, error))
        row["over_same_error"] = over(row["bytes_share"], row["same_error_bytes"])
        step = rung(points, n)
        ladder = ladder + step["bytes"] if step and ladder is not None else None
        row.update(same_count_bytes=step and step["bytes"], same_count_error=step and step["error"], ladder_bytes=ladder)
        row["over_same_count"] = over(row["bytes_share"], row["same_count_bytes"])
        row["over_ladder"] = over(row["bytes_share"], ladder)
        rows.append(row)
    return {
        "grid_bits": log.grid_bits,
        "vertices": log.n_vertices,
        "file_bytes": model.stat().st_size,
        "colour_bytes": log.sum_of("colour", log.frames),
        "base_vertices": base["vertices"],
        "first_picture_bytes": log.first_picture_bytes(),
        "first_picture_colour_bytes": next((f["bytes"] for f in log.frames if f["type"] == "colour"), 0),
        "prefixes": rows,
        "simplified": points,
        "targets": judged(rows, log.first_picture_bytes()),
    }


def judged(rows, first_picture):
    target, limit = FIRST_PICTURE
    told = [{"what": "first_picture_bytes", "value": first_picture, "target": target, "limit": limit}]
    for what, n, target, limit in TARGETS:
        value = next((row[what] for row in rows if row["vertices"] == n), None)
        if value is not None:
            told.append({"what": what, "vertices": n, "value": value, "target": target, "limit": limit})
    for row in told:
        row["met"] = "target" if row["value"] <= row["target"] else "limit" if row["value"] <= row["limit"] else "no"
    return told


def encode(bench, mesh, name, options):
    model = bench.work / f"{name}.arl"
    sizes = ["--vertices", options.vertices]
    done = run(bench.anyrate, "encode-mesh", mesh, "-o", model, "--quiet", *sizes, *coarse_option(options))
    cost = {"wall_seconds": done.seconds, "cpu_seconds": done.cpu_seconds}
    return model, {**cost, "peak_memory_bytes": done.peak_memory_bytes}


def coarse_option(options):
    return [] if options.coarse is None else ["--coarse", options.coarse]


def plot(name, result, out):
    rows, points = result["prefixes"], result["simplified"]
    usable = [row for row in rows if row["error"] > 1e-7]
    steps = [row for row in usable if row["ladder_bytes"]]
    series = [
        Series("one log, its prefixes", [(r["bytes_share"], r["error"]) for r in usable]),
        Series("the same meshes, single-rate", [(r["single_bytes"], r["error"]) for r in usable]),
        Series("simplified, one mesh", envelope(points), dashed=True, dots=False),
        Series("simplified, the ladder so far", [(r["ladder_bytes"], r["same_count_error"]) for r in steps]),
    ]
    axes = {"log_x": True, "log_y": True}
    title, to = f"{name}: error against bytes of the geometry", "mean distance / diagonal"
    (out / f"rate_distortion_{name}.svg").write_text(line_plot(title, "bytes", to, series, **axes))
    with open(out / f"rate_distortion_{name}.csv", "w", newline="") as file:
        table = csv.DictWriter(file, fieldnames=list(rows[0]))
        table.writeheader()
        table.writerows(rows)


def envelope(points):
    """The simplified meshes that no other one beats in both bytes and error."""
    best, kept = math.inf, []
    for p in sorted(points, key=lambda p: (p["bytes"], p["error"])):
        if p["error"] < best:
            best = p["error"]
            kept.append((p["bytes"], p["error"]))
    return kept


def main():
    options = parser(__doc__, ["nefertiti", "pot", "bowl"])
    options.add_argument("--meshes", nargs="*", type=pathlib.Path, default=[], help="closed surfaces (.ply or .obj)")
    options.add_argument("--vertices", type=int, default=40000, help="of a mesh's log")
    options.add_argument("--capture-vertices", type=int, default=20000, help="of a capture's log")
    options.add_argument("--coarse", type=int, help="vertices of the coarse mesh; each command's own by default")
    options.add_argument("--budgets", nargs="+", type=int, default=[2500, 5000, 10000, 20000, 40000], help="where")
    options = options.parse_args()
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)

    def measure(bench):
        result = {"machine": machine(), "meshes": {}, "captures": {}}

        def add(group, name, model, cost, reference):
            told = {**cost, **measure_log(bench, model, reference, sorted(options.budgets))}
            result[group][name] = told
            missed = [f"{t['what']} at {t.get('vertices', 0)}" for t in told["targets"] if t["met"] != "target"]
            note(f"{name}: targets missed: {', '.join(missed) or 'none'}")
            if options.out and told["prefixes"]:
                plot(name, told, options.out)

        for n, file in enumerate(options.meshes):
            name = file.stem if file.stem != "gt" else f"{file.parent.name}_true"
            name = name if name not in result["meshes"] else f"{name}_{n}"
            add("meshes", name, *encode(bench, file, name, options), file)
        for wanted in options.captures:
            capture = find_capture(wanted)
            if capture is None:
                continue
            size = ["--vertices", options.capture_vertices, *coarse_option(options)]
            model, report = bench.reconstruct(capture, capture.name, *size)
            cost = {key: report[key] for key in ("wall_seconds", "cpu_seconds", "peak_memory_bytes")}
            add("captures", capture.name, model, cost, None)
        return result

    finish(in_work_folder(options, measure), options, "rate_distortion")


if __name__ == "__main__":
    start(main)
