"""Workers and servers are killed; no job is lost."""

import os
import signal
import time
import unittest

from harness import PATIENCE, Server, ServerTest, run

JOB = "?vertices=8000&coarse=600"


class Crash(ServerTest):
    def running_model(self):
        model_id = self.make_model(JOB)
        self.server.wait_for(model_id, lambda model: len(model["curve"]) >= 1)
        return model_id

    def kill_worker(self):
        for pid in self.server.worker_pids():
            os.kill(pid, signal.SIGKILL)

    def restart(self):
        self.server = Server(self.server.data)

    def expect_done(self, model_id, attempts):
        model = self.server.wait_until_final(model_id)
        self.assertEqual((model["state"], model["attempts"]), ("done", attempts), model)
        run("verify", self.server.sealed(model_id))

    def test_a_killed_worker_is_tried_again(self):
        model_id = self.running_model()
        self.kill_worker()
        self.expect_done(model_id, attempts=2)

    def test_a_worker_that_dies_every_time_fails_its_model_alone(self):
        model_id = self.make_model(JOB)
        for attempt in (1, 2, 3):
            self.server.wait_for(model_id, lambda model: model["attempts"] == attempt and self.server.worker_pids())
            self.kill_worker()
        model = self.server.wait_until_final(model_id)
        self.assertEqual(model["state"], "failed")
        self.assertIn("signal 9", model["error"])
        self.make_finished_model("?vertices=500")

    def test_a_killed_server_runs_the_job_again_at_its_start(self):
        model_id = self.running_model()
        workers = self.server.worker_pids()
        self.server.kill()
        self.restart()
        self.expect_done(model_id, attempts=2)
        for pid in workers:
            self.assertFalse(os.path.exists(f"/proc/{pid}"), "the old worker died with its server")

    def test_a_stopped_server_gives_the_job_back_without_counting_the_attempt(self):
        model_id = self.running_model()
        begun = time.monotonic()
        self.assertEqual(self.server.stop(), 0)
        self.assertLess(time.monotonic() - begun, PATIENCE / 2)
        self.restart()
        self.expect_done(model_id, attempts=1)

    def test_an_acknowledged_upload_outlives_the_server(self):
        models = [self.make_model("?vertices=500") for _ in range(3)]
        self.server.kill()
        self.restart()
        for model_id in models:
            self.assertEqual(self.server.wait_until_final(model_id)["state"], "done")

    def test_leftovers_are_removed_at_the_start(self):
        self.server.kill()
        (self.server.data / "uploads" / "half").write_bytes(b"PK")
        (self.server.data / "models" / ("b" * 26)).mkdir()
        self.restart()
        self.assertEqual(list((self.server.data / "uploads").iterdir()), [])
        self.assertEqual(list((self.server.data / "models").iterdir()), [])


if __name__ == "__main__":
    unittest.main()
