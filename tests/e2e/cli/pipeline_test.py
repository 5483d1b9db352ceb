"""Photographs in, meshes at any budget out: simulate, reconstruct, verify, info, decode, compare."""
import json
import shutil
import unittest
import zipfile

from support import (
    N_COARSE,
    N_VERTICES,
    anyrate,
    capture,
    copy_of_capture,
    fault_of_manifold,
    model,
    must,
    read_ply,
    reconstruct_arguments,
    scratch,
)


def info(file):
    return json.loads(must("info", file, "--json").stdout)


def decoded(file, *budget):
    """(number of vertices, triangles, bytes of the file) of the mesh at a budget."""
    mesh = scratch() / "decoded.ply"
    must("decode", file, "-o", mesh, *budget)
    positions, triangles = read_ply(mesh)
    return len(positions), triangles, mesh.read_bytes()


class Simulate(unittest.TestCase):
    def test_a_capture_has_images_masks_cameras_and_the_true_surface(self):
        listed = json.loads((capture() / "cameras.json").read_text())["images"]
        self.assertEqual(len(listed), 12)
        for entry in listed:
            self.assertTrue((capture() / entry["file"]).is_file())
            self.assertTrue((capture() / entry["mask"]).is_file())
        positions, triangles = read_ply(capture() / "gt.ply")
        self.assertIsNone(fault_of_manifold(len(positions), triangles))

    def test_a_mesh_file_can_be_photographed_too(self):
        folder = scratch() / "photographed_mesh"
        size = ["--views", 3, "--width", 64, "--height", 48]
        must("simulate", "--mesh", capture() / "gt.ply", "-o", folder, *size)
        self.assertEqual(len(list((folder / "images").iterdir())), 3)


class Reconstruct(unittest.TestCase):
    def test_the_log_verifies(self):
        self.assertIn("every checksum", must("verify", model()).stdout)

    def test_the_temporary_log_is_gone(self):
        model()
        self.assertEqual(list(scratch().glob("*.part*")), [])

    def test_the_coarse_mesh_meets_its_count_within_two_percent(self):
        first = info(model())["frames"][0 if info(model())["frames"][0]["type"] == "base" else 1]
        self.assertEqual(first["type"], "base")
        self.assertLessEqual(abs(first["vertices"] - N_COARSE), 0.02 * N_COARSE)

    def test_info_tiles_the_file_with_frames(self):
        told = info(model())
        self.assertEqual(told["bytes"], model().stat().st_size)
        end = told["header_bytes"]
        for frame in told["frames"]:
            self.assertEqual(frame["end"] - frame["bytes"], end)
            end = frame["end"]
        self.assertEqual(end, told["bytes"])
        self.assertEqual(told["frames"][-1]["type"], "end")

    def test_the_report_tells_the_curve(self):
        model()
        report = json.loads((scratch() / "model.json").read_text())
        self.assertEqual(report["method"], "refine")
        self.assertEqual(
            sorted(report["seconds"]), ["encode", "hull", "optimise", "poisson", "refine", "remesh", "total"]
        )
        self.assertGreater(report["peak_memory_bytes"], 0)
        ends = {frame["end"] for frame in info(model())["frames"]}
        curve = report["curve"]
        self.assertGreater(len(curve), 2)
        for before, after in zip(curve, curve[1:]):
            self.assertLess(before["vertices"], after["vertices"])
            self.assertLessEqual(before["bytes"], after["bytes"])
        for point in curve:
            self.assertIn(point["bytes"], ends)
        self.assertLess(curve[-1]["psi"], curve[0]["psi"])
        self.assertEqual(report["final"]["bytes"], model().stat().st_size)
        self.assertFalse(report["final"]["stopped"])

    def test_one_thread_and_two_give_the_same_bytes(self):
        logs = []
        for n_threads in (1, 2):
            file = scratch() / f"threads{n_threads}.arl"
            must(*reconstruct_arguments(capture(), file), "--threads", n_threads)
            logs.append(file.read_bytes())
        self.assertEqual(logs[0], logs[1])

    def test_a_zip_gives_the_same_bytes_as_its_folder(self):
        archive = scratch() / "capture.zip"
        with zipfile.ZipFile(archive, "w") as zipped:
            for file in sorted(capture().rglob("*")):
                zipped.write(file, file.relative_to(capture()))
        file = scratch() / "zipped.arl"
        must(*reconstruct_arguments(archive, file))
        self.assertEqual(file.read_bytes(), model().read_bytes())

    def test_cameras_names_another_camera_file(self):
        folder = copy_of_capture("renamed_cameras")
        (folder / "cameras.json").rename(folder / "second_circle.json")
        file = scratch() / "renamed.arl"
        must(*reconstruct_arguments(folder, file), "--cameras", "second_circle.json")
        self.assertEqual(file.read_bytes(), model().read_bytes())

    def test_quiet_says_nothing(self):
        done = must(*reconstruct_arguments(capture(), scratch() / "quiet.arl"), "--quiet", "--method", "uniform")
        self.assertEqual((done.stdout, done.stderr), ("", ""))

    def test_surface_flow_alone_ends_at_the_full_count(self):
        file = scratch() / "flow.arl"
        must(*reconstruct_arguments(capture(), file), "--method", "flow")
        n_vertices, triangles, _ = decoded(file)
        self.assertLessEqual(abs(n_vertices - N_VERTICES), 0.02 * N_VERTICES)
        self.assertIsNone(fault_of_manifold(n_vertices, triangles))

    def test_the_surface_flow_reports_psi_of_every_iteration_for_both_samplings(self):
        first = []
        for sampling in ("adaptive", "uniform"):
            file, report = scratch() / f"{sampling}.arl", scratch() / f"{sampling}.json"
            must(*reconstruct_arguments(capture(), file), "--method", "flow", "--sampling", sampling, "--samples-per-px", 0.2,
                 "--report", report)
            psi = json.loads(report.read_text())["iterations"]
            self.assertGreater(len(psi), 3)
            self.assertLess(min(psi), psi[0])
            first.append(psi[0])
        self.assertEqual(*first)  # the same surface, measured the same way


