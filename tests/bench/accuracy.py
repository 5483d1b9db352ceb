#!/usr/bin/env python3
"""How near the surfaces come to the truth, what they cost, and the other route to them; prints one JSON object.

usage: tests/bench/accuracy.py [--captures NAME...] [--vertices N] [--out FOLDER] [--build build] [--work FOLDER]

For nefertiti, pot (36 views) and bowl: distances to the true surface where two cameras see it, in percent of its diagonal,
at 2,500, 5,000 and 10,000 vertices, beside the targets and the best figures of OpenMVS 2.3.0; topology, genus and
self-intersections; seconds of every stage, of preview and base, peak memory; how the cost grows from 10,000 to 20,000
vertices against 5,000 to 10,000; and how far the truth, simplified to 5,000 vertices, drifts if it is optimised.
For oxford_dinosaur: overlap of silhouettes and masks over all views.
The other route: the finest meshes (10,000 and 20,000) simplified to every smaller count by quadric error.
With --out a Markdown table is written there too. Timings are those of this machine as it is; run it on an idle one.
"""

from measuring import CAMERAS, evaluator, find_capture, finish, in_work_folder, machine, note, parser, start

# Means where seen, in percent of the diagonal: what is asked for, and the best of OpenMVS 2.3.0 at 2,500, 5,000, 10,000.
TARGETS = {"nefertiti": (0.030, 0.022, 0.018), "pot": (0.072, 0.048, 0.036), "bowl": (0.042, 0.033, 0.028)}
PEER = {"nefertiti": (0.0453, 0.0425, 0.0424), "pot": (0.0726, 0.0612, 0.0575), "bowl": (0.0495, 0.0364, None)}
TABLE_BUDGETS = (2500, 5000, 10000)
TRUTH_VERTICES = 5000


def in_percent(distances):
    return distances and {key: 100 * value for key, value in distances.items()}


def quality(bench, capture, mesh, cameras):
    told = {"seen_percent": in_percent(bench.seen(mesh, capture))}
    if cameras != "cameras.json" and evaluator() == "eval_mesh":
        told["seen_by_all_percent"] = in_percent(bench.seen(mesh, capture, cameras=cameras))
    told.update(bench.tool("mesh_report", mesh))
    return told


def seconds_to(curve, n_vertices):
    """When the curve reached a number of vertices, linear between its points."""
    for before, after in zip(curve, curve[1:]):
        if before["vertices"] <= n_vertices <= after["vertices"]:
            part = (n_vertices - before["vertices"]) / (after["vertices"] - before["vertices"])
            return before["seconds"] + part * (after["seconds"] - before["seconds"])
    return curve[-1]["seconds"]


