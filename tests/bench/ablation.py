#!/usr/bin/env python3
"""What each technique beyond the paper is worth: the method without it against the whole; prints one JSON object.

usage: tests/bench/ablation.py [--captures NAME...] [--only NAME...] [--draws N] [--vertices N] [--out FOLDER]

Takes a copy of the sources into the work folder and builds it; then, technique by technique, changes the one line of the
copy that switches it off, builds again and reconstructs. A row has the error where two cameras see the true surface, at
half of the vertices and at all, the largest error, Psi, pairs of faces that meet and seconds of every capture, and the
ratios to the whole method ("error_ratio" above 1: the technique helps). A technique for imperfect captures is measured on
one: made by perturb_capture, judged by the cameras of the clean one. The pot has all of its 36 views.

Which dents a surface falls into hangs on the last digits of the cameras. --draws takes the mean over as many captures
whose cameras differ by a ten-thousandth of a pixel; "seen_percent_of_draws" tells how far they lie apart.
With --out, a table in Markdown as well.
"""
import os
import shutil
import statistics
import subprocess
from dataclasses import dataclass, field

from measuring import (
    CAMERAS,
    ROOT,
    CommandFailed,
    evaluator,
    find_capture,
    finish,
    in_work_folder,
    machine,
    note,
    parser,
    run,
    start,
)

CORE = "core/reconstruction/"
LAST_DIGITS = ["--pose-noise", 1e-4]


@dataclass
class Technique:
    name: str
    what: str  # it is
    file: str
    on: str  # text that occurs once in the file
    off: str
    perturbation: list = field(default_factory=list)  # arguments of perturb_capture


