#!/usr/bin/env python3
"""Reconstructs the shared captures and measures what issue 1 asks of them; prints one JSON object.

usage: tests/bench/captures.py [--binary build/anyrate] [--captures NAME...] [--methods refine flow] [--work FOLDER]

Needs the captures and the evaluation tool of ANYRATE_SHARED (or ../shared beside the project); without them it says so and
ends with exit code 0. For every capture: seconds and peak memory of `anyrate reconstruct` to 10,000 vertices with no
parameter touched, the rate-distortion curve, whether Psi falls at every step, `verify`, the decoded mesh at a list of
budgets (vertices missing from the budget, closed and consistently oriented, Euler number), and where there is ground
truth `seen` of the evaluation tool at 2,500, 5,000 and 10,000 vertices, in parts of the diagonal.
With method `flow` the plain surface flow of the paper at 5,000 and 10,000 vertices is the opponent for Psi.
Timings are those of this machine as it is while the script runs; run it on an idle one.
"""
import argparse
import json
import os
import struct
import subprocess
import sys
import tempfile
import time
from collections import Counter

from measuring import machine

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CAPTURES = ["nefertiti", "pot", "bowl", "oxford_dinosaur"]
BUDGETS = [2500, 2501, 3000, 5000, 7777, 9999, 10000]
EVALUATED = [2500, 5000, 10000]


def read_ply(path):
    """Vertex count and triangles of a binary PLY as `anyrate decode` writes it."""
    with open(path, "rb") as f:
        data = f.read()
    head, body = data.split(b"end_header\n", 1)
    sizes = {"float": 4, "double": 8, "uchar": 1}
    stride, n_vertices, n_faces, element = 0, 0, 0, ""
    for line in head.decode().splitlines():
        word = line.split()
        if word[0] == "element":
            element = word[1]
            n_vertices, n_faces = (int(word[2]), n_faces) if element == "vertex" else (n_vertices, int(word[2]))
        elif word[0] == "property" and element == "vertex":
            stride += sizes[word[1]]
    faces = [struct.unpack_from("<3i", body, n_vertices * stride + 13 * i + 1) for i in range(n_faces)]
    return n_vertices, faces


def topology(path):
    n_vertices, faces = read_ply(path)
    directed = Counter((t[i], t[(i + 1) % 3]) for t in faces for i in range(3))
    closed = all(n == 1 and directed.get((b, a)) == 1 for (a, b), n in directed.items())
    return n_vertices, closed, n_vertices - len(directed) // 2 + len(faces)


def run(command):
    start = time.monotonic()
    result = subprocess.run(command, capture_output=True, text=True)
    return result, time.monotonic() - start


def reconstruct(binary, capture, work, method, n_vertices):
    name = f"{os.path.basename(capture)}-{method}-{n_vertices}"
    model, report = os.path.join(work, name + ".arl"), os.path.join(work, name + ".json")
    result, seconds = run([binary, "reconstruct", capture, "-o", model, "--vertices", str(n_vertices), "--method", method,
                           "--report", report, "--quiet"])
    if result.returncode != 0:
        raise RuntimeError(f"{capture}: reconstruct ended with {result.returncode}: {result.stderr.strip()}")
    with open(report) as f:
        return model, json.load(f), seconds


def evaluate(shared, mesh, capture):
    tool, truth = os.path.join(shared, "tools", "eval_mesh"), os.path.join(capture, "gt.ply")
    if not (os.path.exists(tool) and os.path.exists(truth)):
        return None
    result, _ = run([tool, mesh, truth, "--cameras", os.path.join(capture, "cameras.json")])
    seen = json.loads(result.stdout)["seen"]
    return {key: seen[key] for key in ("mean", "accuracy", "completeness", "p90", "hausdorff")}


def measure(binary, shared, name, methods, work):
    capture = os.path.join(shared, "data", name)
    model, report, seconds = reconstruct(binary, capture, work, "refine", 10000)
    psi = [point["psi"] for point in report["curve"]]
    row = {
        "wall_seconds": seconds,
        "stage_seconds": report["seconds"],
        "peak_memory_bytes": report["peak_memory_bytes"],
        "log_bytes": os.path.getsize(model),
        "verified": run([binary, "verify", model])[0].returncode == 0,
        "curve": report["curve"],
        "psi_falls_at_every_step": all(b < a for a, b in zip(psi, psi[1:])),
        "budgets": [],
        "seen": {},
    }
    for budget in BUDGETS:
        mesh = os.path.join(work, f"{name}-{budget}.ply")
        result, _ = run([binary, "decode", model, "-o", mesh, "--vertices", str(budget)])
        if result.returncode != 0:
            raise RuntimeError(f"{name}: decode ended with {result.returncode}: {result.stderr.strip()}")
        n_vertices, closed, euler = topology(mesh)
        row["budgets"].append({"budget": budget, "missing": budget - n_vertices, "closed_oriented": closed, "euler": euler})
        if budget in EVALUATED:
            row["seen"][str(budget)] = evaluate(shared, mesh, capture)
    for method in methods:
        if method == "refine":
            continue
        row["psi_of_" + method] = {}
        for n_vertices in (5000, 10000):
            _, other, _ = reconstruct(binary, capture, work, method, n_vertices)
            row["psi_of_" + method][str(n_vertices)] = other["curve"][-1]["psi"]
    row["psi"] = {str(n): psi_at(report["curve"], n) for n in (5000, 10000)}
    return row


def psi_at(curve, n_vertices):
    """Psi of the last point of the curve that is within the count: the mesh of that budget has at least its quality."""
    return [point["psi"] for point in curve if point["vertices"] <= n_vertices][-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", default=os.path.join(ROOT, "build", "anyrate"))
    parser.add_argument("--captures", nargs="+", default=CAPTURES)
    parser.add_argument("--methods", nargs="+", default=["refine", "flow"])
    parser.add_argument("--work", help="keeps models and meshes there")
    options = parser.parse_args()
    shared = os.environ.get("ANYRATE_SHARED", os.path.join(ROOT, "..", "shared"))
    if not os.path.isdir(os.path.join(shared, "data")):
        print(f"skipped: no captures at {shared}", file=sys.stderr)
        return
    with tempfile.TemporaryDirectory() as temporary:
        work = options.work or temporary
        os.makedirs(work, exist_ok=True)
        result = {"machine": machine(), "captures": {}}
        for name in options.captures:
            result["captures"][name] = measure(options.binary, shared, name, options.methods, work)
            print(f"{name}: {result['captures'][name]['wall_seconds']:.1f} s", file=sys.stderr)
        json.dump(result, sys.stdout, indent=1)
        print()


if __name__ == "__main__":
    main()
