"""What an operator does: backups of a working server, clearing, limits of a job."""

import time
import unittest

from harness import PATIENCE, Server, ServerTest, run

JOB = "?vertices=8000&coarse=600"


class Operations(ServerTest):
    def test_a_backup_of_a_working_server_can_be_served_and_goes_on_with_its_jobs(self):
        done = self.make_finished_model()
        running = self.make_model(JOB)
        self.server.wait_for(running, lambda model: len(model["curve"]) >= 2)
        copy = self.folder / "copy"
        self.assertIn("2 models", run("backup", "--data", self.server.data, "-o", copy).stdout)
        self.assertEqual(self.server.wait_until_final(running)["state"], "done")
        other = Server(copy)
        try:
            self.assertEqual(other.sealed(done).read_bytes(), self.server.sealed(done).read_bytes())
            self.assertEqual(other.wait_until_final(running)["state"], "done")
            self.assertEqual(other.sealed(running).read_bytes(), self.server.sealed(running).read_bytes())
        finally:
            self.assertEqual(other.stop(), 0)

    def test_a_backup_replaces_nothing(self):
        self.assertEqual(run("backup", "--data", self.server.data, "-o", self.folder, check=False).returncode, 3)
        self.assertEqual(run("backup", "--data", self.folder / "nothing", "-o", self.folder / "x", check=False).returncode, 3)

    def test_gc_removes_what_it_is_told_to_and_only_says_so_in_a_dry_run(self):
        model_id = self.make_finished_model()
        self.assertIn("removed 0 models", run("gc", "--data", self.server.data).stdout)
        dry = run("gc", "--data", self.server.data, "--keep-mb", 0, "--dry-run").stdout
        self.assertIn(f"model {model_id}", dry)
        self.assertIn("would remove 1 models", dry)
        self.assertEqual(self.server.request("GET", f"/v1/models/{model_id}")[0], 200)
        self.assertEqual(self.server.request("GET", f"/v1/models/{model_id}/log")[0], 200)  # the server keeps it in memory
        self.assertIn("removed 1 models", run("gc", "--data", self.server.data, "--keep-days", 0).stdout)
        self.assertEqual(self.server.request("GET", f"/v1/models/{model_id}")[0], 404)
        self.assertFalse((self.server.data / "models" / model_id).exists())
        deadline = time.monotonic() + PATIENCE
        while self.server.request("GET", f"/v1/models/{model_id}/log")[0] != 404:
            self.assertLess(time.monotonic(), deadline, "a server serves what another process has removed")
            time.sleep(0.2)

    def test_a_model_is_deleted_at_any_moment_and_leaves_nothing(self):
        for pause in (0, 0.1, 0.4, 1.0, 2.0):
            model_id = self.make_model(JOB)
            time.sleep(pause)
            self.assertEqual(self.server.request("DELETE", f"/v1/models/{model_id}")[0], 204)
            self.assertEqual(self.server.request("GET", f"/v1/models/{model_id}")[0], 404)
            self.assertFalse((self.server.data / "models" / model_id).exists())
            self.assertEqual(self.server.worker_pids(), [])
        self.make_finished_model("?vertices=500")


class Limits(ServerTest):
    server_options = ("--worker-memory", "40")

    def test_a_job_that_needs_more_memory_than_allowed_fails_with_a_sentence_and_harms_nobody(self):
        model_id = self.make_model(JOB)
        model = self.server.wait_until_final(model_id)
        self.assertEqual(model["state"], "failed")
        self.assertIn("memory", model["error"])
        self.assertEqual(self.server.request("GET", "/healthz")[0], 200)


class TimeLimit(ServerTest):
    server_options = ("--job-minutes", "0.005")

    def test_a_job_that_takes_longer_than_allowed_fails_with_a_sentence(self):
        model = self.server.wait_until_final(self.make_model(JOB))
        self.assertEqual((model["state"], model["attempts"]), ("failed", 1))
        self.assertIn("longer than the server allows", model["error"])


class KeepRule(ServerTest):
    server_options = ("--keep-mb", "0")

    def test_a_server_with_a_quota_clears_by_itself(self):
        model_id = self.make_model("?vertices=500")
        self.server.wait_for(model_id, lambda model: model["state"] in ("running", "done"))
        deadline = time.monotonic() + 120
        while time.monotonic() < deadline and self.server.request("GET", f"/v1/models/{model_id}")[0] != 404:
            time.sleep(0.2)
        self.assertEqual(self.server.request("GET", f"/v1/models/{model_id}")[0], 404)


if __name__ == "__main__":
    unittest.main()