TECHNIQUES = [
    Technique(
        "long_range_start",
        "depths of a plane sweep open the hull's lids over cavities",
        CORE + "initial_mesh.cpp",
        "const ConfirmedDepths depths = confirm_depths(plane_sweep(images, hull));",
        "ConfirmedDepths depths = confirm_depths(plane_sweep(images, hull)); depths.confirmed.clear();",
    ),
    Technique(
        "near_lids",
        "the hull's points go where views see through them by one pixel of disparity, not by three",
        CORE + "seen_through.h",
        "double margin_px = 1.0;",
        "double margin_px = 3.0;",
    ),
    Technique(
        "strong_votes",
        "depths outvote the points of the hull's lids: for cavities as deep as the pot's",
        CORE + "poisson.h",
        "double vote = 0.2;",
        "double vote = 0.05;",
    ),
    Technique(
        "votes_by_agreement",
        "a depth's vote weighs as the square of its images' agreement; here every second view alone",
        CORE + "depth_votes.cpp",
        "of_vote = agreement * agreement;",
        "of_vote = 1 + 0 * agreement;",
        ["--keep-every", 2],
    ),
    Technique(
        "bounded_votes",
        "no more votes count on a node than two that are certain; here every second view alone",
        CORE + "poisson.h",
        "double most_votes = 2;",
        "double most_votes = 1e9;",
        ["--keep-every", 2],
    ),
    Technique(
        "guesses",
        "what no image shows is bent and put on trial",
        CORE + "reconstruct.cpp",
        "        guessed = confirm_guesses(sampler, silhouettes, guessed, mesh, {}, stop);\n",
        "",
    ),
    Technique(
        "spreading_guesses",
        "what no two views see beside a guess becomes one",
        CORE + "confirm_guesses.cpp",
        "if (spreads && standings[at(v)] == Standing::shown && !G[at(v)] &&",
        "if (false && !G[at(v)] &&",
    ),
    Technique(
        "many_passes",
        "guesses are put on trial six times, not three",
        CORE + "confirm_guesses.h",
        "int passes = 6;",
        "int passes = 3;",
    ),
    Technique(
        "patches",
        "what the images still disagree on is replaced patch by patch",
        CORE + "confirm_guesses.cpp",
        "if (options.passes > 0 && !stop.stop_requested())",
        "if (false)",
    ),
    Technique(
        "halved_edges",
        "where images still disagree patches are replaced anew with edges of half the length",
        CORE + "mend_patches.cpp",
        "if (finer.n_vertices() == mesh.n_vertices() || stop.stop_requested()) return;",
        "return;",
    ),
    Technique(
        "pushed_patches",
        "patches that rest where images disagree start anew from a place further in and further out",
        CORE + "mend_patches.cpp",
        "    replace(pushed_passes);",
        "",
    ),
    Technique(
        "patches_of_cropped",
        "the same where photographs are cropped to 70 %",
        CORE + "confirm_guesses.cpp",
        "if (options.passes > 0 && !stop.stop_requested())",
        "if (false)",
        ["--crop", 0.7],
    ),
    Technique(
        "coarse_to_fine",
        "vertices first move on coarse image levels",
        CORE + "reconstruct.cpp",
        "constexpr int coarsest_level = 3;",
        "constexpr int coarsest_level = 0;",
    ),
    Technique(
        "detail",
        "the even mesh has edges half as long where it would miss the surface",
        CORE + "reconstruct.cpp",
        "constexpr double even_detail = 0.1;",
        "constexpr double even_detail = 0;",
    ),
    Technique(
        "fine_mesh",
        "each face becomes four for the photographs themselves",
        CORE + "reconstruct.cpp",
        "        if (level == 0) mesh = subdivide(mesh);\n",
        "",
    ),
    Technique(
        "quadric_base",
        "the base's vertices stand where the surface bends",
        "core/mesh/coarse_fit.cpp",
        "Mesh base = simplify(stage, n_vertices, may_meet);",
        "Mesh base = remesh_isotropic(mesh, {.n_vertices = n_vertices});",
    ),
    Technique(
        "staged_base",
        "the base is simplified in stages that are fitted to the surface",
        "core/mesh/coarse_fit.cpp",
        "constexpr double first_stage = 2;",
        "constexpr double first_stage = 1;",
    ),
    Technique(
        "sliding_base",
        "vertices of the base slide in their tangent planes to where the surface bends",
        "core/mesh/coarse_fit.cpp",
        "{.slides = true, ",
        "{.slides = false, ",
    ),
    Technique(
        "moves_apart",
        "moves of the fits that make faces meet are taken back",
        "core/mesh/keep_apart.cpp",
        "if (meeting.empty()) return;",
        "return;",
    ),
    Technique(
        "collapses_apart",
        "collapses that make faces meet give way to others",
        "core/mesh/decimate_apart.cpp",
        "if (meeting.empty() ||",
        "if (true ||",
    ),
    Technique(
        "splits_apart",
        "splits that make faces meet give way to the next in rank",
        "core/progressive/surface_approach.cpp",
        "if (meeting.empty()) return emitted;",
        "return emitted;",
    ),
    Technique(
        "harmless_splits",
        "splits that take the mesh further from the surface give way to others",
        "core/progressive/split_gains.cpp",
        "gains[at(*split)] += sign * costs[f]",
        "gains[at(*split)] += 0 * sign * costs[f]",
    ),
    Technique(
        "kept_creases",
        "flips that splits imply leave edges along creases alone",
        "core/progressive/refinement_rules.h",
        "FlipRule flip_rule = FlipRule::curvature_aligned;",
        "FlipRule flip_rule = FlipRule::delaunay;",
    ),
    Technique(
        "little_smoothing",
        "vertices around a split are smoothed by a sixteenth, not by a quarter",
        "core/progressive/refinement_rules.h",
        "RingSmoothing ring_smoothing = RingSmoothing::sixteenth;",
        "RingSmoothing ring_smoothing = RingSmoothing::quarter;",
    ),
    Technique(
        "fine_surface",
        "base and splits are fitted to a mesh with its vertices where the surface bends, not to an even one",
        CORE + "reconstruct.cpp",
        "Mesh fine = fixed_rate ? mesh : fine_surface(*backend, start, options.n_vertices, stop);",
        "Mesh fine = mesh;",
    ),
    Technique(
        "approach",
        "the log's splits approach that surface instead of following the images once more",
        CORE + "reconstruct.cpp",
        "refinement.follows_images = options.follows_images || refinement.by_area;",
        "refinement.follows_images = true;",
    ),
    Technique(
        "resolved_edges",
        "no mesh that is optimised has edges shorter than four pixels; here photographs half as wide and high",
        CORE + "pixel_footprint.cpp",
        "return static_cast<int>(std::min(area / area_of_vertex, 1e9));",
        "return static_cast<int>(std::min(area / area_of_vertex * 1e3, 1e9));",
        ["--resolution", 0.5],
    ),
    Technique(
        "swept_cells",
        "the first surface's grid is as fine as the pixels that are swept; here photographs half as wide and high",
        CORE + "initial_mesh.cpp",
        "return {.pixels_per_cell = std::exp2(swept_level(images))};",
        "static_cast<void>(images); return {};",
        ["--resolution", 0.5],
    ),
    Technique(
        "unseen_surface",
        "what faces away from all views is flat and a guess; here photographs cropped to 70 %",
        CORE + "initial_mesh.cpp",
        "unseen_vertices(initial.mesh, images);",
        "std::vector<char>(initial.mesh.vertices.size());",
        ["--crop", 0.7],
    ),
    Technique(
        "roll_back",
        "a step that does not lower the energy is taken back and damped",
        CORE + "optimise_surface.cpp",
        "if (energy_ < before) {",
        "{",
    ),
    Technique(
        "robust_phi",
        "a face counts by its logarithm where it disagrees thirty times more than usual",
        CORE + "optimise_surface.cpp",
        "constexpr double outlier = 30;",
        "constexpr double outlier = 1e30;",
    ),
    Technique(
        "damped_start",
        "the first step is damped ten times more",
        CORE + "optimise_surface.cpp",
        "first_damping = 0.1;",
        "first_damping = 0.01;",
    ),
    Technique(
        "silhouette_term",
        "contours are drawn to the masks' borders",
        CORE + "optimise_surface.h",
        "double silhouette = 0.12;",
        "double silhouette = 0.0;",
    ),
    Technique(
        "contour_price",
        "contours cost less where images show hardly more than their noise; here a tenth of the texture",
        CORE + "optimise_surface.cpp",
        "return std::max(psi, std::min(clean_psi, std::max(noise_psi, psi * psi / noise_psi)));",
        "return std::max(psi, clean_psi);",
        ["--texture", 0.1],
    ),
    Technique(
        "curvature_aligned",
        "edges are Delaunay's in the metric of the surface's curvature (flip rule 3)",
        "core/progressive/refinement_rules.h",
        "FlipRule flip_rule = FlipRule::curvature_aligned;",
        "FlipRule flip_rule = FlipRule::crease_preserving;",
    ),
    Technique(
        "least_curvature",
        "bending is weighed against no less than noise, nor are there more rounds; here a tenth of the texture",
        CORE + "optimise_surface.cpp",
        "constexpr double noise_curvature = 75;",
        "constexpr double noise_curvature = 0;",
        ["--texture", 0.1],
    ),
    Technique(
        "faint_rounds",
        "three times as many rounds where texture tells less than noise; here a tenth of the texture",
        CORE + "optimise_surface.cpp",
        "constexpr int faint_rounds = 3;",
        "constexpr int faint_rounds = 1;",
        ["--texture", 0.1],
    ),
    Technique(
        "bending_term",
        "vertices that the images say much of bend towards flat",
        CORE + "optimise_surface.cpp",
        "bending_ = (options_.bending + noisy_bending * noise) *",
        "bending_ = 0 * (options_.bending + noisy_bending * noise) *",
    ),
    Technique(
        "ring_shape",
        "what the images say little of keeps its ring's shape, not its own; here photographs cropped to 70 %",
        CORE + "normal_displacement.cpp",
        "means[i] = sum / n;",
        "means[i] = n > 0 ? values[i] : sum;",
        ["--crop", 0.7],
    ),
    Technique(
        "full_resolution_depth",
        "what hides what is told at the photographs' own resolution, not at half of it",
        CORE + "visibility.h",
        "int finest_level = 0;",
        "int finest_level = 1;",
    ),
    Technique(
        "far_contours",
        "a contour hides a pixel more of what lies far behind it",
        CORE + "visibility.h",
        "double far_px = 4.0;",
        "double far_px = 1e9;",
    ),
    Technique(
        "lone_witness",
        "a depth that nobody contradicts needs one other view",
        CORE + "confirmed_depth.cpp",
        "is_confirmed = n_confirm[lane] > 2 * n_against;",
        "is_confirmed = n_confirm[lane] >= options.n_views && n_confirm[lane] > 2 * n_against;",
    ),
    Technique(
        "aligned_views",
        "cameras turn to where they show the surface; here half a pixel off",
        CORE + "reconstruct.cpp",
        "constexpr double least_shift_px = 0.1;",
        "constexpr double least_shift_px = 1e9;",
        ["--pose-noise", 0.5],
    ),
    Technique(
        "kept_places",
        "what the shifts of all cameras have in common is undone; here half a pixel off",
        CORE + "reconstruct.cpp",
        "const Vec3 translation = take_translation(start.images, sum / start.mesh.n_vertices(), shifts);",
        "const Vec3 translation = 0 * sum;",
        ["--pose-noise", 0.5],
    ),
    Technique(
        "aligned_masks",
        "masks grow to where the surface has its contours; here two pixels too small",
        CORE + "reconstruct.cpp",
        "constexpr double least_growth_px = 0.5;",
        "constexpr double least_growth_px = 1e9;",
        ["--grow-masks", -2],
    ),
    Technique(
        "even_exposure",
        "views' gains are evened out; here 20 % apart",
        CORE + "exposure.cpp",
        "constexpr double least_gain = 1.02;",
        "constexpr double least_gain = 1e9;",
        ["--gain", 0.2],
    ),
]


