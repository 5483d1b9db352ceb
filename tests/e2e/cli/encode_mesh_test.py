"""A closed surface in, meshes at any budget out: encode-mesh, then what every model can do."""
import json
import math
import os
import pathlib
import signal
import subprocess
import time
import unittest

from support import ANYRATE, anyrate, capture, fault_of_manifold, must, read_ply, scratch

N_COARSE, N_VERTICES = 300, 1500
MANY = 300_000  # far more vertices than are there before the signal comes
SHARED = pathlib.Path(os.environ.get("ANYRATE_SHARED") or pathlib.Path(__file__).resolve().parents[4] / "shared")


def surface():
    """A coloured sphere."""
    return capture() / "gt.ply"


def encode(name, *options):
    model = scratch() / f"{name}.arl"
    return model, must("encode-mesh", surface(), "-o", model, "--coarse", N_COARSE, "--vertices", N_VERTICES, *options)


def write_obj(name, positions, triangles):
    file = scratch() / f"{name}.obj"
    lines = ["v %r %r %r" % tuple(p) for p in positions] + ["f %d %d %d" % tuple(i + 1 for i in t) for t in triangles]
    file.write_text("\n".join(lines) + "\n")
    return file


class EncodeMesh(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.model, _ = encode("encoded", "--quiet")

    def mesh_of(self, *budget):
        mesh = scratch() / "encoded.ply"
        must("decode", self.model, "-o", mesh, *budget)
        return mesh

    def test_the_log_verifies_and_meets_its_count(self):
        must("verify", self.model)
        told = json.loads(must("info", self.model, "--json").stdout)
        self.assertEqual(told["frames"][-1]["vertices"], N_VERTICES)
        self.assertEqual(told["base_vertices"], N_COARSE)

    def test_every_budget_is_a_closed_manifold(self):
        for budget in (N_COARSE, 400, 777, N_VERTICES):
            positions, triangles = read_ply(self.mesh_of("--vertices", budget))
            self.assertIn(budget - len(positions), (0, 1, 2))
            self.assertIsNone(fault_of_manifold(len(positions), triangles))

    def test_more_vertices_are_nearer_to_the_surface(self):
        radii_of_a_diagonal = 2 * math.sqrt(3)
        errors = []
        for budget in (N_COARSE, 700, N_VERTICES):
            told = must("compare", self.mesh_of("--vertices", budget), surface(), "--json").stdout
            errors.append(json.loads(told)["mean"] * radii_of_a_diagonal)
            # The best triangles are 0.47 / n radii off, root mean square (tests/unit/encoding/encode_mesh_test.cpp).
            self.assertLess(errors[-1], 1 / budget)
        self.assertLess(errors[0], 0.5 / N_COARSE)
        self.assertEqual(errors, sorted(errors, reverse=True))

    def test_a_distortion_budget_is_in_squared_grid_units(self):
        told = json.loads(must("info", self.model, "--json").stdout)
        base = next(frame for frame in told["frames"] if frame["type"] == "base")
        wanted = base["distortion"] / 4
        told_by_compare = json.loads(must("compare", self.mesh_of("--distortion", wanted), surface(), "--json").stdout)
        diagonal = 2 * 3**0.5 * 1.0  # of the sphere's box, in its radii; the box's side is 1 / 1.08 of the grid's
        grid_units = told_by_compare["mean"] * diagonal / (2 * 1.08) * (2 ** told["grid_bits"] - 1)
        self.assertLess(grid_units, wanted**0.5)  # the mean distance is at most the root mean square one

    def test_one_thread_and_two_give_the_same_bytes(self):
        logs = [encode(f"encoded{n}", "--quiet", "--threads", n)[0].read_bytes() for n in (1, 2)]
        self.assertEqual(logs[0], logs[1])

    def test_quiet_says_nothing_and_otherwise_the_summary_tells_the_size(self):
        _, quiet = encode("quiet_encoded", "--quiet")
        self.assertEqual((quiet.stdout, quiet.stderr), ("", ""))
        model, done = encode("told_encoded")
        self.assertIn(f"{N_VERTICES} vertices, {model.stat().st_size} bytes", done.stderr)

    def test_an_interrupt_leaves_a_valid_model(self):
        model = scratch() / "interrupted_encoding.arl"
        command = [ANYRATE, "encode-mesh", surface(), "-o", model, "--vertices", MANY]
        with subprocess.Popen([*map(str, command)], stderr=subprocess.PIPE, text=True) as process:
            live = model.with_name(model.name + ".part")
            while process.poll() is None:
                told = anyrate("info", live, "--json")
                if told.returncode == 0 and any(f["type"] == "refine" for f in json.loads(told.stdout)["frames"]):
                    break
                time.sleep(0.05)
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=300)
        self.assertEqual(process.returncode, 1, said)
        self.assertIn("interrupted", said)
        must("verify", model)
        self.assertEqual(list(scratch().glob("interrupted_encoding.arl.part*")), [])


class BadInput(unittest.TestCase):
    def assert_refused(self, mesh, expected, *options):
        model = scratch() / "refused.arl"
        done = anyrate("encode-mesh", mesh, "-o", model, *options)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn(expected, done.stderr)
        self.assertEqual(list(scratch().glob("refused.arl*")), [])

    def test_a_missing_file(self):
        self.assert_refused(scratch() / "nowhere.ply", "no such file")

    def test_another_format(self):
        file = scratch() / "mesh.stl"
        file.write_text("solid\n")
        self.assert_refused(file, ".stl")

    def test_a_surface_with_a_hole(self):
        positions, triangles = read_ply(surface())
        self.assert_refused(write_obj("hole", positions, triangles[1:]), "3 edges of one face")

    def test_two_pieces(self):
        positions, triangles = read_ply(surface())
        both = positions + [(x + 10, y, z) for x, y, z in positions]
        moved = [tuple(i + len(positions) for i in t) for t in triangles]
        self.assert_refused(write_obj("two", both, triangles + moved), "expected one piece, found 2")

    def test_a_doubled_face(self):
        positions, triangles = read_ply(surface())
        self.assert_refused(write_obj("doubled", positions, [*triangles, triangles[5]]), "more than two faces")

    def test_too_few_vertices(self):
        self.assert_refused(surface(), "expected a number from 100", "--vertices", 50)
        self.assert_refused(surface(), "no fewer than coarse", "--vertices", 500, "--coarse", 600)

    def test_wrong_usage(self):
        self.assertEqual(anyrate("encode-mesh", surface()).returncode, 2)
        self.assertEqual(anyrate("encode-mesh", surface(), "-o", scratch() / "a.arl", "--vertices", 0).returncode, 2)


class Scan(unittest.TestCase):
    def test_a_scanned_bust_takes_less_than_twenty_bits_a_vertex(self):
        bust = SHARED / "data" / "nefertiti" / "gt.ply"
        if not bust.exists():
            self.skipTest(f"no shared captures at {SHARED}")
        model = scratch() / "bust.arl"
        must("encode-mesh", bust, "-o", model, "--vertices", 5000, "--quiet")
        must("verify", model)
        self.assertLess(8 * model.stat().st_size, 20 * 5000)  # bits


if __name__ == "__main__":
    unittest.main()
