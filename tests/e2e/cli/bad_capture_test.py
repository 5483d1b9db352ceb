"""Exit code 3: every kind of bad capture is refused with a sentence that names the file and what was expected."""
import json
import unittest
import zipfile

from support import anyrate, copy_of_capture, png, scratch


class BadCapture(unittest.TestCase):
    def setUp(self):
        self.folder = copy_of_capture(self.id().rpartition(".")[2])
        self.list = json.loads((self.folder / "cameras.json").read_text())
        self.first = self.list["images"][0]

    def save_list(self):
        (self.folder / "cameras.json").write_text(json.dumps(self.list))

    def assert_refused(self, *words, source=None):
        model = scratch() / "never.arl"
        done = anyrate("reconstruct", source or self.folder, "-o", model, "--coarse", 300, "--vertices", 600)
        self.assertEqual(done.returncode, 3, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertEqual(list(scratch().glob("never.arl*")), [])

    def test_no_capture(self):
        self.assert_refused("nowhere", "expected", source=scratch() / "nowhere")

    def test_no_camera_file(self):
        (self.folder / "cameras.json").unlink()
        self.assert_refused("cameras.json", "expected")

    def test_a_camera_file_that_is_no_json(self):
        (self.folder / "cameras.json").write_text('{"images": [')
        self.assert_refused("cameras.json", "JSON")

    def test_a_missing_image(self):
        (self.folder / self.first["file"]).unlink()
        self.assert_refused(self.first["file"], "missing")

    def test_a_missing_mask(self):
        (self.folder / self.first["mask"]).unlink()
        self.assert_refused(self.first["mask"], "expected")

    def test_an_image_of_another_size_than_its_camera(self):
        self.first["width"] += 1
        self.save_list()
        self.assert_refused(self.first["file"], "201", "200")

    def test_a_mask_of_another_size(self):
        (self.folder / self.first["mask"]).write_bytes(png(100, 75, [bytes([255] * 100)] * 75))
        self.assert_refused(self.first["mask"], "100x75", "200x150")

    def test_an_empty_mask(self):
        (self.folder / self.first["mask"]).write_bytes(png(200, 150, [bytes(200)] * 150))
        self.assert_refused(self.first["mask"], "empty")

    def test_a_singular_K(self):
        self.first["K"][0][0] = 0
        self.save_list()
        self.assert_refused(self.first["file"], "singular")

    def test_an_R_that_is_no_rotation(self):
        self.first["R"][0] = [2 * x for x in self.first["R"][0]]
        self.save_list()
        self.assert_refused(self.first["file"], "not a rotation")

    def test_an_R_that_is_a_reflection(self):
        self.first["R"][0] = [-x for x in self.first["R"][0]]
        self.save_list()
        self.assert_refused(self.first["file"], "reflection")

    def test_a_number_that_is_not_finite(self):
        self.first["t"][1] = float("nan")
        self.save_list()
        self.assert_refused("cameras.json", "NaN")

    def test_a_missing_number(self):
        self.first["t"].pop()
        self.save_list()
        self.assert_refused("cameras.json", "3 finite numbers")

    def test_a_camera_that_looks_away(self):
        turned = [[-x for x in self.first["R"][0]], self.first["R"][1], [-x for x in self.first["R"][2]]]
        self.first["R"] = turned
        self.first["t"] = [-self.first["t"][0], self.first["t"][1], -self.first["t"][2]]
        self.save_list()
        self.assert_refused(self.first["file"], "behind the camera")

    def test_two_views(self):
        del self.list["images"][2:]
        self.save_list()
        self.assert_refused("cameras.json", "2 views", "at least 3")

    def test_an_image_that_is_cut_off(self):
        file = self.folder / self.first["file"]
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
        self.assert_refused(self.first["file"], "cut off")

    def test_an_image_that_is_none(self):
        (self.folder / self.first["file"]).write_text("not a photograph")
        self.assert_refused(self.first["file"], "PNG")

    def test_an_image_over_the_pixel_limit(self):
        (self.folder / self.first["file"]).write_bytes(png(100_000, 100_000, []))
        self.first["width"] = self.first["height"] = 100_000
        self.save_list()
        self.assert_refused(self.first["file"], "100000x100000", "at most")

    def test_a_name_that_leaves_the_capture(self):
        self.first["file"] = "../secret.png"
        self.save_list()
        self.assert_refused("cameras.json", "inside the capture")

    def test_a_zip_that_is_none(self):
        archive = scratch() / "none.zip"
        archive.write_bytes(b"PK\x03\x04 but nothing else")
        self.assert_refused("none.zip", "expected", source=archive)

    def test_a_zip_with_a_name_that_leaves_it(self):
        archive = scratch() / "escaping.zip"
        with zipfile.ZipFile(archive, "w") as zipped:
            zipped.write(self.folder / "cameras.json", "../cameras.json")
        self.assert_refused("escaping.zip", "inside the capture", source=archive)

    def test_every_fault_has_its_own_line(self):
        (self.folder / self.first["file"]).unlink()
        self.list["images"][1]["K"][0][0] = 0
        self.save_list()
        self.assert_refused(self.first["file"] + ": missing", self.list["images"][1]["file"] + ": K is singular")

    def test_more_vertices_in_the_coarse_mesh_than_in_the_model(self):
        done = anyrate(
            "reconstruct", self.folder, "-o", scratch() / "never.arl", "--coarse", 2000, "--vertices", 1000
        )
        self.assertEqual(done.returncode, 3, done.stderr)


if __name__ == "__main__":
    unittest.main()
