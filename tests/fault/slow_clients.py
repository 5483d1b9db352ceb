"""Clients that are slow on purpose, of three kinds at once: a byte of a header now and then, a byte of a body now and then,
and answers that nobody reads. Meanwhile others must be served as ever, and the server must get rid of the slow ones.

  python3 tests/fault/slow_clients.py build/anyrate [--clients 1000] [--seconds 40]

Prints the delays of a probe on connections of its own; the test judges answers, not times.
"""
import http.client
import json
import selectors
import socket
import statistics
import sys
import threading
import time
from pathlib import Path

import support


class SlowClient:
    """One connection; `step` sends its next byte, `is_over` once the server has ended it."""

    def __init__(self, address, kind, log_target):
        self.kind, self.is_over, self.received = kind, False, b""
        self.socket = socket.socket()
        if kind == "read":
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.settimeout(30)
        self.socket.connect(address)
        if kind == "headers":
            self.socket.sendall(b"GET / HTTP/1.1\r\nHost: a\r\nX-Slow: ")
        elif kind == "body":
            self.socket.sendall(b"POST /v1/models HTTP/1.1\r\nHost: a\r\nContent-Type: application/zip\r\nContent-Length: 1000000\r\n\r\nPK")
        else:
            self.socket.sendall(b"GET %s HTTP/1.1\r\nHost: a\r\n\r\n" % log_target.encode() * 400)
        self.socket.setblocking(False)

    def step(self):
        if self.is_over or self.kind == "read":
            return
        try:
            self.socket.send(b"a")
        except BlockingIOError:
            pass
        except OSError:
            self.is_over = True

    def read(self):
        try:
            piece = self.socket.recv(4096)
        except BlockingIOError:
            return
        except OSError:
            piece = b""
        self.received += piece
        self.is_over = self.is_over or not piece or self.received.startswith(b"HTTP/1.1 408")


def probe(address, log_target, stop, delays, failures):
    """Asks for the state of the server and for a log, each on a new connection."""
    while not stop.is_set():
        for target in ("/healthz", log_target):
            begun = time.monotonic()
            try:
                connection = http.client.HTTPConnection(*address, timeout=30)
                connection.request("GET", target)
                if connection.getresponse().status != 200:
                    failures.append(target)
                connection.close()
            except OSError as error:
                failures.append(f"{target}: {error}")
            delays.append(1000 * (time.monotonic() - begun))
        time.sleep(0.02)


def open_connections(server):
    _, _, metrics = server.request("GET", "/metrics")
    return next(float(line.split()[1]) for line in metrics.decode().splitlines() if line.startswith("anyrate_connections "))


def main():
    given_clients = 60
    if "--clients" in sys.argv:
        at = sys.argv.index("--clients")
        given_clients = int(sys.argv[at + 1])
        del sys.argv[at:at + 2]
    given = support.arguments(__doc__, seconds=40)
    findings = support.Findings("slow_clients", given)
    harness = support.load_harness(given.anyrate)
    with support.temporary_folder() as folder:
        _, archive = support.make_capture(given.anyrate, folder)
        server = harness.Server(Path(folder) / "data")
        try:
            status, _, body = server.request("POST", "/v1/models?vertices=2000&coarse=800", archive.read_bytes(),
                                             {"Content-Type": "application/zip"})
            assert status == 202, body
            model_id = json.loads(body)["id"]
            server.wait_until_final(model_id)
            target = f"/v1/models/{model_id}/log"
            stop, delays, failures = threading.Event(), [], []
            prober = threading.Thread(target=probe, args=(server.address, target, stop, delays, failures))
            prober.start()
            clients = [SlowClient(server.address, kind, target) for kind in ("headers", "body", "read")
                       for _ in range(given_clients)]
            selector = selectors.DefaultSelector()
            for client in clients:
                if client.kind != "read":
                    selector.register(client.socket, selectors.EVENT_READ, client)
            deadline = time.monotonic() + given.seconds
            next_step = 0.0
            while time.monotonic() < deadline:
                for key, _ in selector.select(0.5):
                    key.data.read()
                    if key.data.is_over:
                        selector.unregister(key.fileobj)
                if time.monotonic() >= next_step:
                    next_step = time.monotonic() + 2
                    for client in clients:
                        client.step()
            stop.set()
            prober.join()
            over = {kind: sum(client.is_over for client in clients if client.kind == kind) for kind in ("headers", "body")}
            # For those that read nothing the time begins with the last bytes that the kernel took for them.
            begun = time.monotonic()
            while (open_now := open_connections(server)) >= 10 and time.monotonic() < begun + 20:
                time.sleep(0.5)
            findings.expect(not failures, f"probes failed: {failures[:5]}")
            findings.expect(over["headers"] == given_clients, f"{over['headers']} of {given_clients} slow headers were ended")
            findings.expect(over["body"] == given_clients, f"{over['body']} of {given_clients} slow bodies were ended")
            findings.expect(open_now < 10, f"{open_now} connections are open, though every slow client had its time")
            delays.sort()
            findings.report.update(clients_of_each_kind=given_clients, probes=len(delays), open_at_the_end=open_now,
                                   waited_for_readers_s=round(time.monotonic() - begun, 1),
                                   probe_ms={"median": round(statistics.median(delays), 2),
                                             "p99": round(delays[int(0.99 * (len(delays) - 1))], 2)})
            for client in clients:
                client.socket.close()
        finally:
            findings.expect(server.stop() == 0, "the server did not end well")
    findings.finish()


if __name__ == "__main__":
    main()
