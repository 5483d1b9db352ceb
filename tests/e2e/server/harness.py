"""A server under test, a small capture, and a WebSocket client of a few lines; standard library only."""

import atexit
import base64
import http.client
import io
import json
import os
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zipfile
import zlib
from pathlib import Path

from openapi_check import Document

ANYRATE = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else None
# Seconds until a wait counts as failed; far above what is needed, but for a machine that stands still for minutes.
PATIENCE = float(os.environ.get("ANYRATE_TEST_PATIENCE", 300))


def run(*arguments, check=True):
    """Runs the binary and gives the finished process with its output as text."""
    done = subprocess.run([ANYRATE, *map(str, arguments)], capture_output=True, text=True, timeout=PATIENCE)
    if check and done.returncode != 0:
        raise AssertionError(f"anyrate {arguments[0]} gave {done.returncode}: {done.stderr}")
    return done


def grey_png(width, height, value):
    """A PNG of one grey."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = (b"\0" + bytes([value]) * width) * height
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


class Server:
    """`anyrate serve` on a port of the kernel's choice."""

    def __init__(self, data, *options, environment=None, headers=None, errors=subprocess.DEVNULL):
        self.data = Path(data)
        self.document = None      # its OpenAPI document, once it was asked for
        self.headers = headers or {}  # of every request
        self.process = subprocess.Popen(
            [ANYRATE, "serve", "--listen", "127.0.0.1:0", "--data", self.data, *options],
            stdout=subprocess.PIPE, stderr=errors, text=True, env={**os.environ, **(environment or {})})
        atexit.register(self.kill_if_running)  # of a test that ended by an exception
        line = self.process.stdout.readline()
        if not line.startswith("listening on http"):
            raise AssertionError(f"the server did not start: {line!r}")
        self.url = line.split()[-1]
        self.address = ("127.0.0.1", int(self.url.rsplit(":", 1)[1]))

    def request(self, method, target, body=None, headers=None):
        """One request on a connection of its own: (status, headers, body)."""
        connection = self.connect()
        try:
            connection.request(method, target, body, {**self.headers, **(headers or {})})
            response = connection.getresponse()
            answer = response.status, response.headers, response.read()
        finally:
            connection.close()
        self.check_promise(method, target, answer)
        return answer

    def check_promise(self, method, target, answer):
        """Every answer that a test sees is one that the server's own OpenAPI document promises."""
        if self.document is None:
            connection = self.connect()
            connection.request("GET", "/openapi.json", headers=self.headers)
            self.document = Document(json.loads(connection.getresponse().read()))
            connection.close()
        self.document.check(method, target, *answer)

    def connect(self):
        return http.client.HTTPConnection(*self.address, timeout=PATIENCE)

    def raw(self, data):
        """Sends bytes as they are and gives everything that comes back."""
        with socket.create_connection(self.address, timeout=PATIENCE) as connection:
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            answer = b""
            while piece := connection.recv(65536):
                answer += piece
            return answer

    def model(self, model_id):
        status, _, body = self.request("GET", f"/v1/models/{model_id}")
        assert status == 200, body
        return json.loads(body)

    def wait_for(self, model_id, is_reached):
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            model = self.model(model_id)
            if is_reached(model):
                return model
            time.sleep(0.05)
        raise AssertionError(f"model {model_id} is still {model}")

    def wait_until_final(self, model_id):
        return self.wait_for(model_id, lambda model: model["state"] not in ("queued", "running"))

    def worker_pids(self):
        children = Path(f"/proc/{self.process.pid}/task")
        return [int(pid) for task in children.iterdir() for pid in (task / "children").read_text().split()]

    def sealed(self, model_id):
        return self.data / "models" / model_id / "model.arl"

    def live(self, model_id):
        """The log that live clients follow, also once the model is sealed."""
        return self.data / "models" / model_id / "log.live"

    def kill_if_running(self):
        if self.process.poll() is None:
            self.process.kill()

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait(PATIENCE)
        self.process.stdout.close()

    def stop(self):
        """Asks the server to end, as an operator does, and gives its exit code."""
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(PATIENCE)
        self.process.stdout.close()
        return code


