"""Workers that compute on an OpenGL device; where no GPU is installed, on Mesa's llvmpipe."""
import unittest

from harness import Server, ServerTest


class GpuWorkers(ServerTest):
    def serve(self, *options, environment=None):
        """The server of the test with other options; what it and its workers say is read by said()."""
        self.server.stop()
        self.errors = open(self.folder / "errors", "w+", encoding="utf-8")
        self.addCleanup(self.errors.close)
        self.server = Server(self.folder / "data", *options, environment=environment, errors=self.errors)

    def said(self):
        return (self.folder / "errors").read_text(encoding="utf-8")

    def test_a_sandboxed_worker_makes_a_model_on_the_device(self):
        self.serve("--backend", "gpu")
        model_id = self.make_finished_model("?vertices=1200&coarse=600")
        self.assertGreaterEqual(self.server.model(model_id)["vertices"], 1190)
        self.assertIn("computing on ", self.said())
        self.assertNotIn("the GPU failed", self.said())
        self.assertNotIn("computing on the CPU", self.said())

    def test_without_a_driver_the_job_fails_with_the_reason(self):
        self.serve("--backend", "gpu", "--max-attempts", "1",
                   environment={"__EGL_VENDOR_LIBRARY_DIRS": "/nonexistent", "__EGL_VENDOR_LIBRARY_FILENAMES": ""})
        model_id = self.make_model("?vertices=1200&coarse=600")
        self.assertEqual(self.server.wait_until_final(model_id)["state"], "failed")
        self.assertIn("no driver is installed", self.said())


if __name__ == "__main__":
    unittest.main()