def rewrite(path, before, after):
    text = path.read_text()
    if text.count(before) != 1:
        raise CommandFailed(f"{path}: expected once, found {text.count(before)} times: {before.strip()}")
    path.write_text(text.replace(before, after))


def copy_sources(folder):
    """The files that the working tree has under version control, or its own copy of them if it is none."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file() and not name.startswith(("web/", "tests/bench/results/")):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, folder / name)


def build(folder):
    # Without warnings as errors: what a technique leaves behind is unused.
    run("cmake", "-S", folder, "-B", folder / "build", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DANYRATE_WERROR=OFF")
    run("cmake", "--build", folder / "build", "--target", "anyrate")
    return folder / "build" / "anyrate"


def photographs(bench, capture, perturbation, draw):
    """The capture as perturbed, by another seed for each draw. The first draw of a perfect one is the capture itself."""
    if draw == 0 and not perturbation:
        return capture
    folder = bench.work / f"{capture.name}{''.join(map(str, perturbation or LAST_DIGITS))}-{draw}"
    if not folder.exists():
        bench.tool("perturb_capture", capture, "-o", folder, "--seed", draw + 1, *(perturbation or LAST_DIGITS))
    return folder


def with_its_cameras(bench, capture):
    """A folder of links to the capture where "cameras.json" are those that it is measured with."""
    if capture.name not in CAMERAS:
        return capture
    folder = bench.work / capture.name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for entry in capture.iterdir():
        if entry.name != "cameras.json":
            os.symlink(entry.resolve(), folder / entry.name)
    shutil.copyfile(capture / CAMERAS[capture.name], folder / "cameras.json")
    return folder


def measured(bench, binary, capture, perturbation, name, options):
    """Means over the draws of one capture by one build: errors in percent of the diagonal, Psi of the whole model, pairs of
    faces that meet there, seconds."""
    bench.anyrate = binary
    size = ["--vertices", options.vertices, "--coarse", options.coarse]
    errors, half_errors, largest, psis, meetings, seconds = [], [], [], [], [], []
    for draw in range(options.draws):
        model, report = bench.reconstruct(photographs(bench, capture, perturbation, draw), name, *size)
        mesh = bench.decode(model)
        seen = bench.seen(mesh, capture)
        errors.append(100 * seen["mean"])
        largest.append(100 * seen["hausdorff"])
        half_errors.append(100 * bench.seen(bench.decode(model, options.vertices // 2), capture)["mean"])
        meetings.append(bench.tool("mesh_report", mesh)["self_intersections"])
        psis.append(report["curve"][-1]["psi"])
        seconds.append(report["wall_seconds"])
    row = {
        "seen_percent": statistics.fmean(errors),
        "seen_percent_of_draws": errors,
        "seen_percent_at_half": statistics.fmean(half_errors),
        "hausdorff_percent": statistics.fmean(largest),
        "psi": statistics.fmean(psis),
        "self_intersections": statistics.fmean(meetings),
        "wall_seconds": statistics.fmean(seconds),
    }
    note(f"{name}: {row['seen_percent']:.4f} %, psi {row['psi']:.1f}, {row['wall_seconds']:.1f} s")
    return row


def with_ratios(row, whole):
    ratio_of = {
        "error_ratio": "seen_percent",
        "error_ratio_at_half": "seen_percent_at_half",
        "hausdorff_ratio": "hausdorff_percent",
        "psi_ratio": "psi",
    }
    return {**row, **{ratio: row[figure] / whole[figure] for ratio, figure in ratio_of.items()}}


def ablate(bench, technique, sources, captures, whole, options):
    """The row of one technique: of every capture, what the method without it makes."""

    def of_all(binary, variant):
        name = f"{variant}-{technique.name}"
        return {c.name: measured(bench, binary, c, technique.perturbation, f"{c.name}-{name}", options) for c in captures}

    if technique.perturbation:
        whole = of_all(sources / "whole", "with")
    changed = sources / technique.file
    original = changed.read_text()
    rewrite(changed, technique.on, technique.off)
    try:
        rows = of_all(build(sources), "without")
    except CommandFailed as failure:
        note(f"without {technique.name}: {failure}")
        return {"what": technique.what, "failed": str(failure)}
    finally:
        changed.write_text(original)
    return {"what": technique.what, "captures": {name: with_ratios(row, whole[name]) for name, row in rows.items()}}


def table_cell(row):
    ratios = "{error_ratio_at_half:.2f}, {error_ratio:.2f}, {hausdorff_ratio:.2f}, {psi_ratio:.2f}".format(**row)
    pairs = row["self_intersections"]
    return ratios if pairs == 0 else f"{ratios}; {pairs:.0f} pairs of faces meet"


def markdown(result):
    """The table for people: without the technique, errors and Psi in parts of the whole's; pairs of faces that meet."""
    names = list(result["whole"])
    figures = "error at half, at all, at most, Psi"
    lines = ["| without | " + " | ".join(f"{n}: {figures}" for n in names) + " |", "|---|" + "---|" * len(names)]
    for name, row in result["techniques"].items():
        cells = ["failed" if "failed" in row else table_cell(row["captures"][n]) for n in names]
        lines.append(f"| {name}: {row['what']} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main():
    options = parser(__doc__, ["nefertiti", "pot", "bowl"])
    names = [technique.name for technique in TECHNIQUES]
    options.add_argument("--only", nargs="+", choices=names, default=names, help="the techniques to take away")
    options.add_argument("--vertices", type=int, default=10000)
    options.add_argument("--coarse", type=int, default=2500)
    options.add_argument("--draws", type=int, default=1, help="captures that differ in the cameras' last digits")
    options = options.parse_args()

    def measure(bench):
        found = [capture for capture in map(find_capture, options.captures) if capture is not None]
        captures = [with_its_cameras(bench, capture) for capture in found]
        sources = bench.work / "sources"
        copy_sources(sources)
        whole_binary = shutil.copy2(build(sources), sources / "whole")
        whole = {c.name: measured(bench, whole_binary, c, [], f"{c.name}-whole", options) for c in captures}
        result = {"machine": machine(), "distances_by": evaluator(), "vertices": options.vertices, "draws": options.draws}
        result["whole"] = whole
        result["techniques"] = {}
        for technique in TECHNIQUES:
            if technique.name not in options.only:
                continue
            result["techniques"][technique.name] = ablate(bench, technique, sources, captures, whole, options)
            if options.out is not None:  # anew after each: a run that is stopped leaves what it has
                options.out.mkdir(parents=True, exist_ok=True)
                (options.out / "ablation.md").write_text(markdown(result))
        return result

    finish(in_work_folder(options, measure), options, "ablation")


if __name__ == "__main__":
    start(main)
