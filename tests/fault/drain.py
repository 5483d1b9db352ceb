"""A server is told to stop (SIGTERM) under load: every answer that has begun is whole, a running job goes on after the
restart, and the server ends well within 30 seconds."""
import http.client
import json
import threading
import time

import support


class Reader(threading.Thread):
    """Fetches the log again and again; counts what is whole and what is not."""

    def __init__(self, server, model, log, pause):
        super().__init__(daemon=True)  # a test that fails must end
        self.server, self.model, self.log, self.pause = server, model, log, pause
        self.n_whole = self.n_truncated = self.n_refused = 0
        self.is_over = False

    def run(self):
        while not self.is_over:
            connection = http.client.HTTPConnection(*self.server.address, timeout=60)
            try:
                connection.request("GET", f"/v1/models/{self.model}/log")
                response = connection.getresponse()
            except (OSError, http.client.HTTPException):
                self.n_refused += 1  # no answer has begun
                time.sleep(0.01)
                continue
            try:
                body = b""
                while piece := response.read(8192):
                    body += piece
                    time.sleep(self.pause)
                whole = response.status >= 500 or body == self.log
            except (OSError, http.client.HTTPException):
                whole = False
            self.n_whole += whole
            self.n_truncated += not whole
            connection.close()


def main():
    given = support.arguments(__doc__, times=3)
    findings = support.Findings("drain", given)
    harness = support.load_harness(given.anyrate)
    with support.temporary_folder() as name:
        root = support.Path(name)
        _, archive = support.make_capture(given.anyrate, root, views=8, width=96, height=72)
        server = harness.Server(root / "data")

        def post(query):
            answer = server.request("POST", "/v1/models" + query, archive.read_bytes(), {"Content-Type": "application/zip"})[2]
            return json.loads(answer)["id"]
        model = post("?vertices=4000&coarse=400")
        server.wait_until_final(model)
        log = server.sealed(model).read_bytes()
        n_whole, slowest = 0, 0.0
        for _ in range(given.times):
            running = post("?vertices=3000&coarse=400")
            readers = [Reader(server, model, log, pause) for pause in [0] * 8 + [0.02] * 8]
            for reader in readers:
                reader.start()
            time.sleep(given.random.uniform(0.5, 2.0))
            begun = time.monotonic()
            for reader in readers:
                reader.is_over = True  # the answer that it reads is its last
            code = server.stop()
            slowest = max(slowest, time.monotonic() - begun)
            for reader in readers:
                reader.join()
            findings.expect(code == 0, f"the server ended with {code}")
            n_whole += sum(reader.n_whole for reader in readers)
            n_truncated = sum(reader.n_truncated for reader in readers)
            findings.expect(n_truncated == 0, f"{n_truncated} answers were cut off")
            server = harness.Server(root / "data")
            state = server.wait_until_final(running)
            findings.expect(state["state"] == "done" and state["attempts"] <= 1, f"the job is {state}")
        findings.expect(slowest < 30, f"the server took {slowest:.1f} s to end")
        server.stop()
        findings.finish(stops=given.times, whole_answers=n_whole, slowest_stop_seconds=round(slowest, 2))


main()