class WebSocket:
    """The client's side of RFC 6455, as far as these tests need it."""

    def __init__(self, server, target):
        self.socket = socket.create_connection(server.address, timeout=PATIENCE)
        self.buffer = b""
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(f"GET {target} HTTP/1.1\r\nHost: test\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
        while b"\r\n\r\n" not in self.buffer:
            self.buffer += self.receive()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        assert b" 101 " in head.split(b"\r\n")[0], head

    def receive(self):
        piece = self.socket.recv(65536)
        if not piece:
            raise ConnectionError("the server closed without a close frame")
        return piece

    def take(self, n):
        while len(self.buffer) < n:
            self.buffer += self.receive()
        taken, self.buffer = self.buffer[:n], self.buffer[n:]
        return taken

    def send(self, text, opcode=1):
        payload, mask = text.encode(), os.urandom(4)
        masked = bytes(b ^ mask[i % 4] for i, b in enumerate(payload))
        self.socket.sendall(bytes([0x80 | opcode, 0x80 | len(payload)]) + mask + masked)

    def read(self):
        """The next message: ("text", str), ("binary", bytes) or ("close", code)."""
        whole = b""
        kind = 0
        while True:
            first, second = self.take(2)
            n = second & 0x7F
            if n == 126:
                n = struct.unpack(">H", self.take(2))[0]
            elif n == 127:
                n = struct.unpack(">Q", self.take(8))[0]
            payload = self.take(n)
            opcode = first & 0x0F
            if opcode == 8:
                return "close", struct.unpack(">H", payload[:2])[0]
            if opcode in (9, 10):
                continue
            kind = kind or opcode
            whole += payload
            if first & 0x80:
                return ("text", whole.decode()) if kind == 1 else ("binary", whole)

    def read_to_end(self):
        """(texts as JSON, the binary bytes since the last hello, close code)"""
        texts, log = [], b""
        while True:
            kind, payload = self.read()
            if kind == "close":
                return texts, log, payload
            if kind == "text":
                texts.append(json.loads(payload))
                if texts[-1]["type"] == "hello":
                    log = b""
            else:
                log += payload

    def is_silent(self, seconds):
        return not self.buffer and not select.select([self.socket], [], [], seconds)[0]

    def close(self):
        self.socket.close()


class ServerTest(unittest.TestCase):
    """A fresh server for each test, and one simulated capture for all of them."""

    server_options = ()

    @classmethod
    def setUpClass(cls):
        cls.shared = Path(tempfile.mkdtemp(prefix="anyrate-e2e-"))
        cls.capture = cls.shared / "capture"
        run("simulate", "--scene", "vessel", "-o", cls.capture, "--views", 12, "--width", 160, "--height", 120)
        cls.zip = cls.shared / "capture.zip"
        with zipfile.ZipFile(cls.zip, "w") as archive:
            for file in sorted(cls.capture.rglob("*")):
                if file.is_file() and file.suffix in (".png", ".json"):
                    archive.write(file, file.relative_to(cls.capture))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.shared)

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(dir=self.shared))
        self.server = Server(self.folder / "data", *self.server_options)

    def tearDown(self):
        if self.server.process.poll() is None:
            self.assertEqual(self.server.stop(), 0, "the server ends well")

    def changed_zip(self, **changes):
        """The capture with other bytes for some files, None for none: images__000 stands for images/000.png."""
        changes = {name.replace("__", "/") + (".json" if name == "cameras" else ".png"): data for name, data in changes.items()}
        buffer = io.BytesIO()
        with zipfile.ZipFile(self.zip) as before, zipfile.ZipFile(buffer, "w") as after:
            for name in before.namelist():
                data = changes.get(name, before.read(name))
                if data is not None:
                    after.writestr(name, data)
        return buffer.getvalue()

    def post(self, query="", body=None, headers=None):
        return self.server.request("POST", "/v1/models" + query, self.zip.read_bytes() if body is None else body,
                                   {"Content-Type": "application/zip", **(headers or {})})

    def make_model(self, query="?vertices=2000&coarse=800"):
        """Posts the capture and gives the id of the model, which is not made yet."""
        status, headers, body = self.post(query)
        self.assertEqual(status, 202, body)
        model_id = json.loads(body)["id"]
        self.assertEqual(headers["Location"], f"/v1/models/{model_id}")
        return model_id

    def make_finished_model(self, query="?vertices=2000&coarse=800"):
        model_id = self.make_model(query)
        model = self.server.wait_until_final(model_id)
        self.assertEqual(model["state"], "done", model)
        return model_id

    def url(self, model_id):
        return f"{self.server.url}/v1/models/{model_id}"