class Decode(unittest.TestCase):
    def test_every_vertex_budget_is_a_closed_manifold_just_below_it(self):
        for budget in range(N_COARSE + 50, N_VERTICES, 97):
            with self.subTest(budget=budget):
                n_vertices, triangles, _ = decoded(model(), "--vertices", budget)
                self.assertIn(n_vertices, range(budget - 2, budget + 1))
                self.assertIsNone(fault_of_manifold(n_vertices, triangles))

    def test_a_byte_budget_is_the_mesh_of_that_prefix(self):
        log = model().read_bytes()
        colour_frames = [frame for frame in info(model())["frames"] if frame["type"] == "colour"]
        for frame in colour_frames:
            prefix = scratch() / "prefix.arl"
            prefix.write_bytes(log[: frame["end"]])
            self.assertEqual(decoded(prefix)[2], decoded(model(), "--bytes", frame["end"])[2])
            self.assertEqual(decoded(prefix)[0], frame["vertices"])

    def test_a_log_cut_inside_a_frame_gives_the_frames_before_and_says_so(self):
        last = [frame for frame in info(model())["frames"] if frame["type"] == "refine"][-1]
        cut = scratch() / "cut.arl"
        cut.write_bytes(model().read_bytes()[: last["end"] - 1])
        sentence = f"cut inside the frame at offset {last['end'] - last['bytes']}"
        self.assertIn(sentence, must("decode", cut, "-o", scratch() / "cut.ply").stderr)
        told = must("info", cut, "--json")
        self.assertIn(sentence, told.stderr)
        self.assertEqual(json.loads(told.stdout)["whole_bytes"], last["end"] - last["bytes"])
        refused = anyrate("verify", cut)
        self.assertEqual(refused.returncode, 3)
        self.assertIn(sentence, refused.stderr)
        n_vertices, triangles, _ = decoded(cut)
        self.assertLess(n_vertices, last["vertices"])
        self.assertGreaterEqual(n_vertices, N_COARSE * 0.98)
        self.assertIsNone(fault_of_manifold(n_vertices, triangles))

    def test_a_prefix_that_ends_at_a_frame_is_a_model_without_complaint(self):
        prefix = scratch() / "whole_frames.arl"
        for frame in info(model())["frames"]:
            if frame["type"] not in ("refine", "colour"):
                continue
            prefix.write_bytes(model().read_bytes()[: frame["end"]])
            must("verify", prefix)
            self.assertEqual(must("info", prefix, "--json").stderr, "")
            self.assertEqual(decoded(prefix)[0], frame["vertices"])

    def test_a_log_without_its_base_is_bad_input(self):
        base = next(frame for frame in info(model())["frames"] if frame["type"] == "base")
        for n_bytes in (0, 50, base["end"] - base["bytes"], base["end"] - 1):
            cut = scratch() / "no_base.arl"
            cut.write_bytes(model().read_bytes()[:n_bytes])
            self.assertEqual(anyrate("decode", cut, "-o", scratch() / "no_base.ply").returncode, 3)

    def test_the_standard_input_will_do(self):
        log = model().read_bytes()
        must("decode", "-", "-o", scratch() / "stdin.ply", "--vertices", 1000, stdin=log)
        self.assertEqual((scratch() / "stdin.ply").read_bytes(), decoded(model(), "--vertices", 1000)[2])
        self.assertIn("every checksum", must("verify", "-", stdin=log).stdout)
        self.assertEqual(json.loads(must("info", "-", "--json", stdin=log).stdout), info(model()))
        self.assertIn("standard input: cut inside", must("decode", "-", "-o", scratch() / "a.ply", stdin=log[:-30]).stderr)
        self.assertEqual(anyrate("decode", "-", "-o", scratch() / "a.ply", stdin=b"nothing").returncode, 3)

    def test_a_distortion_budget_takes_the_first_frame_that_reaches_it(self):
        rows = [frame for frame in info(model())["frames"] if frame["distortion"] is not None]
        for wanted in rows:
            first = next(row for row in rows if row["distortion"] <= wanted["distortion"])
            self.assertEqual(decoded(model(), "--distortion", wanted["distortion"])[0], first["vertices"])

    def test_a_glb_compressed_by_draco_is_a_fifth(self):
        sizes = []
        for flags in ([], ["--draco"]):
            file = scratch() / "size.glb"
            must("decode", model(), "-o", file, *flags)
            sizes.append(file.stat().st_size)
        self.assertLess(5 * sizes[1], sizes[0])

    def test_obj_and_glb_are_written_too(self):
        for name, first in (("mesh.obj", None), ("mesh.glb", b"glTF")):
            file = scratch() / name
            must("decode", model(), "-o", file, "--vertices", 1000)
            self.assertGreater(file.stat().st_size, 10_000)
            if first:
                self.assertEqual(file.read_bytes()[:4], first)


