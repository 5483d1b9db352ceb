"""A server is killed at random moments while jobs run and captures are uploaded; whatever it acknowledged is there
after its restart, and every job ends.

An upload is acknowledged when its answer has arrived: from then on the model must be listed and its capture be the bytes
that were sent. At the end every model must be done, and every sealed log sound.
"""
import http.client
import json
import subprocess
import threading
import time

import support


class Uploader(threading.Thread):
    """Posts the capture again and again, to whichever server is there."""

    def __init__(self, body, most):
        super().__init__(daemon=True)  # a test that fails must end
        self.body, self.most = body, most
        self.address = None
        self.acknowledged = []
        self.n_broken = self.n_refused = 0
        self.is_over = False

    def run(self):
        while not self.is_over:
            address = self.address
            if address is None or len(self.acknowledged) >= self.most:
                time.sleep(0.02)
                continue
            try:
                connection = http.client.HTTPConnection(*address, timeout=30)
                connection.request("POST", "/v1/models?vertices=900&coarse=400", self.body,
                                   {"Content-Type": "application/zip"})
                response = connection.getresponse()
                answer = response.read()
                if response.status == 202:
                    self.acknowledged.append(json.loads(answer)["id"])
                else:
                    self.n_refused += 1
                connection.close()
            except (OSError, http.client.HTTPException, ValueError):
                self.n_broken += 1  # the server died in the middle: nothing was acknowledged
            time.sleep(0.3)


def check_acknowledged(server, findings, uploader, body):
    for model in list(uploader.acknowledged):
        status, _, _ = server.request("GET", f"/v1/models/{model}")
        findings.expect(status == 200, f"model {model} was acknowledged and is gone: {status}")
        file = server.data / "models" / model / "capture.zip"
        findings.expect(file.exists() and file.read_bytes() == body, f"the capture of {model} is not what was sent")


def main():
    given = support.arguments(__doc__, times=6)
    findings = support.Findings("server_kills", given)
    harness = support.load_harness(given.anyrate)
    with support.temporary_folder() as name:
        root = support.Path(name)
        _, archive = support.make_capture(given.anyrate, root, views=8, width=96, height=72)
        body = archive.read_bytes()
        uploader = Uploader(body, most=max(4, given.times // 4))
        uploader.start()
        server = harness.Server(root / "data")
        n_up = 0
        for _ in range(given.times):
            uploader.address = server.address
            time.sleep(given.random.choice([given.random.uniform(0.05, 1.0), given.random.uniform(1.0, 5.0)]))
            workers = server.worker_pids()
            uploader.address = None
            server.kill()
            server = harness.Server(root / "data")
            n_up += 1
            check_acknowledged(server, findings, uploader, body)
            for pid in workers:
                deadline = time.monotonic() + harness.PATIENCE
                while support.Path(f"/proc/{pid}").exists() and time.monotonic() < deadline:
                    time.sleep(0.01)
                findings.expect(not support.Path(f"/proc/{pid}").exists(), "a worker outlived its server")
        uploader.is_over = True
        uploader.join()
        check_acknowledged(server, findings, uploader, body)
        deadline = time.monotonic() + harness.PATIENCE + 10 * len(uploader.acknowledged)
        states, errors = {}, {}
        while time.monotonic() < deadline:
            models = json.loads(server.request("GET", "/v1/models?limit=1000")[2])["models"]
            states = {model["id"]: model["state"] for model in models}
            errors = {model["id"]: model.get("error", "") for model in models}
            if all(state not in ("queued", "running") for state in states.values()):
                break
            time.sleep(0.5)
        for model, state in states.items():
            findings.expect(state == "done", f"model {model} is {state}: {errors[model]}")
        for model in uploader.acknowledged:
            log = server.sealed(model)
            if states.get(model) == "done":
                sound = subprocess.run([given.anyrate, "verify", log], capture_output=True).returncode == 0
                findings.expect(sound, f"the log of {model} is not sound")
        listed = set(states)
        findings.expect(set(uploader.acknowledged) <= listed, "an acknowledged model is not listed")
        findings.expect(server.stop() == 0, "the last server did not end well")
        findings.finish(kills=n_up, acknowledged=len(uploader.acknowledged), broken_uploads=uploader.n_broken,
                        refused_uploads=uploader.n_refused, models=len(states))


main()
