#!/usr/bin/env python3
"""What others notice while slowhttptest holds connections: 1,000 each with slow headers, slow bodies and slow reading.

  tests/bench/slow_http.py [--connections 1000] [--seconds 60]

Needs Debian's slowhttptest. The three attacks run at once against one `anyrate serve`; meanwhile a probe asks for a model's
state and for a range of its log, on new connections and on one that is kept, and the bench prints the delays as JSON: before,
during and after the attack. `open_connections` is what the server counts, so that the attack is seen to have taken place.
"""
import argparse
import http.client
import json
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.parse

from measuring import ROOT, machine
from static_throughput import Anyrate


class Probe(threading.Thread):
    """Asks as an ordinary client does, 50 times a second at most, until it is stopped."""

    def __init__(self, server):
        super().__init__(daemon=True)
        self.address = urllib.parse.urlsplit(server.base).netloc
        self.requests = [("GET", f"/v1/models/{server.model}", {}, 200),
                         ("GET", f"/v1/models/{server.model}/log", {"Range": "bytes=0-8191"}, 206)]
        self.delays_ms, self.failures, self.stopped = [], [], threading.Event()

    def run(self):
        kept = http.client.HTTPConnection(self.address, timeout=60)
        while not self.stopped.is_set():
            for method, target, headers, expected in self.requests:
                for connection in (kept, http.client.HTTPConnection(self.address, timeout=60)):
                    self.ask(connection, method, target, headers, expected)
                    if connection is not kept:
                        connection.close()
            time.sleep(0.08)
        kept.close()

    def ask(self, connection, method, target, headers, expected):
        begun = time.monotonic()
        try:
            connection.request(method, target, headers=headers)
            response = connection.getresponse()
            response.read()
            if response.status != expected:
                self.failures.append(f"{target}: {response.status}")
        except (OSError, http.client.HTTPException) as error:
            self.failures.append(f"{target}: {error!r}")
            connection.close()
        self.delays_ms.append(1000 * (time.monotonic() - begun))

    def report(self):
        delays = sorted(self.delays_ms)
        at = lambda share: round(delays[min(len(delays) - 1, int(share * len(delays)))], 2)
        return {"requests": len(delays), "failures": self.failures[:5], "n_failures": len(self.failures), "median_ms": at(0.5),
                "p99_ms": at(0.99), "max_ms": round(delays[-1], 2)}


def attacks(server, options):
    """Command lines: headers that never end, bodies of a byte now and then, answers read by 32 bytes."""
    common = [options.slowhttptest, "-c", options.connections, "-r", options.rate, "-l", options.seconds, "-p", 30]
    return {"slow_headers": [*common, "-H", "-i", 5, "-u", server.base + "/"],
            "slow_body": [*common, "-B", "-i", 5, "-s", 1_000_000, "-t", "POST", "-f", "application/zip", "-u",
                          server.base + "/v1/models"],
            "slow_read": [*common, "-X", "-w", 512, "-y", 1024, "-n", 5, "-z", 32, "-k", 3, "-u", server.url]}


def open_connections(server):
    connection = http.client.HTTPConnection(urllib.parse.urlsplit(server.base).netloc, timeout=60)
    connection.request("GET", "/metrics")
    text = connection.getresponse().read().decode()
    connection.close()
    return next(int(float(line.split()[1])) for line in text.splitlines() if line.startswith("anyrate_connections "))


def probe_for(server, seconds):
    probe = Probe(server)
    probe.start()
    most, end = 0, time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(min(2, max(0, end - time.monotonic())))
        most = max(most, open_connections(server))
    probe.stopped.set()
    probe.join()
    return {**probe.report(), "open_connections": most}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--connections", type=int, default=1000, help="of each attack")
    parser.add_argument("--rate", type=int, default=200, help="new connections a second of each attack")
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--quiet-seconds", type=int, default=5, help="before and after")
    parser.add_argument("--slowhttptest", default=shutil.which("slowhttptest"))
    options = parser.parse_args()
    if not options.slowhttptest:
        raise SystemExit("slow_http.py needs the Debian package slowhttptest")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="anyrate-slow-"))
    server, running = None, []
    try:
        capture = folder / "capture"
        subprocess.run([options.build / "anyrate", "simulate", "--scene", "vessel", "-o", capture, "--views", "10", "--width",
                        "160", "--height", "120"], check=True, capture_output=True)
        server = Anyrate(folder / "data", options.build, capture)
        result = {"machine": machine(), "connections_of_each": options.connections,
                  "before": probe_for(server, options.quiet_seconds)}
        for name, command in attacks(server, options).items():
            said = open(folder / f"{name}.txt", "w")
            running.append(subprocess.Popen([str(part) for part in command], stdout=said, stderr=said, cwd=folder))
        result["during"] = probe_for(server, options.seconds)
        for attack in running:
            attack.wait(120)
        result["after"] = probe_for(server, options.quiet_seconds)
        result["open_at_the_end"] = open_connections(server)
        json.dump(result, sys.stdout, indent=1)
        print()
    finally:
        for attack in running:
            if attack.poll() is None:
                attack.send_signal(signal.SIGKILL)
        if server:
            server.stop()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
