"""The benchmark scripts still run and say what they promise, on a tiny capture made here. Numbers are not judged.

Run by CTest; by hand: ANYRATE_BUILD=build python3 -m unittest smoke_test, from this folder.
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.dom.minidom

import ablation

HERE = pathlib.Path(__file__).resolve().parent
BUILD = pathlib.Path(os.environ.get("ANYRATE_BUILD") or HERE.parents[1] / "build")
SIZE = ["--coarse", "250", "--build", str(BUILD)]


def bench(script, *arguments):
    """(JSON that the script printed, what it said besides)"""
    # Without the shared captures, so that distances come from `anyrate compare` and the test is the same everywhere.
    environment = {**os.environ, "ANYRATE_SHARED": str(HERE / "nowhere"), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, str(HERE / script), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)
    if done.returncode != 0:
        raise AssertionError(f"{script}: exit {done.returncode}\n{done.stderr}")
    return json.loads(done.stdout), done.stderr


class Smoke(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="anyrate-smoke-"))
        cls.capture = cls.folder / "torus"
        small = ["--views", "10", "--width", "160", "--height", "120"]
        command = [BUILD / "anyrate", "simulate", "--scene", "torus", "-o", cls.capture, *small]
        subprocess.run(command, check=True, stderr=subprocess.PIPE)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    def test_both_readers_are_timed(self):
        log = HERE.parent / "golden" / "icosphere.arl"
        commands = [[BUILD / "bench" / "replay", log, "--seconds", "0"]]
        web = HERE.parents[1] / "web"
        if shutil.which("node") and (web / "dist").is_dir() and (web / "node_modules").is_dir():
            commands.append(["node", HERE / "replay.mjs", log, "--seconds", "0"])
        for command in commands:
            done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=120)
            self.assertEqual(done.returncode, 0, done.stderr)
            result = json.loads(done.stdout)
            self.assertEqual((result["log"]["splits"], result["log"]["vertices"]), (425, 1317))
            self.assertGreater(result["packet"]["milliseconds"], 0)
            self.assertTrue(all(rate > 0 for rate in result["replay"].values()))

    def test_the_backends_are_measured(self):
        tiny = ["--views", "6", "--width", "96", "--height", "72", "--vertices", "400", "--repeat", "1"]
        environment = {**os.environ, "MESA_SHADER_CACHE_DISABLE": "true"}
        done = subprocess.run([BUILD / "bench" / "backend", *tiny], capture_output=True, text=True, env=environment, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        result = json.loads(done.stdout)
        self.assertEqual([backend["name"] for backend in result["backends"]][0], "cpu")
        self.assertEqual(len(result["backends"]), 2, result.get("no_device"))
        for backend in result["backends"]:
            self.assertGreater(backend["stages"]["terms"]["samples_per_second"], 0)
        device = result["backends"][1]["stages"]
        self.assertEqual(device["terms"]["dispatches"], 3)
        self.assertGreater(device["upload"]["bytes_up"], 6 * 96 * 72 * 4)
        # Nothing of a round comes back but the vertices, three doubles each, and how it ended.
        self.assertLess(device["optimise_round"]["bytes_down"], 24 * result["scene"]["vertices"] + 256)
        self.assertGreater(device["optimise_round"]["dispatches"], 10)
        self.assertGreater(result["roofline"]["operations_per_second"], 0)
        self.assertGreater(result["roofline"]["bytes_per_second"], 0)

    def test_paper_measures_all_methods_and_draws_them(self):
        out = self.folder / "paper"
        fig7 = ["--iterations-at", 300, "--iterations-of", "torus"]
        result, _ = bench("paper.py", "--captures", self.capture, "--rates", 250, 500, "--out", out, *fig7, *SIZE)
        rates = result["captures"]["torus"]
        self.assertGreater(rates["noise_floor"], 0)
        for method in ("refine", "uniform", "flow", "truth"):
            self.assertTrue(all(point["psi"] > 0 for point in rates[method]), method)
        self.assertLess(rates["refine"][-1]["psi"], rates["refine"][0]["psi"])
        self.assertEqual(len(rates["reductions"]), 2)
        both = result["iterations"]["torus"]
        self.assertEqual(both["adaptive"]["psi"][0], both["uniform"]["psi"][0])
        self.assertAlmostEqual(both["adaptive"]["samples"] / both["uniform"]["samples"], 1, delta=0.1)
        for plot in ("psi_vertices_torus", "psi_above_floor_torus", "psi_iterations_torus"):
            self.assertEqual(xml.dom.minidom.parse(str(out / f"{plot}.svg")).documentElement.tagName, "svg")
        self.assertEqual((out / "meshes_torus.png").read_bytes()[1:4], b"PNG")
        self.assertEqual(json.loads((out / "paper.json").read_text()), result)

    def test_accuracy_tells_both_routes(self):
        out = self.folder / "accuracy"
        counts = ["--vertices", 500, "--budgets", 300, 500]
        result, _ = bench("accuracy.py", "--captures", self.capture, "--out", out, *counts, *SIZE)
        told = result["captures"]["torus"]
        self.assertEqual(sorted(told["at"]), ["300", "500"])
        for row in told["at"].values():
            self.assertTrue(row["closed_manifold"])
            self.assertEqual(row["genus"], 1)
            self.assertGreaterEqual(row["self_intersections"], 0)
            self.assertGreater(row["seen_percent"]["mean"], 0)
        route = told["other_route"][0]
        self.assertGreater(route["prefix_over_simplified_from_1000"], 0)
        self.assertGreater(route["own_prefix_over_simplified_from_1000"], 0)
        self.assertEqual(route["own_prefix_over_simplified_from_500"], route["prefix_over_simplified_from_500"])
        self.assertGreater(told["peak_memory_bytes"], 1e6)
        self.assertIn("| torus | 500 |", (out / "accuracy.md").read_text())

    def test_robustness_judges_a_perturbation_against_the_clean_capture(self):
        only = ["--only", "scale_1000", "gain_20_percent", "--vertices", 400]
        result, _ = bench("robustness.py", "--captures", self.capture, *only, *SIZE)
        rows = result["captures"]["torus"]
        self.assertEqual(list(rows), ["clean", "scale_1000", "gain_20_percent"])
        self.assertTrue(rows["clean"]["one_closed_manifold"])
        for name in ("scale_1000", "gain_20_percent"):
            self.assertGreater(rows[name]["error_ratio"], 0)

    def test_rate_distortion_weighs_prefixes_against_single_meshes(self):
        out = self.folder / "rate_distortion"
        counts = ["--vertices", 800, "--budgets", 300, 800]
        torus = ["--captures", "--meshes", self.capture / "gt.ply"]
        result, _ = bench("rate_distortion.py", *counts, *torus, "--out", out, *SIZE)
        told = result["meshes"]["torus_true"]
        rows = told["prefixes"]
        self.assertEqual([row["vertices"] for row in rows], [300, 800])
        for row in rows:
            self.assertLessEqual(row["bytes_share"], row["bytes"])
            self.assertGreater(row["over_single"], 0)
            self.assertGreater(row["framing"], 0)
        self.assertLess(rows[-1]["error"], rows[0]["error"])
        self.assertEqual(rows[-1]["bytes"] + told["colour_bytes"], told["file_bytes"] - 28)  # all but the end frame
        self.assertEqual(xml.dom.minidom.parse(str(out / "rate_distortion_torus_true.svg")).documentElement.tagName, "svg")
        self.assertEqual(len((out / "rate_distortion_torus_true.csv").read_text().splitlines()), 3)

    def test_colours_are_weighed_against_those_wished_and_the_photographs(self):
        def tool(name, *arguments):
            done = subprocess.run([str(word) for word in (BUILD / "bench" / name, *arguments)], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            return json.loads(done.stdout)

        counts = ["--vertices", 600, "--coarse", 250]
        coarse, fine = (tool("colour_rate", self.capture, *counts, "--luma", step, "--chroma", step) for step in (30, 2))
        self.assertGreater(fine["bits_per_vertex"], coarse["bits_per_vertex"])
        self.assertLess(fine["mean_error"], coarse["mean_error"])
        model, mesh = self.folder / "coloured.arl", self.folder / "coloured.ply"
        for command in (["reconstruct", self.capture, "-o", model, "--quiet", *counts], ["decode", model, "-o", mesh]):
            subprocess.run([str(word) for word in (BUILD / "anyrate", *command)], check=True, stdout=subprocess.PIPE)
        told = tool("photo_difference", mesh, self.capture)
        self.assertGreater(told["pixels"], 1000)
        self.assertGreaterEqual(told["rms"], told["mean"])
        self.assertLess(told["mean"], 40)

    def test_ablation_can_switch_off_every_technique(self):
        """Only that its edits still find their line: building a variant of the sources takes minutes."""
        for technique in ablation.TECHNIQUES:
            with self.subTest(technique.name):
                text = (ablation.ROOT / technique.file).read_text()
                self.assertEqual(text.count(technique.on), 1)
                self.assertNotEqual(technique.on, technique.off)

    def test_ablation_tells_what_a_technique_is_worth(self):
        names = ["seen_percent", "seen_percent_at_half", "hausdorff_percent", "psi", "self_intersections"]
        told, whole = dict(zip(names, [0.03, 0.05, 0.9, 12.0, 7])), dict(zip(names, [0.02, 0.04, 1.0, 6.0, 0]))
        row = {"what": "what it is", "captures": {"a": ablation.with_ratios(told, whole)}}
        table = ablation.markdown({"whole": {"a": {}}, "techniques": {"one": row, "two": {"what": "other", "failed": "x"}}})
        self.assertIn("| one: what it is | 1.25, 1.50, 0.90, 2.00; 7 pairs of faces meet |", table)
        self.assertIn("| two: other | failed |", table)

    def test_captures_that_are_not_here_are_skipped_with_a_message(self):
        result, said = bench("accuracy.py", "--captures", "nefertiti", *SIZE)
        self.assertEqual(result["captures"], {})
        self.assertIn("skipped nefertiti", said)


if __name__ == "__main__":
    unittest.main()
