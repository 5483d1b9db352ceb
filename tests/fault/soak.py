"""Mixed load for a long time: memory and file descriptors of the server stay flat.

Uploads, deletions, whole logs, ranges, meshes, live streams and requests in error, from a few threads. After the first
third (the warm-up) the slope of resident memory over time is fitted by least squares. The long form is 1800 seconds,
whose slope has to be below 1 MB an hour; the short one only looks for what leaks fast.
"""
import http.client
import json
import random
import threading
import time

import support


class Client(threading.Thread):
    def __init__(self, harness, server, models, archive, seed, end, stalls):
        super().__init__(daemon=True)  # a test that fails must end
        self.harness, self.server, self.models, self.archive = harness, server, models, archive
        self.random, self.end, self.stalls = random.Random(seed), end, stalls
        self.n_requests = self.n_stalled = 0
        self.errors = []

    def run(self):
        while time.monotonic() < self.end:
            begun = time.monotonic()
            try:
                self.one()
                self.n_requests += 1
            except (OSError, http.client.HTTPException, AssertionError) as error:
                if self.stalls.since(begun):
                    self.n_stalled += 1
                else:
                    self.errors.append(repr(error))

    def one(self):
        model = self.random.choice(self.models)
        what = self.random.choice(["log", "log", "range", "range", "range", "list", "live", "error", "mesh", "job"])
        ask = self.server.request
        if what == "log":
            assert ask("GET", f"/v1/models/{model}/log")[0] == 200
        elif what == "range":
            assert ask("GET", f"/v1/models/{model}/log", headers={"Range": "bytes=100-999"})[0] == 206
        elif what == "list":
            assert ask("GET", "/v1/models")[0] == 200
        elif what == "live":
            stream = self.harness.WebSocket(self.server, f"/v1/models/{model}/live")
            stream.read_to_end()
            stream.close()
        elif what == "error":
            assert ask("GET", "/v1/models/nobody/log")[0] == 404
        elif what == "mesh":
            assert ask("GET", f"/v1/models/{model}/mesh.ply?vertices=500")[0] == 200
        elif self.random.random() < 0.05:
            status, _, answer = ask("POST", "/v1/models?vertices=400&coarse=300", self.archive,
                                    {"Content-Type": "application/zip"})
            assert status == 202, answer
            made = json.loads(answer)["id"]
            time.sleep(self.random.uniform(0, 3))
            assert ask("DELETE", f"/v1/models/{made}")[0] == 204
        time.sleep(0.005)


def slope(samples):
    """Bytes an hour, by least squares."""
    n = len(samples)
    mean_t, mean_y = sum(t for t, _ in samples) / n, sum(y for _, y in samples) / n
    spread = sum((t - mean_t) ** 2 for t, _ in samples)
    return 3600 * sum((t - mean_t) * (y - mean_y) for t, y in samples) / spread if spread else 0.0


def main():
    given = support.arguments(__doc__, seconds=20)
    findings = support.Findings("soak", given)
    harness = support.load_harness(given.anyrate)
    with support.temporary_folder() as name:
        root = support.Path(name)
        archive = support.make_capture(given.anyrate, root, views=8, width=96, height=72)[1].read_bytes()
        server = harness.Server(root / "data")
        models = []
        for vertices in (500, 1500, 3000):
            answer = server.request("POST", f"/v1/models?vertices={vertices}&coarse=400", archive,
                                    {"Content-Type": "application/zip"})[2]
            models.append(json.loads(answer)["id"])
        for model in models:
            server.wait_until_final(model)
        begun = time.monotonic()
        stalls = support.Stalls()
        clients = [Client(harness, server, models, archive, given.seed + i, begun + given.seconds, stalls) for i in range(4)]
        for client in clients:
            client.start()
        samples, descriptors = [], []
        while (now := time.monotonic() - begun) < given.seconds:
            if now > given.seconds / 3:
                samples.append((now, support.rss_bytes(server.process.pid)))
                descriptors.append(support.n_descriptors(server.process.pid))
            time.sleep(min(1.0, given.seconds / 40))
        for client in clients:
            client.join()
        errors = [error for client in clients for error in client.errors]
        findings.expect(not errors, f"{len(errors)} requests failed: {errors[:1]}")
        third = max(1, len(samples) // 3)
        grown = min(y for _, y in samples[-third:]) - min(y for _, y in samples[:third])
        mb_an_hour = slope(samples) / (1 << 20)
        if given.seconds >= 1200:
            findings.expect(mb_an_hour < 1, f"memory grows by {mb_an_hour:.1f} MB an hour")
        findings.expect(grown < 32 << 20, f"memory grew by {grown >> 20} MB")
        time.sleep(1)
        idle = support.n_descriptors(server.process.pid)
        findings.expect(idle <= min(descriptors) + 4, f"{idle} descriptors are open when nobody is there")
        findings.expect(server.stop() == 0, "the server did not end well")
        findings.finish(seconds=given.seconds, requests=sum(client.n_requests for client in clients),
                        cut_by_stalls=sum(client.n_stalled for client in clients), stalls=len(stalls.ends),
                        memory_mb=[round(samples[0][1] / (1 << 20), 1), round(samples[-1][1] / (1 << 20), 1)],
                        slope_mb_an_hour=round(mb_an_hour, 2), descriptors=[min(descriptors), max(descriptors), idle])


main()
