"""Workers and servers are killed; no job is lost."""

import os
import shutil
import signal
import time
import unittest
from pathlib import Path

from harness import Server, ServerTest, WebSocket, run

JOB = "?vertices=8000&coarse=600"
GONE = (None, "X", "Z")  # no such process, or one that is dead and waits for whoever inherited it to ask how it ended


def process_state(pid):
    """The letter that /proc/PID/stat has for it; None: there is no such process."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return None
    return stat.rsplit(")", 1)[1].split()[0]


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

    def test_a_killed_workers_job_goes_on_behind_its_last_frame_and_readers_keep_theirs(self):
        model_id = self.make_model(JOB)
        stream = WebSocket(self.server, f"/v1/models/{model_id}/live")
        reached = self.server.wait_for(model_id, lambda model: len(model["curve"]) >= 4)
        self.kill_worker()
        self.server.wait_for(model_id, lambda model: model["attempts"] == 2)
        self.assertGreaterEqual(len(self.server.model(model_id)["curve"]), len(reached["curve"]) - 1)
        hellos, log, _ = stream.read_to_end()
        # The preview's, if there was one, and the model's: the second worker began nothing anew.
        ids = [message["log_id"] for message in hellos if message["type"] == "hello"]
        self.assertEqual(len(set(ids)), len(ids))
        self.assertLessEqual(len(ids), 2)
        self.expect_done(model_id, attempts=2)
        self.assertEqual(log, self.server.live(model_id).read_bytes())
        curve = [point["bytes"] for point in self.server.model(model_id)["curve"]]
        self.assertEqual(curve, sorted(set(curve)), "no batch was made twice")

    def test_the_model_of_a_killed_worker_is_that_of_an_undisturbed_one(self):
        model_id = self.running_model()
        capture = self.server.data / "models" / model_id / "capture.zip"
        calm = self.folder / "calm" / "models" / model_id
        calm.mkdir(parents=True)
        shutil.copy(capture, calm)
        self.kill_worker()
        self.expect_done(model_id, attempts=2)
        run("worker", "--data", self.folder / "calm", "--model", model_id, "--vertices", 8000, "--coarse", 600)
        self.assertEqual((calm / "model.arl").read_bytes(), self.server.sealed(model_id).read_bytes())

    def test_a_worker_without_the_latest_lease_changes_nothing(self):
        model_id = self.make_finished_model()
        folder = self.server.data / "models" / model_id
        before = {file.name: file.read_bytes() for file in folder.iterdir()}
        (folder / "model.arl").unlink()
        done = run("worker", "--data", self.server.data, "--model", model_id, "--epoch", 0, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("stopped", done.stdout)
        (folder / "model.arl").write_bytes(before["model.arl"])
        self.assertEqual({file.name: file.read_bytes() for file in folder.iterdir()}, before)

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
            self.assertIn(process_state(pid), GONE, "the old worker died with its server")

    def test_a_stopped_server_gives_the_job_back_without_counting_the_attempt(self):
        model_id = self.running_model()
        begun = time.monotonic()
        self.assertEqual(self.server.stop(), 0)
        self.assertLess(time.monotonic() - begun, 60)
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