def growth(curve, n_vertices):
    """Cost of doubling the vertices over the cost of the doubling before."""
    half, once, twice = (seconds_to(curve, n) for n in (n_vertices // 2, n_vertices, 2 * n_vertices))
    return (twice - once) / max(once - half, 1e-9)


def routes(bench, capture, model, finer, budgets):
    """Seen mean of the log's prefixes, and of both finest meshes simplified to the same counts.

    The longer log is one of its own, with a finer surface behind it: its mesh is held against its own prefixes, too."""
    logs = {str(max(budgets)): model, str(2 * max(budgets)): finer}
    finest = {name: bench.decode(log, int(name)) for name, log in logs.items()}
    rows = []
    for n in budgets:
        row = {"vertices": n, "prefix_percent": 100 * bench.seen(bench.decode(model, n), capture)["mean"]}
        for name, mesh in finest.items():
            if int(name) == n:
                continue
            simple = 100 * bench.seen(bench.simplify(mesh, n), capture)["mean"]
            row[f"simplified_from_{name}_percent"] = simple
            row[f"prefix_over_simplified_from_{name}"] = row["prefix_percent"] / simple
            own = 100 * bench.seen(bench.decode(logs[name], n), capture)["mean"]
            row[f"own_prefix_over_simplified_from_{name}"] = own / simple
        rows.append(row)
    return rows


def drift_of_truth(bench, capture, cameras):
    """Seen mean of the simplified truth before and after it is optimised in the images."""
    truth = bench.simplify(capture / "gt.ply", TRUTH_VERTICES)
    moved = bench.work / f"{capture.name}-truth-optimised.ply"
    psi = bench.tool("optimise_mesh", truth, capture, "-o", moved, "--cameras", cameras)
    return {
        "vertices": TRUTH_VERTICES,
        "before_percent": 100 * bench.seen(truth, capture)["mean"],
        "after_percent": 100 * bench.seen(moved, capture)["mean"],
        **psi,
    }


def measure_capture(bench, capture, options):
    cameras = CAMERAS.get(capture.name, "cameras.json")
    common = ["--cameras", cameras, "--coarse", options.coarse]
    model, report = bench.reconstruct(capture, capture.name, *common, "--vertices", options.vertices)
    result = {
        "cameras": cameras,
        "wall_seconds": report["wall_seconds"],
        "cpu_seconds": report["cpu_seconds"],
        "stage_seconds": report["seconds"],
        "preview_seconds": report["preview"]["seconds"],
        "base_seconds": report["curve"][0]["seconds"],
        "peak_memory_bytes": report["peak_memory_bytes"],
        "log_bytes": report["final"]["bytes"],
    }
    budgets = sorted({n for n in options.budgets if options.coarse <= n <= options.vertices} | {options.vertices})
    if not (capture / "gt.ply").exists():
        mesh = bench.decode(model, options.vertices)
        result["silhouettes"] = bench.tool("silhouette_iou", mesh, capture, "--cameras", cameras)
        result["at"] = {str(options.vertices): bench.tool("mesh_report", mesh)}
        return result
    result["at"] = {str(n): quality(bench, capture, bench.decode(model, n), cameras) for n in budgets}
    finer, fine_report = bench.reconstruct(capture, f"{capture.name}-finer", *common, "--vertices", 2 * options.vertices)
    result["growth"] = {
        "ratio": growth(fine_report["curve"], options.vertices),
        "wall_seconds": fine_report["wall_seconds"],
        "peak_memory_bytes": fine_report["peak_memory_bytes"],
    }
    result["other_route"] = routes(bench, capture, model, finer, budgets)
    result["truth_optimised"] = drift_of_truth(bench, capture, cameras)
    return result


def cell(value, digits=4):
    return "-" if value is None else f"{value:.{digits}f}"


def table(captures):
    """Markdown: the distances against targets and peer, then what the run cost."""
    lines = ["| capture | vertices | mean % | target | OpenMVS | p90 % | Hausdorff % | self-intersections | genus |"]
    lines.append("|" + "---|" * 9)
    for name, result in captures.items():
        for n, row in result["at"].items():
            place = TABLE_BUDGETS.index(int(n)) if int(n) in TABLE_BUDGETS else None
            target, peer = (t[name][place] if name in t and place is not None else None for t in (TARGETS, PEER))
            seen = row.get("seen_percent") or {}
            cells = [name, n, cell(seen.get("mean")), cell(target, 3), cell(peer), cell(seen.get("p90"), 3)]
            cells += [cell(seen.get("hausdorff"), 2), str(row["self_intersections"]), str(row["genus"])]
            lines.append("| " + " | ".join(cells) + " |")
    lines += ["", "| capture | seconds | preview, s | base, s | peak memory, MB | growth of cost | silhouette IoU |"]
    lines.append("|" + "---|" * 7)
    for name, result in captures.items():
        cells = [name, cell(result["wall_seconds"], 1), cell(result["preview_seconds"], 1)]
        cells.append(cell(result["base_seconds"], 1))
        cells += [cell(result["peak_memory_bytes"] / 1e6, 0), cell(result.get("growth", {}).get("ratio"), 2)]
        cells.append(cell(result.get("silhouettes", {}).get("mean")))
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main():
    options = parser(__doc__, ["nefertiti", "pot", "bowl", "oxford_dinosaur"])
    options.add_argument("--vertices", type=int, default=10000, help="of the log; the finer one has twice as many")
    options.add_argument("--coarse", type=int, default=2500, help="vertices of the coarse mesh")
    options.add_argument("--budgets", nargs="+", type=int, default=[2500, 5000, 7500, 10000], help="where")
    options = options.parse_args()

    def measure(bench):
        result = {"machine": machine(), "distances_by": evaluator(), "targets_percent": TARGETS, "peer_percent": PEER}
        result["captures"] = {}
        for name in options.captures:
            capture = find_capture(name)
            if capture is None:
                continue
            result["captures"][capture.name] = measure_capture(bench, capture, options)
            note(f"{capture.name}: {result['captures'][capture.name]['wall_seconds']:.1f} s")
        return result

    result = in_work_folder(options, measure)
    finish(result, options, "accuracy")
    if options.out:
        (options.out / "accuracy.md").write_text(table(result["captures"]))


if __name__ == "__main__":
    start(main)
