"""Who may do what, over which connection, and what operators see of it."""

import http.client
import json
import os
import ssl
import subprocess
import tempfile
import time
import unittest

from harness import ANYRATE, PATIENCE, Server, ServerTest, run


class TlsServer(Server):
    def connect(self):
        return http.client.HTTPSConnection(*self.address, timeout=PATIENCE, context=self.trusting)


class Access(ServerTest):
    server_options = ("--cors-origin", "https://a.example", "--log-requests", "all")

    def token(self, name, *options):
        return run("token", name, "--data", self.server.data, *options).stdout.strip()

    def bearer(self, token):
        return {"Authorization": f"Bearer {token}"}

    def status(self, method, target, headers=None, server=None):
        return (server or self.server).request(method, target, headers=headers)[0]

    def test_tokens_of_the_data_directory_are_taken_while_the_server_runs(self):
        self.assertEqual(self.status("POST", "/v1/captures"), 201)  # nobody has a token yet
        writer, reader = self.token("me"), self.token("you", "--scope", "read")
        self.wait_for_status("POST", "/v1/captures", 401)
        self.assertEqual(self.status("POST", "/v1/captures", self.bearer(writer)), 201)
        status, _, answer = self.server.request("POST", "/v1/captures", headers=self.bearer(reader))
        self.assertEqual((status, json.loads(answer)["title"]), (403, "Forbidden"))
        self.assertEqual(self.status("POST", "/v1/captures", self.bearer(writer[:-1])), 401)
        self.assertEqual(self.status("POST", f"/v1/captures?token={writer}"), 401)  # in a header only
        self.assertEqual(self.status("GET", "/v1/models"), 200)
        stored = (self.server.data / "tokens.json").read_text()
        self.assertNotIn(writer, stored)
        self.assertEqual(run("token", "me", "--data", self.server.data, check=False).returncode, 3)
        run("token", "me", "--data", self.server.data, "--revoke")
        self.wait_for_status("POST", "/v1/captures", 201, self.bearer(writer))  # no writer is left: as in the beginning

    def wait_for_status(self, method, target, status, headers=None):
        deadline = time.monotonic() + PATIENCE
        while (got := self.status(method, target, headers)) != status:
            self.assertLess(time.monotonic(), deadline, f"{got}, not {status}")
            time.sleep(0.05)

    def test_a_private_server_is_read_with_a_token_only(self):
        server = Server(self.folder / "private", "--private", environment={"ANYRATE_TOKEN": "secret"},
                        headers=self.bearer("secret"))
        try:
            self.assertEqual(self.status("GET", "/v1/models", server=server), 200)
            status, _, body = server.request("POST", "/v1/models?vertices=300", self.zip.read_bytes(),
                                             {"Content-Type": "application/zip"})
            self.assertEqual(status, 202, body)
            _, headers, _ = server.request("GET", f"/v1/models/{json.loads(body)['id']}/cameras")
            self.assertTrue(headers["Cache-Control"].startswith("private,"), headers["Cache-Control"])
            server.headers = {}
            self.assertEqual(self.status("GET", "/v1/models", server=server), 401)
            self.assertEqual(self.status("GET", "/metrics", server=server), 401)
            self.assertEqual(self.status("GET", "/healthz", server=server), 200)
        finally:
            self.assertEqual(server.stop(), 0)

    def test_beyond_loopback_a_token_is_needed(self):
        done = run("serve", "--listen", "0.0.0.0:0", "--data", self.folder / "open", check=False)
        self.assertEqual(done.returncode, 3)
        self.assertIn("token", done.stderr)

    def test_tls_serves_logs_meshes_and_refuses_wrong_files(self):
        certificate, key = self.folder / "certificate.pem", self.folder / "key.pem"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
                        "-keyout", key, "-out", certificate, "-days", "2", "-subj", "/CN=127.0.0.1", "-addext",
                        "subjectAltName=IP:127.0.0.1"], check=True, capture_output=True)
        done = run("serve", "--tls-certificate", key, "--tls-key", key, "--data", self.folder / "tls", check=False)
        self.assertEqual(done.returncode, 3)
        server = TlsServer(self.folder / "tls", "--tls-certificate", certificate, "--tls-key", key)
        server.trusting = ssl.create_default_context(cafile=certificate)
        try:
            self.assertTrue(server.url.startswith("https://"))
            self.assertEqual(self.status("GET", "/healthz", server=server), 200)
            self.server, plain = server, self.server
            model_id = self.make_finished_model("?vertices=600&coarse=500")
            log = server.sealed(model_id).read_bytes()
            for _ in range(2):
                self.assertEqual(server.request("GET", f"/v1/models/{model_id}/log")[2], log)
            self.assertEqual(server.request("GET", f"/v1/models/{model_id}/log", headers={"Range": "bytes=5-9"})[2], log[5:10])
            self.server = plain
        finally:
            self.assertEqual(server.stop(), 0)

    def test_pages_of_allowed_origins_may_read(self):
        origin = {"Origin": "https://a.example"}
        _, headers, _ = self.server.request("GET", "/v1/models", headers=origin)
        self.assertEqual(headers["Access-Control-Allow-Origin"], "https://a.example")
        _, headers, _ = self.server.request("GET", "/v1/models", headers={"Origin": "https://b.example"})
        self.assertNotIn("Access-Control-Allow-Origin", headers)
        self.assertEqual(headers["Vary"], "Origin")
        connection = self.server.connect()
        connection.request("OPTIONS", "/v1/models", headers={**origin, "Access-Control-Request-Method": "POST"})
        response = connection.getresponse()
        self.assertEqual(response.status, 204)
        self.assertIn("POST", response.headers["Access-Control-Allow-Methods"])
        connection.close()

    def test_a_request_is_known_by_its_id(self):
        _, headers, _ = self.server.request("GET", "/healthz", headers={"X-Request-Id": "mine-1"})
        self.assertEqual(headers["X-Request-Id"], "mine-1")
        _, headers, _ = self.server.request("GET", "/healthz", headers={"X-Request-Id": "not mine"})
        self.assertNotEqual(headers["X-Request-Id"], "not mine")

    def test_metrics_count_requests_by_route(self):
        self.server.request("GET", "/v1/models")
        self.server.request("GET", "/v1/models/" + "a" * 26)
        _, _, body = self.server.request("GET", "/metrics")
        text = body.decode()
        self.assertIn('anyrate_requests_total{method="GET",route="/v1/models",status="2xx"} 1\n', text)
        self.assertIn('anyrate_requests_total{method="GET",route="/v1/models/{id}",status="4xx"} 1\n', text)
        self.assertIn('anyrate_request_seconds_count{method="GET",route="/v1/models"} 1\n', text)
        self.assertIn("anyrate_models{", text)

    def test_hot_logs_are_answered_as_the_general_path_answers(self):
        server = Server(self.folder / "hot", "--log-requests", "errors")  # logging all closes the hot path
        self.server, logging = server, self.server
        try:
            model_id = self.make_finished_model("?vertices=600&coarse=500")
            target = f"/v1/models/{model_id}/log"
            log = server.sealed(model_id).read_bytes()
            general = [server.request("GET", target, headers={**fields, "X-Request-Id": "general"})
                       for fields in ({}, {"Range": "bytes=7-99"})]
            hot = [server.request("GET", target, headers=fields) for fields in ({}, {"Range": "bytes=7-99"})]
            self.assertEqual([answer[2] for answer in hot], [log, log[7:100]])
            for one, other in zip(general, hot):
                fields = [{name: value for name, value in answer[1].items() if name not in ("Date", "X-Request-Id")}
                          for answer in (one, other)]
                self.assertEqual((one[0], fields[0], one[2]), (other[0], fields[1], other[2]))
            self.assertEqual(server.request("DELETE", f"/v1/models/{model_id}")[0], 204)
            self.assertEqual(server.request("GET", target)[0], 404)
        finally:
            self.server = logging
            self.assertEqual(server.stop(), 0)

    def test_options_come_from_file_environment_and_flags(self):
        config = self.folder / "anyrate.conf"
        config.write_text('log-format="json"\nlog-requests="none"\nkeep-days=7\nlisten="nowhere"\n')
        environment = {**os.environ, "ANYRATE_CONFIG": str(config), "ANYRATE_LISTEN": "nowhere either",
                       "ANYRATE_LOG_REQUESTS": "all", "ANYRATE_KEEP_DAYS": "1", "ANYRATE_KEEP_MB": "1000"}
        with tempfile.TemporaryFile("w+") as log:
            process = subprocess.Popen([ANYRATE, "serve", "--listen", "127.0.0.1:0", "--data", self.folder / "configured"],
                                       stdout=subprocess.PIPE, stderr=log, text=True, env=environment)
            port = int(process.stdout.readline().rsplit(":", 1)[1])
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
            connection.request("GET", "/healthz", headers={"X-Request-Id": "seen"})
            connection.getresponse().read()
            connection.close()
            process.terminate()
            self.assertEqual(process.wait(PATIENCE), 0)
            process.stdout.close()
            log.seek(0)
            lines = [json.loads(line) for line in log.read().splitlines()]
        request = next(line for line in lines if line.get("request_id") == "seen")
        self.assertEqual((request["status"], request["path"], request["level"]), (200, "/healthz", "info"))


if __name__ == "__main__":
    unittest.main()
