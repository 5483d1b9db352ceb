#!/usr/bin/env python3
"""The paper's experiments, one command: prints JSON, and writes CSV, JSON, SVG plots and PNG pictures into --out.

usage: tests/bench/paper.py --out FOLDER [--captures NAME...] [--rates N...] [--build build] [--work FOLDER]

Fig. 6    Psi against vertices: the method (`refine`), global subdivision (`uniform`), plain surface flow (`flow`) at
          several fixed rates, and the true surface simplified to the same counts. The Psi of the true surface itself is
          the noise floor: what image noise and interpolation leave even there. Reductions are given as they are and above
          the floor.
Fig. 7    Psi against iterations of the flow for adaptive and uniform sampling with the same number of samples.
Figs. 4-5 pictures: coarse mesh, optimised coarse mesh, plain flow, the method, the photograph.

Every Psi is measured by one tool (surface_distortion: Eqs. 5-10, one sample per pixel) on the decoded mesh.
"""
import csv

from measuring import find_capture, finish, in_work_folder, machine, note, parser, start
from svg_plot import Level, Series, line_plot

# Vertices at which the paper tells how far below plain surface flow its Psi is, and how far (in percent).
PAPER = {"nefertiti": (4204, 70.5), "pot": (9403, 76.8), "bowl": (8365, 47.5)}
SAMPLES_PER_PX_FIG_7 = 0.1  # "low sampling resolution": two steps in every triangle of the coarse mesh


def rate_point(bench, capture, mesh):
    told = bench.psi(mesh, capture)
    return {"vertices": told["vertices"], "psi": told["psi"]}


def one_log(bench, capture, name, method, options):
    """Psi along the log of a method that refines."""
    size = ["--coarse", options.coarse, "--vertices", max(options.rates)]
    model, report = bench.reconstruct(capture, f"{name}-{method}", "--method", method, *size)
    counts = [point["vertices"] for point in report["curve"]]
    return model, [rate_point(bench, capture, bench.decode(model, n)) for n in counts]


def flow_at(bench, capture, name, n_vertices, *options):
    size = ["--coarse", min(n_vertices, 2500), "--vertices", n_vertices]
    return bench.reconstruct(capture, f"{name}-flow-{n_vertices}", "--method", "flow", *size, *options)


def reduction(bench, capture, model, flow_point, floor, paper_percent=None):
    """How far the method's Psi is below that of plain surface flow, in percent, at the flow's number of vertices."""
    ours = rate_point(bench, capture, bench.decode(model, flow_point["vertices"]))
    told = {
        "vertices": flow_point["vertices"],
        "psi_flow": flow_point["psi"],
        "psi_refine": ours["psi"],
        "reduction_percent": 100 * (1 - ours["psi"] / flow_point["psi"]),
    }
    if floor is not None:
        told["reduction_above_floor_percent"] = 100 * (1 - (ours["psi"] - floor) / (flow_point["psi"] - floor))
    if paper_percent is not None:
        told["paper_percent"] = paper_percent
    return told


def psi_against_vertices(bench, capture, name, options):
    """Fig. 6 of one capture, and the meshes that the pictures show."""
    truth = capture / "gt.ply"
    floor = bench.psi(truth, capture)["psi"] if truth.exists() else None
    paper_count, paper_percent = PAPER.get(capture.name, (None, None))
    model, refine = one_log(bench, capture, name, "refine", options)
    _, uniform = one_log(bench, capture, name, "uniform", options)
    flow, reductions, flow_mesh = [], [], None
    for n in sorted({*options.rates, *([paper_count] if paper_count else [])}):
        flow_mesh = bench.decode(flow_at(bench, capture, name, n)[0])
        point = rate_point(bench, capture, flow_mesh)
        flow.append(point)
        reductions.append(reduction(bench, capture, model, point, floor, paper_percent if n == paper_count else None))
        saved = reductions[-1]["reduction_percent"]
        note(f"{name}: flow at {point['vertices']}: Psi {point['psi']:.2f}, {saved:.1f} % of it saved by ours")
    result = {"noise_floor": floor, "refine": refine, "uniform": uniform, "flow": flow}
    if floor is not None:
        result["truth"] = [rate_point(bench, capture, bench.simplify(truth, n)) for n in options.rates]
    result["reductions"] = reductions
    coarse = bench.work / f"{name}-coarse.ply"
    bench.tool("coarse_mesh", capture, "-o", coarse, "--vertices", options.coarse)
    pictured = [coarse, bench.decode(model, refine[0]["vertices"]), flow_mesh, bench.decode(model)]
    return result, pictured


def samples_per_px_for(bench, mesh, capture, n_wanted):
    """The C at which adaptive sampling takes this many samples of the mesh, by bisection."""
    low, high = SAMPLES_PER_PX_FIG_7 / 8, SAMPLES_PER_PX_FIG_7 * 8
    for _ in range(10):
        middle = (low * high) ** 0.5
        n = bench.tool("surface_distortion", mesh, capture, "--samples-per-px", middle)["samples"]
        low, high = (middle, high) if n < n_wanted else (low, middle)
    return (low * high) ** 0.5


