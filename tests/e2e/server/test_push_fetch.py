"""Capture in over REST, mesh out at any budget: the bytes on the wire are the prefix and nothing more."""

import functools
import http.server
import json
import socket
import threading
import unittest

from harness import PATIENCE, ServerTest, run


class CountingProxy:
    """Passes connections on to a server and keeps what each side sent."""

    def __init__(self, target):
        self.target = target
        self.sent, self.received = b"", b""
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = "http://127.0.0.1:%d" % self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            upstream = socket.create_connection(self.target, timeout=PATIENCE)
            threading.Thread(target=self.pump, args=(client, upstream, "sent"), daemon=True).start()
            threading.Thread(target=self.pump, args=(upstream, client, "received"), daemon=True).start()

    def pump(self, source, sink, name):
        while piece := source.recv(65536):
            setattr(self, name, getattr(self, name) + piece)
            sink.sendall(piece)
        try:
            sink.shutdown(socket.SHUT_WR)
        except OSError:
            pass  # the other side is gone already

    def bodies(self):
        """Sizes of the bodies that came back, by their Content-Length."""
        return [int(line.split(b":")[1]) for line in self.received.split(b"\r\n")
                if line.lower().startswith(b"content-length:")]


class QuietFiles(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *arguments):
        pass


class PushFetch(ServerTest):
    def test_push_waits_and_prints_the_id(self):
        done = run("push", self.capture, "--server", self.server.url, "--wait", "--vertices", 1000)
        self.assertEqual(self.server.model(done.stdout.strip())["state"], "done")

    def test_push_of_a_bad_capture_fails_with_its_sentence(self):
        (self.folder / "bad" / "images").mkdir(parents=True)
        (self.folder / "bad" / "cameras.json").write_text("{}")
        done = run("push", self.folder / "bad", "--server", self.server.url, "--wait", check=False)
        self.assertEqual(done.returncode, 3)
        self.assertIn("cameras.json", done.stderr)
        self.assertEqual(self.server.request("GET", "/healthz")[0], 200)

    def test_fetched_meshes_and_logs(self):
        model_id = self.make_finished_model("?vertices=3000&coarse=800")
        sealed = self.server.sealed(model_id)
        log = sealed.read_bytes()
        for budget in (["--vertices", 1500], ["--bytes", 9000], ["--distortion", 1e9], []):
            for extension in ("ply", "obj", "glb"):
                with self.subTest(budget=budget, extension=extension):
                    fetched, decoded = (self.folder / f"{name}.{extension}" for name in ("fetched", "decoded"))
                    run("fetch", self.url(model_id), "-o", fetched, *budget)
                    run("decode", sealed, "-o", decoded, *budget)
                    self.assertEqual(fetched.read_bytes(), decoded.read_bytes())
        run("fetch", self.url(model_id), "-o", self.folder / "whole.arl")
        self.assertEqual((self.folder / "whole.arl").read_bytes(), log)
        run("fetch", self.url(model_id), "-o", self.folder / "part.arl", "--vertices", 2500)
        part = (self.folder / "part.arl").read_bytes()
        self.assertLess(len(part), len(log))
        self.assertEqual(part, log[:len(part)])

        with self.subTest("two requests, whose bodies are the prefix and nothing more"):
            proxy = CountingProxy(self.server.address)
            run("fetch", f"{proxy.url}/v1/models/{model_id}", "-o", self.folder / "counted.arl", "--vertices", 2500,
                "--trace", self.folder / "trace.json")
            self.assertGreater(len(part), 8192)  # or one request would do
            self.assertEqual(proxy.bodies(), [8192, len(part) - 8192])
            trace = json.loads((self.folder / "trace.json").read_text())
            self.assertEqual(trace["frames"][-1]["bytes"], len(part))
            self.check_requests(trace, f"/v1/models/{model_id}/log", len(part))
            for budget in (["--bytes", 9000], ["--distortion", 1e9], ["--vertices", 800]):
                run("fetch", self.url(model_id), "-o", self.folder / "traced.arl", *budget,
                    "--trace", self.folder / "trace.json")
                self.check_requests(json.loads((self.folder / "trace.json").read_text()), f"/v1/models/{model_id}/log",
                                    (self.folder / "traced.arl").stat().st_size)

        with self.subTest("prefixes by query are those that fetch takes"):
            status, headers, body = self.server.request("GET", f"/v1/models/{model_id}/log?vertices=2500")
            self.assertEqual((status, body), (200, part))
            self.assertIn("immutable", headers["Cache-Control"])

        with self.subTest("the mesh by HTTP is the decoded one"):
            _, _, mesh = self.server.request("GET", f"/v1/models/{model_id}/mesh.glb?vertices=2500")
            run("decode", sealed, "-o", self.folder / "d.glb", "--vertices", 2500)
            self.assertEqual(mesh, (self.folder / "d.glb").read_bytes())

        self.check_ranges(model_id, log)
        self.check_index(model_id, log)

    def check_requests(self, trace, target, n_bytes):
        """One request of 8 KB, and one for exactly the rest of a prefix of so many bytes."""
        expected = [{"target": target, "range": "bytes=0-8191", "bytes": 8192}]
        if n_bytes > 8192:
            expected.append({"target": target, "range": f"bytes=8192-{n_bytes - 1}", "bytes": n_bytes - 8192})
        self.assertEqual(trace["requests"], expected)

    def check_ranges(self, model_id, log):
        target = f"/v1/models/{model_id}/log"
        etag = self.server.request("HEAD", target)[1]["ETag"]
        cases = [
            ({"Range": "bytes=0-99"}, 206, log[:100]),
            ({"Range": "bytes=-7"}, 206, log[-7:]),
            ({"Range": "bytes=100-"}, 206, log[100:]),
            ({"Range": "bytes=5-5", "If-Range": etag}, 206, log[5:6]),
            ({"Range": "bytes=5-5", "If-Range": '"other"'}, 200, log),
            ({"If-None-Match": etag}, 304, b""),
            ({"Range": f"bytes={len(log)}-"}, 416, None),
        ]
        for headers, status, body in cases:
            with self.subTest(headers=headers):
                answer = self.server.request("GET", target, headers=headers)
                self.assertEqual(answer[0], status)
                if body is not None:
                    self.assertEqual(answer[2], body)
        status, headers, body = self.server.request("HEAD", target)
        self.assertEqual((status, int(headers["Content-Length"]), body), (200, len(log), b""))

    def check_index(self, model_id, log):
        target = f"/v1/models/{model_id}/index"
        _, _, body = self.server.request("GET", target, headers={"Accept": "application/json"})
        index = json.loads(body)
        self.assertEqual(index["bytes"], len(log))
        ends = [row["end"] for row in index["rows"]]
        self.assertEqual(ends, sorted(ends))
        _, _, side_index = self.server.request("GET", target)
        self.assertEqual(len(side_index), 24 + 16 * len(ends) + 4)

    def test_a_file_server_without_ranges_will_do(self):
        sealed = self.server.sealed(self.make_finished_model())
        handler = functools.partial(QuietFiles, directory=sealed.parent)
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as files:
            threading.Thread(target=files.serve_forever, daemon=True).start()
            run("fetch", f"http://127.0.0.1:{files.server_port}/model.arl", "-o", self.folder / "f.ply", "--vertices", 1500)
            files.shutdown()
        run("decode", sealed, "-o", self.folder / "d.ply", "--vertices", 1500)
        self.assertEqual((self.folder / "f.ply").read_bytes(), (self.folder / "d.ply").read_bytes())

    def test_a_repeated_request_makes_one_model(self):
        key = {"Idempotency-Key": "a key of mine"}
        first = json.loads(self.post("?vertices=500", headers=key)[2])["id"]
        self.assertEqual(json.loads(self.post("?vertices=500", headers=key)[2])["id"], first)
        self.assertEqual(self.post("?vertices=600", headers=key)[0], 422)
        self.assertEqual(len(json.loads(self.server.request("GET", "/v1/models")[2])["models"]), 1)

    def test_a_deleted_model_leaves_nothing(self):
        model_id = self.make_model("?vertices=100000&coarse=2500")
        self.server.wait_for(model_id, lambda model: model["state"] == "running")
        self.assertEqual(self.server.request("DELETE", f"/v1/models/{model_id}")[0], 204)
        self.assertEqual(self.server.request("GET", f"/v1/models/{model_id}")[0], 404)
        self.assertFalse((self.server.data / "models" / model_id).exists())
        self.assertEqual(self.server.worker_pids(), [])


if __name__ == "__main__":
    unittest.main()