class Compare(unittest.TestCase):
    def compare(self, mesh):
        return json.loads(must("compare", mesh, capture() / "gt.ply", "--capture", capture(), "--json").stdout)

    def test_a_surface_is_at_no_distance_from_itself(self):
        told = self.compare(capture() / "gt.ply")
        self.assertLess(told["hausdorff"], 1e-6)
        self.assertLess(told["seen"]["hausdorff"], 1e-6)

    def test_the_reconstruction_is_near_the_true_surface(self):
        mesh = scratch() / "compared.ply"
        must("decode", model(), "-o", mesh)
        told = self.compare(mesh)
        self.assertTrue(told["closed_manifold"])
        self.assertEqual(told["euler"], 2)
        self.assertLess(told["seen"]["mean"], 0.01)  # of the diagonal; one pixel of the images is 0.004 of it
        self.assertLessEqual(told["seen"]["hausdorff"], told["hausdorff"])


class Verify(unittest.TestCase):
    def test_one_changed_byte_is_found_wherever_it_is(self):
        log = model().read_bytes()
        damaged = scratch() / "damaged.arl"
        for position in range(0, len(log), max(1, len(log) // 23)):
            with self.subTest(position=position):
                shutil.copy(model(), damaged)
                with open(damaged, "r+b") as file:
                    file.seek(position)
                    file.write(bytes([log[position] ^ 0x10]))
                self.assertEqual(anyrate("verify", damaged).returncode, 3)

    def test_what_is_no_log_is_refused(self):
        for command in (["verify"], ["info"], ["decode", "-o", scratch() / "never.ply"]):
            done = anyrate(*command, capture() / "gt.ply")
            self.assertEqual(done.returncode, 3)
            done = anyrate(*command, scratch() / "missing.arl")
            self.assertEqual(done.returncode, 3)
            self.assertIn("missing.arl", done.stderr)
            self.assertIn("no file", anyrate(*command, scratch()).stderr)
            self.assertIn("expected the magic bytes", anyrate(*command, "-", stdin=b"nothing").stderr)
            self.assertIn("expected 96 bytes, got 0", anyrate(*command, "-", stdin=b"").stderr)
        self.assertFalse((scratch() / "never.ply").exists())


if __name__ == "__main__":
    unittest.main()