def psi_against_iterations(bench, capture, name, n_vertices):
    """Fig. 7: both samplings from the same coarse mesh, with as many samples, measured the same way."""
    mesh = bench.work / f"{name}-fig7.ply"
    bench.tool("coarse_mesh", capture, "-o", mesh, "--vertices", n_vertices)
    uniform = ["--sampling", "uniform", "--samples-per-px", SAMPLES_PER_PX_FIG_7]
    n_uniform = bench.tool("surface_distortion", mesh, capture, *uniform)["samples"]
    density = samples_per_px_for(bench, mesh, capture, n_uniform)
    adaptive = ["--sampling", "adaptive", "--samples-per-px", density]
    result = {"vertices": n_vertices}
    for kind, sampling in (("adaptive", adaptive), ("uniform", uniform)):
        result[kind] = {
            "samples_per_px": sampling[-1],
            "samples": bench.tool("surface_distortion", mesh, capture, *sampling)["samples"],
            "psi": flow_at(bench, capture, name, n_vertices, *sampling)[1]["iterations"],
        }
    return result


def points(curve, subtract=0.0):
    return [(p["vertices"], p["psi"] - subtract) for p in curve]


NAMES = {
    "refine": "Anyrate (one log)",
    "flow": "plain surface flow",
    "uniform": "global subdivision",
    "truth": "true surface, simplified",
}
UNIT = "squared colour units"


def plot_rates(name, rates, out):
    curves = [key for key in NAMES if key in rates]
    floor = rates["noise_floor"]
    levels = [] if floor is None else [Level("noise floor (true surface)", floor)]
    series = [Series(NAMES[key], points(rates[key]), dashed=key == "truth") for key in curves]
    axes = {"log_x": True, "log_y": True}
    title = f"{name}: distortion against rate (Fig. 6)"
    plot = line_plot(title, "vertices", f"Ψ, {UNIT}", series, levels, **axes)
    (out / f"psi_vertices_{name}.svg").write_text(plot)
    if floor is not None:
        above = [Series(NAMES[key], points(rates[key], floor), dashed=key == "truth") for key in curves]
        title = f"{name}: distortion above the noise floor"
        plot = line_plot(title, "vertices", f"Ψ − noise floor, {UNIT}", above, **axes)
        (out / f"psi_above_floor_{name}.svg").write_text(plot)
    with open(out / f"psi_vertices_{name}.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["method", "vertices", "psi", "psi_above_floor"])
        for key in curves:
            for point in rates[key]:
                table.writerow([key, point["vertices"], point["psi"], "" if floor is None else point["psi"] - floor])


def plot_iterations(name, fig7, out):
    kinds = ("adaptive", "uniform")
    series = [Series(f"{kind} sampling", list(enumerate(fig7[kind]["psi"])), dots=False) for kind in kinds]
    title = f"{name}, {fig7['vertices']:,} vertices: both samplings, as many samples (Fig. 7)"
    plot = line_plot(title, "iteration of the surface flow", f"Ψ, {UNIT}", series, log_y=True)
    (out / f"psi_iterations_{name}.svg").write_text(plot)
    with open(out / f"psi_iterations_{name}.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["sampling", "iteration", "psi"])
        for kind in kinds:
            table.writerows([kind, i, psi] for i, psi in enumerate(fig7[kind]["psi"]))


def main():
    options = parser(__doc__, ["nefertiti", "pot", "bowl"])
    rates = [2500, 3500, 5000, 7500, 10000]
    options.add_argument("--rates", nargs="+", type=int, default=rates, help="vertices of the flow")
    options.add_argument("--coarse", type=int, default=2500, help="vertices of the coarse mesh")
    options.add_argument("--iterations-at", type=int, default=2887, help="vertices of Fig. 7")
    options.add_argument("--iterations-of", nargs="*", default=["nefertiti"], help="captures of Fig. 7")
    options.add_argument("--view", type=int, default=3, help="whose camera the pictures are taken by")
    options = options.parse_args()
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)

    def measure(bench):
        result = {"machine": machine(), "captures": {}, "iterations": {}}
        for name in options.captures:
            capture = find_capture(name)
            if capture is None:
                continue
            name = capture.name
            rates, pictured = psi_against_vertices(bench, capture, name, options)
            result["captures"][name] = rates
            if options.out:
                plot_rates(name, rates, options.out)
                picture = options.out / f"meshes_{name}.png"
                look = ["--photo", "--view", options.view, "--height", 300]
                bench.tool("render_mesh", capture, *pictured, *look, "-o", picture)
            if name in options.iterations_of:
                fig7 = psi_against_iterations(bench, capture, name, options.iterations_at)
                result["iterations"][name] = fig7
                if options.out:
                    plot_iterations(name, fig7, options.out)
        return result

    finish(in_work_folder(options, measure), options, "paper")


if __name__ == "__main__":
    start(main)
