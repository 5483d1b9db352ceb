#!/usr/bin/env python3
"""What imperfect captures cost: one reconstruction for every perturbation; prints one JSON object.

usage: tests/bench/robustness.py [--captures NAME] [--only NAME...] [--vertices N] [--out FOLDER] [--huge]

For each: the mean distance to the true surface where two cameras of the clean capture see it, over that of the clean one
("error_ratio"; asked for is at most 1.5, and 1 within 1 % for scale and origin); where images are cropped, both are judged
where two cameras of the cropped capture see the surface, since nobody can rebuild what no image shows; whether the mesh is
closed, manifold and of one piece, its genus and its self-intersections; seconds and peak memory. A reconstruction that
fails is a row with "failed" instead, and the others go on. The captures are made by perturb_capture in a temporary folder.
--huge adds 100 images of 12 megapixels, which takes long and tens of gigabytes of disk.
"""
from dataclasses import dataclass

from measuring import CommandFailed, evaluator, find_capture, finish, in_work_folder, machine, note, parser, run, start

MAX_RATIO = 1.5
MAX_RATIO_OF_SCALE = 1.01


@dataclass
class Perturbation:
    name: str
    arguments: list  # of perturb_capture
    moves_world: bool = False
    hides_parts: bool = False  # so that its own cameras say what can be asked for
    pixel: float = 1  # its side, in clean ones: errors are compared in pixels


PERTURBATIONS = [
    Perturbation("scale_0.001", ["--scale", 1e-3], moves_world=True),
    Perturbation("scale_1000", ["--scale", 1e3], moves_world=True),
    Perturbation("far_origin", ["--origin", "1e6,-2e6,5e5"], moves_world=True),
    Perturbation("unequal_sizes", ["--resample", 0.75]),
    Perturbation("half_the_resolution", ["--resolution", 0.5], pixel=2),
    Perturbation("gain_20_percent", ["--gain", 0.2]),
    Perturbation("masks_dilated_2px", ["--grow-masks", 2]),
    Perturbation("masks_eroded_2px", ["--grow-masks", -2]),
    Perturbation("pose_noise_half_px", ["--pose-noise", 0.5]),
    Perturbation("every_other_view", ["--keep-every", 2]),
    Perturbation("texture_of_a_quarter", ["--texture", 0.25]),  # of the contrast
    Perturbation("texture_of_a_tenth", ["--texture", 0.1]),
    Perturbation("no_texture", ["--texture", 0]),
    Perturbation("cropped_to_70_percent", ["--crop", 0.7], hides_parts=True),
]
OTHERS = ["second_ring", "handles"]


def reconstructed(bench, capture, name, judge, options, cameras="cameras.json", truth=None):
    """One row. `judge` is the capture whose cameras decide what is seen."""
    try:
        size = ["--vertices", options.vertices, "--coarse", options.coarse]
        model, report = bench.reconstruct(capture, name, "--cameras", cameras, *size)
        mesh = bench.decode(model)
        told = bench.tool("mesh_report", mesh)
        seen = bench.seen(mesh, judge, truth)
    except CommandFailed as failure:
        note(f"{name}: {failure}")
        return {"failed": str(failure)}
    row = {
        "seen_percent": 100 * seen["mean"],
        "hausdorff_percent": 100 * seen["hausdorff"],
        "one_closed_manifold": told["closed_manifold"] and told["components"] == 1,
        "genus": told["genus"],
        "self_intersections": told["self_intersections"],
        "wall_seconds": report["wall_seconds"],
        "peak_memory_bytes": report["peak_memory_bytes"],
    }
    note(f"{name}: {row['seen_percent']:.4f} %, {row['wall_seconds']:.1f} s")
    return row


def against(clean, row, limit):
    """The row with its ratio to the clean one, and whether it holds what is asked."""
    if "failed" in row or "failed" in clean:
        return {**row, "holds": False}
    ratio = row["seen_percent"] / clean["seen_percent"]
    holds = ratio <= limit and (limit >= MAX_RATIO or ratio >= 2 - limit) and row["one_closed_manifold"]
    return {**row, "error_ratio": ratio, "limit": limit, "holds": holds}


def perturbed(bench, capture, perturbation, clean, options):
    folder = bench.work / f"capture-{perturbation.name}"
    bench.tool("perturb_capture", capture, "-o", folder, *perturbation.arguments)
    judge = folder if perturbation.moves_world or perturbation.hides_parts else capture
    if perturbation.hides_parts and "failed" not in clean:
        clean = {**clean, "seen_percent": 100 * bench.seen(bench.mesh_of("clean"), folder)["mean"]}
    row = reconstructed(bench, folder, perturbation.name, judge, options)
    if "failed" not in clean:
        clean = {**clean, "seen_percent": perturbation.pixel * clean["seen_percent"]}
    return against(clean, row, MAX_RATIO_OF_SCALE if perturbation.moves_world else MAX_RATIO)


def second_ring(bench, options):
    """pot with its second ring of cameras against pot without."""
    capture = find_capture("pot")
    if capture is None:
        return None
    clean = reconstructed(bench, capture, "one_ring", capture, options)
    both = reconstructed(bench, capture, "second_ring", capture, options, "cameras_2ring.json")
    return against(clean, both, MAX_RATIO)


def handles(bench, options):
    """The built-in vessel has two handles: its surface keeps its genus."""
    folder = simulated(bench, "vessel", "--scene", "vessel")
    row = reconstructed(bench, folder, "handles", folder, options)
    genus = bench.tool("mesh_report", folder / "gt.ply")["genus"]
    return {**row, "true_genus": genus, "holds": row.get("genus") == genus and row.get("one_closed_manifold", False)}


def huge(bench, capture, options):
    size = ["--views", 100, "--width", 4000, "--height", 3000]
    folder = simulated(bench, "huge", "--mesh", capture / "gt.ply", *size)
    return reconstructed(bench, folder, "huge", folder, options)


def simulated(bench, name, *arguments):
    folder = bench.work / f"capture-{name}"
    run(bench.anyrate, "simulate", *arguments, "-o", folder)
    return folder


def main():
    options = parser(__doc__, ["nefertiti"])
    names = [p.name for p in PERTURBATIONS] + OTHERS
    options.add_argument("--only", nargs="+", choices=names, default=names, help="the perturbations to run")
    options.add_argument("--vertices", type=int, default=10000)
    options.add_argument("--coarse", type=int, default=2500)
    options.add_argument("--huge", action="store_true", help="100 images of 12 megapixels as well")
    options = options.parse_args()

    def measure(bench):
        result = {"machine": machine(), "distances_by": evaluator(), "vertices": options.vertices, "captures": {}}
        for name in options.captures:
            capture = find_capture(name)
            if capture is None:
                continue
            clean = reconstructed(bench, capture, "clean", capture, options)
            rows = result["captures"][capture.name] = {"clean": clean}
            for perturbation in PERTURBATIONS:
                if perturbation.name in options.only:
                    rows[perturbation.name] = perturbed(bench, capture, perturbation, clean, options)
            if options.huge:
                rows["huge"] = huge(bench, capture, options)
        if "second_ring" in options.only:
            result["second_ring"] = second_ring(bench, options)
        if "handles" in options.only:
            result["handles"] = handles(bench, options)
        return result

    finish(in_work_folder(options, measure), options, "robustness")


if __name__ == "__main__":
    start(main)
