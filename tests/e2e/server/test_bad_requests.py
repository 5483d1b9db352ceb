"""Every bad request gets its problem document, and the server goes on."""

import io
import json
import socket
import struct
import unittest
import zipfile

from harness import Server, ServerTest, run

ID = "a" * 26


def zip_of(**files):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in files.items():
            archive.writestr(name.replace("__", "/").replace("_dot_", "."), content)
    return buffer.getvalue()


class BadRequests(ServerTest):
    server_options = ("--max-upload", "1")

    def expect_problem(self, status, method, target, body=None, headers=None):
        with self.subTest(method=method, target=target[:80], headers=headers):
            got, fields, document = self.server.request(method, target, body, headers)
            self.assertEqual(got, status, document)
            self.assertEqual(fields["Content-Type"], "application/problem+json")
            problem = json.loads(document)
            self.assertEqual(problem["status"], status)
            self.assertGreater(len(problem["detail"]), 10)
            self.assertEqual(self.server.request("GET", "/healthz")[0], 200)
            return fields

    def test_each_gets_its_sentence(self):
        zip_type = {"Content-Type": "application/zip"}
        body = self.zip.read_bytes()
        for status, *request in [
            (404, "GET", "/nowhere"),
            (404, "GET", "/v1/models/" + ID),
            (404, "GET", "/v1/models/../../etc/passwd"),
            (404, "GET", "/v1/models/" + ID + "/log"),
            (404, "GET", "/v1/models/" + ID + "/live"),
            (404, "DELETE", "/v1/models/" + ID),
            (400, "GET", "/v1/models/..%2f..%2fcatalog.sqlite/log"),
            (400, "GET", "/v1/models/%00"),
            (400, "GET", "/v1/models?limit=%zz"),
            (400, "GET", "/v1/models?limit=0"),
            (400, "GET", "/v1/models?limit=ten"),
            (400, "GET", "/v1/models?after=../x"),
            (400, "GET", "/v1/models?limit=1&limit=2"),
            (400, "GET", "/v1/models?colour=red"),
            (414, "GET", "/" + "x" * 5000),
            (405, "PUT", "/v1/models"),
            (405, "POST", "/healthz"),
            (415, "POST", "/v1/models", body, {"Content-Type": "image/png"}),
            (400, "POST", "/v1/models", b"", zip_type),
            (400, "POST", "/v1/models", b"this is no zip file", zip_type),
            (400, "POST", "/v1/models?vertices=-5", body, zip_type),
            (400, "POST", "/v1/models?vertices=1e4", body, zip_type),
            (400, "POST", "/v1/models?vertices=1000&coarse=2000", body, zip_type),
            (400, "POST", "/v1/models", body, {**zip_type, "Idempotency-Key": "k" * 300}),
            (413, "POST", "/v1/models", b"PK\x03\x04" + bytes(2 << 20), zip_type),
        ]:
            self.expect_problem(status, *request)
        self.assertEqual(self.expect_problem(405, "PATCH", "/v1/models")["Allow"], "GET, HEAD, POST")

    def test_what_is_no_http_is_answered_and_closed(self):
        for text, status in [
            (b"this is not HTTP\r\n\r\n", b" 400 "),
            (b"GET / HTTP/1.1\r\nA: " + b"b" * 40000 + b"\r\n\r\n", b" 431 "),
            (b"POST /v1/models HTTP/1.1\r\nContent-Type: application/zip\r\nContent-Length: 99999999999\r\n\r\n", b" 413 "),
            (b"POST /v1/models HTTP/1.1\r\nContent-Length: minus one\r\n\r\n", b" 400 "),
            (b"GET /healthz HTTP/1.1\r\n\r\n", b" 400 "),
            (b"GET /healthz HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", b" 400 "),
            (b"POST /v1/captures HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: gzip\r\n\r\nGET / HTTP/1.1\r\n", b" 501 "),
            (b"POST /v1/captures HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: gzip, chunked\r\n\r\n0\r\n\r\n", b" 501 "),
            (b"POST /v1/captures HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
             b" 400 "),
        ]:
            with self.subTest(text=text[:60]):
                answer = self.server.raw(text)
                self.assertIn(status, answer.split(b"\r\n")[0])
                self.assertIn(b"application/problem+json", answer)
                self.assertEqual(answer.count(b"HTTP/1.1 "), 1)  # what follows is no other request
                self.assertEqual(self.server.request("GET", "/healthz")[0], 200)

    def test_a_budget_out_of_place_is_refused(self):
        model_id = self.make_finished_model("?vertices=500")
        log = f"/v1/models/{model_id}/log"
        for query in ("?vertices=0", "?vertices=x", "?bytes=-1", "?distortion=nan", "?vertices=5&bytes=5", "?vertice=5"):
            self.expect_problem(400, "GET", log + query)
        self.expect_problem(400, "GET", f"/v1/models/{model_id}/mesh.ply?vertices=no")
        self.expect_problem(400, "GET", f"/v1/models/{model_id}/live?from=-1")
        self.expect_problem(404, "GET", f"/v1/models/{model_id}/mesh.stl")
        self.expect_problem(426, "GET", f"/v1/models/{model_id}/live")
        self.expect_problem(416, "GET", log, headers={"Range": "bytes=999999999-"})
        self.assertEqual(self.server.request("HEAD", log, headers={"Range": "bytes=0-9"})[0], 200)  # for GET only

    def test_a_client_that_hangs_up_in_the_middle_harms_nobody(self):
        model_id = self.make_finished_model("?vertices=2000&coarse=800")
        request = f"GET /v1/models/{model_id}/log HTTP/1.1\r\nHost: test\r\n\r\n".encode()
        for _ in range(20):
            connection = socket.socket()
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # close by reset
            connection.connect(self.server.address)
            connection.sendall(request * 200)
            connection.recv(1000)
            connection.close()
        self.assertEqual(self.server.request("GET", "/healthz")[0], 200)

    def test_a_bad_capture_is_refused_with_its_sentence_and_makes_no_model(self):
        for body in [
            zip_of(readme_dot_txt="no capture"),
            zip_of(cameras_dot_json="{ this is no json"),
            zip_of(cameras_dot_json='{"pixel_center":[0.5,0.5],"images":[]}'),
            self.zip.read_bytes()[:1000],
        ]:
            with self.subTest(body=body[:60]):
                status, _, answer = self.post(body=body)
                self.assertEqual(status, 422)
                self.assertGreater(len(json.loads(answer)["detail"]), 10)
        self.assertEqual(json.loads(self.server.request("GET", "/v1/models")[2])["models"], [])

    def test_writing_needs_the_token_once_there_is_one(self):
        other = Server(self.folder / "other", environment={"ANYRATE_TOKEN": "secret"})
        try:
            for headers in ({}, {"Authorization": "Bearer wrong"}, {"Authorization": "secret"}):
                status, fields, _ = other.request("POST", "/v1/models", b"PK", headers)
                self.assertEqual((status, fields["WWW-Authenticate"]), (401, 'Bearer realm="anyrate"'))
            self.assertEqual(other.request("GET", "/v1/models")[0], 200)
            right = {"Authorization": "Bearer secret", "Content-Type": "application/zip"}
            self.assertEqual(other.request("POST", "/v1/models", self.zip.read_bytes(), right)[0], 202)
        finally:
            other.stop()

    def test_without_a_token_the_server_stays_on_loopback(self):
        done = run("serve", "--listen", "0.0.0.0:0", "--data", self.folder / "public", check=False)
        self.assertEqual(done.returncode, 3)
        self.assertIn("token", done.stderr)

    def test_two_servers_do_not_share_a_data_directory(self):
        done = run("serve", "--listen", "127.0.0.1:0", "--data", self.server.data, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("another server", done.stderr)


if __name__ == "__main__":
    unittest.main()
