"""Exit code 2: wrong usage. Nothing is read or written."""
import unittest

from support import anyrate, scratch


class Usage(unittest.TestCase):
    def assert_wrong(self, *arguments):
        done = anyrate(*arguments)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertNotEqual(done.stderr.strip() + done.stdout.strip(), "")

    def test_no_subcommand(self):
        self.assert_wrong()

    def test_an_unknown_subcommand(self):
        self.assert_wrong("rebuild", "capture")

    def test_an_unknown_option(self):
        self.assert_wrong("info", "--yaml", "model.arl")

    def test_a_missing_output(self):
        self.assert_wrong("reconstruct", "capture")

    def test_two_budgets(self):
        self.assert_wrong("decode", "model.arl", "-o", "mesh.ply", "--vertices", 5000, "--bytes", 20000)

    def test_an_unknown_mesh_format(self):
        self.assert_wrong("decode", "model.arl", "-o", "mesh.stl")

    def test_compression_of_what_is_no_glb(self):
        self.assert_wrong("decode", "model.arl", "-o", "mesh.ply", "--draco")

    def test_a_name_that_is_none(self):
        for name in ("foo", 1):
            self.assert_wrong("reconstruct", "capture", "-o", "model.arl", "--method", name)
        told = anyrate("reconstruct", "capture", "-o", "model.arl", "--backend", "tpu")
        self.assertIn("--backend: expected auto|cpu|gpu, got tpu", told.stdout + told.stderr)

    def test_a_budget_of_zero(self):
        for option in ("--vertices", "--bytes"):
            self.assert_wrong("decode", "model.arl", "-o", "mesh.ply", option, 0)
        for number in (-1, "nan", "inf"):
            self.assert_wrong("decode", "model.arl", "-o", "mesh.ply", "--distortion", number)
        told = anyrate("decode", "model.arl", "-o", "mesh.ply", "--vertices", 0)
        self.assertIn("--vertices: expected a number above 0, got 0", told.stdout + told.stderr)

    def test_an_unknown_method(self):
        self.assert_wrong("reconstruct", "capture", "-o", "model.arl", "--method", "magic")

    def test_a_count_of_zero(self):
        self.assert_wrong("reconstruct", "capture", "-o", "model.arl", "--vertices", 0)

    def test_a_scene_and_a_mesh(self):
        self.assert_wrong("simulate", "--scene", "sphere", "--mesh", "mesh.ply", "-o", scratch() / "both")

    def test_neither_a_scene_nor_a_mesh(self):
        self.assert_wrong("simulate", "-o", scratch() / "neither")

    def test_an_unknown_scene(self):
        self.assert_wrong("simulate", "--scene", "dragon", "-o", scratch() / "dragon")

    def test_help_is_no_fault(self):
        done = anyrate("reconstruct", "--help")
        self.assertEqual(done.returncode, 0)
        self.assertIn("--vertices", done.stdout)


if __name__ == "__main__":
    unittest.main()
