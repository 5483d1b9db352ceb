"""The live stream: whoever joins, whenever, ends with the sealed model."""

import json
import subprocess
import unittest

from harness import ANYRATE, grey_png, PATIENCE, run, ServerTest, WebSocket

HEADER_BYTES = 96
LONG_JOB = "?vertices=8000&coarse=600"


class Live(ServerTest):
    def live_index(self, model_id):
        return json.loads(self.server.request("GET", f"/v1/models/{model_id}/index?form=live",
                                              headers={"Accept": "application/json"})[2])

    def live_rows(self, model_id):
        """One for each frame that live clients get."""
        return self.live_index(model_id)["rows"]

    def frames_of(self, model_id):
        """Frames of the live log, from the base on."""
        return self.server.live(model_id).read_bytes()[HEADER_BYTES:]

    def test_a_client_that_joins_in_the_middle_ends_with_the_same_model(self):
        model_id = self.make_model(LONG_JOB)
        self.server.wait_for(model_id, lambda model: len(model["curve"]) >= 2)
        whole, mesh = self.folder / "live.arl", self.folder / "live.ply"
        joined = [subprocess.Popen([ANYRATE, "fetch", self.url(model_id), "--live", "-o", output, *budget])
                  for output, budget in ((whole, []), (mesh, ["--vertices", "5000"]))]
        websocket = WebSocket(self.server, f"/v1/models/{model_id}/live")
        texts, log, code = websocket.read_to_end()
        websocket.close()
        self.assertEqual([client.wait(PATIENCE) for client in joined], [0, 0])

        self.assertEqual(self.server.model(model_id)["state"], "done")
        self.assertEqual(whole.read_bytes(), self.server.sealed(model_id).read_bytes())
        run("decode", self.server.sealed(model_id), "-o", self.folder / "decoded.ply", "--vertices", 5000)
        self.assertEqual(mesh.read_bytes(), (self.folder / "decoded.ply").read_bytes())

        self.assertEqual((texts[0]["type"], texts[0]["sealed"], texts[0]["next_sequence"]), ("hello", False, 0))
        self.assertEqual((texts[-1], code), ({"type": "end", "state": "done"}, 1000))
        self.assertEqual(log[HEADER_BYTES:], self.frames_of(model_id))

    def test_a_client_that_waits_from_the_start_gets_everything(self):
        model_id = self.make_model()
        websocket = WebSocket(self.server, f"/v1/models/{model_id}/live")
        texts, log, code = websocket.read_to_end()
        websocket.close()
        self.assertEqual((log[HEADER_BYTES:], code), (self.frames_of(model_id), 1000))
        ids = [text["log_id"] for text in texts if text["type"] == "hello"]
        self.assertEqual((ids[-1], len(set(ids))), (self.live_index(model_id)["log_id"], len(ids)))

    def test_a_preview_is_there_before_the_model_and_gives_way_to_it(self):
        model_id = self.make_model()
        trace = self.folder / "trace.json"
        follower = subprocess.Popen([ANYRATE, "fetch", self.url(model_id), "--live", "-o", self.folder / "live.arl",
                                     "--trace", trace])
        model = self.server.wait_for(model_id, lambda model: model["vertices"] > 0)
        self.assertEqual(model["curve"], [])
        status, _, preview = self.server.request("GET", f"/v1/models/{model_id}/mesh.obj")
        self.assertEqual(status, 200)
        self.assertGreater(preview.count(b"\nv "), 100)
        self.assertEqual(follower.wait(PATIENCE), 0)
        self.assertEqual((self.folder / "live.arl").read_bytes(), self.server.sealed(model_id).read_bytes())
        told = json.loads(trace.read_text())
        self.assertEqual(len(told["replaced"]), 1)
        self.assertLess(told["replaced"][0]["seconds"], told["frames"][0]["seconds"])

    def test_resume_goes_on_at_any_frame(self):
        model_id = self.make_finished_model()
        rows = self.live_rows(model_id)
        frames = self.frames_of(model_id)
        for sequence in range(1, len(rows) + 1):
            with self.subTest(sequence=sequence):
                websocket = WebSocket(self.server, f"/v1/models/{model_id}/live?from={sequence}")
                texts, log, _ = websocket.read_to_end()
                websocket.close()
                self.assertEqual(texts[0]["next_sequence"], sequence)
                self.assertEqual(log, frames[rows[sequence - 1]["end"]:])

    def test_a_budget_ends_the_stream_at_its_prefix(self):
        model_id = self.make_finished_model()
        enough = next(row for row in self.live_rows(model_id) if row["vertices"] >= 1198)
        end = max(row["end"] for row in self.live_rows(model_id) if row["vertices"] == enough["vertices"])
        websocket = WebSocket(self.server, f"/v1/models/{model_id}/live?vertices=1200")
        _, log, code = websocket.read_to_end()
        websocket.close()
        self.assertEqual((log[HEADER_BYTES:], code), (self.frames_of(model_id)[:end], 1000))

    def test_a_client_cut_off_before_the_model_is_sealed_resumes_after_it(self):
        model_id = self.make_model()
        self.server.wait_for(model_id, lambda model: model["curve"])  # what comes before is a preview
        websocket = WebSocket(self.server, f"/v1/models/{model_id}/live")
        log = b""
        while len(log) <= HEADER_BYTES:
            kind, payload = websocket.read()
            log += payload if kind == "binary" else b""
        websocket.close()
        self.assertEqual(self.server.wait_until_final(model_id)["state"], "done")
        rows = self.live_rows(model_id)
        n_received = sum(HEADER_BYTES + row["end"] <= len(log) for row in rows)
        websocket = WebSocket(self.server, f"/v1/models/{model_id}/live?from={n_received}")
        _, rest, code = websocket.read_to_end()
        websocket.close()
        self.assertEqual(code, 1000)
        whole = self.folder / "whole.arl"
        whole.write_bytes(log + rest)
        run("verify", whole)
        self.assertEqual((log + rest)[HEADER_BYTES:], self.frames_of(model_id))

    def test_a_budget_of_a_growing_model_takes_its_side_index_and_one_range(self):
        model_id = self.make_model("?vertices=100000&coarse=2500")
        self.server.wait_for(model_id, lambda model: len(model["curve"]) >= 3)
        part = self.folder / "part.arl"
        run("fetch", self.url(model_id), "-o", part, "--vertices", 2700, "--trace", self.folder / "trace.json")
        requests = json.loads((self.folder / "trace.json").read_text())["requests"]
        path = f"/v1/models/{model_id}"
        self.assertEqual([request["target"] for request in requests],
                         [path + "/log", path + "/index?form=live", path + "/log"])
        self.assertEqual([request["range"] for request in requests],
                         ["bytes=0-8191", "", f"bytes=8192-{part.stat().st_size - 1}"])
        self.assertEqual(part.read_bytes(), self.server.live(model_id).read_bytes()[:part.stat().st_size])
        run("verify", part)

    def test_a_paused_client_gets_nothing_until_it_goes_on(self):
        model_id = self.make_model(LONG_JOB)
        websocket = WebSocket(self.server, f"/v1/models/{model_id}/live")
        websocket.send('{"pause": true}')
        self.server.wait_until_final(model_id)
        while not websocket.is_silent(0.5):  # what was on its way before the pause
            self.assertNotEqual(websocket.read()[0], "close")
        websocket.send('{"pause": false}')
        texts, _, code = websocket.read_to_end()
        websocket.close()
        self.assertEqual((texts[-1]["type"], code), ("end", 1000))

    def test_a_client_of_a_failed_model_is_told_why(self):
        status, _, body = self.post(body=self.changed_zip(masks__003=grey_png(160, 120, 0)))  # which only decoding tells
        self.assertEqual(status, 202, body)
        websocket = WebSocket(self.server, f"/v1/models/{json.loads(body)['id']}/live")
        texts, log, code = websocket.read_to_end()
        websocket.close()
        self.assertEqual((texts[-1]["state"], log, code), ("failed", b"", 1000))
        self.assertTrue(texts[-1]["error"])

    def test_events_tell_each_state_and_end(self):
        model_id = self.make_model()
        status, headers, body = self.server.request("GET", f"/v1/models/{model_id}/events")
        self.assertEqual((status, headers["Content-Type"]), (200, "text/event-stream"))
        states = [json.loads(line[6:])["state"] for line in body.decode().splitlines() if line.startswith("data: ")]
        self.assertEqual(states[-1], "done")
        self.assertIn("running", states)

    def test_a_stopping_server_closes_live_clients(self):
        model_id = self.make_model(LONG_JOB)
        websocket = WebSocket(self.server, f"/v1/models/{model_id}/live")
        self.assertEqual(self.server.stop(), 0)
        _, _, code = websocket.read_to_end()
        websocket.close()
        self.assertEqual(code, 1001)


if __name__ == "__main__":
    unittest.main()
