"""The disk is full, fails, writes by halves; then it recovers. Nothing that was there is harmed, nobody is told that
something is kept which is not, and every job ends as on a sound disk.

The faults come from a preloaded library (io_faults.cpp), in the server and its workers alike.
"""
import json
import struct
import subprocess
import sys
import time

import support

HEADER = 96  # bytes of a log that name the model; the frames behind it depend on capture and options alone
NO_ROOM, WRITE_ERROR, SHORT_WRITE, SYNC_ERROR, RENAME_ERROR = 1, 2, 4, 8, 16
KINDS = {"full disk": (NO_ROOM, 1000), "write errors": (WRITE_ERROR, 300), "short writes": (SHORT_WRITE, 1000),
         "sync errors": (SYNC_ERROR, 300), "errors at renaming": (RENAME_ERROR, 500),
         "all kinds": (NO_ROOM | WRITE_ERROR | SHORT_WRITE | SYNC_ERROR | RENAME_ERROR, 100)}


class Disk:
    """The control file of the preloaded library."""

    def __init__(self, file):
        self.file = file
        self.set(0, 0)

    def set(self, faults, per_thousand):
        with open(self.file, "r+b" if self.file.exists() else "wb") as out:
            out.write(struct.pack("<II", faults, per_thousand))


class Test:
    def __init__(self, given, findings, root, library):
        self.findings = findings
        self.random = given.random
        self.anyrate = given.anyrate
        harness = support.load_harness(given.anyrate)
        self.body = support.make_capture(given.anyrate, root, views=8, width=96, height=72)[1].read_bytes()
        self.disk = Disk(root / "faults")
        self.server = harness.Server(root / "data", environment={"LD_PRELOAD": str(library),
                                                                 "ANYRATE_FAULTS": str(self.disk.file)})
        self.answers = {}
        self.kept = self.post()[1]
        self.frames = self.finish(self.kept)
        self.kept_log = self.server.sealed(self.kept).read_bytes()

    def post(self):
        status, _, answer = self.server.request("POST", "/v1/models?vertices=1500&coarse=400", self.body,
                                                {"Content-Type": "application/zip"})
        return status, json.loads(answer)["id"] if status == 202 else None

    def finish(self, model):
        """Waits for a model. @return the frames of its live log"""
        state = self.server.wait_until_final(model)
        self.findings.expect(state["state"] == "done", f"model {model} is {state['state']}: {state.get('error')}")
        if state["state"] != "done":
            return b""
        log = self.server.sealed(model)
        sound = subprocess.run([self.anyrate, "verify", log], capture_output=True).returncode == 0
        self.findings.expect(sound, f"the log of {model} is not sound")
        return self.server.live(model).read_bytes()[HEADER:]

    def look_around(self, kind):
        """What does not write must go on while the disk fails."""
        status, _, log = self.server.request("GET", f"/v1/models/{self.kept}/log")
        self.findings.expect(status == 200 and log == self.kept_log, f"{kind}: a sealed log was answered with {status}")
        status, _, _ = self.server.request("GET", "/healthz")
        self.findings.expect(status == 200, f"{kind}: healthz says {status}")

    def upload_during(self, kind):
        """@return the models that were acknowledged"""
        acknowledged = []
        self.disk.set(*KINDS[kind])
        for _ in range(4):
            status, model = self.post()
            self.answers.setdefault(kind, []).append(status)
            self.findings.expect(status in (202, 503, 507), f"{kind}: an upload was answered with {status}")
            if kind == "full disk":
                self.findings.expect(status == 507, f"{kind}: expected 507, got {status}")
                ready, _, _ = self.server.request("GET", "/readyz")
                self.findings.expect(ready == 503, f"{kind}: readyz says {ready}")
            if kind == "short writes":
                self.findings.expect(status == 202, f"{kind}: expected 202, got {status}")
            if model:
                acknowledged.append(model)
            self.look_around(kind)
        self.disk.set(0, 0)
        ready, _, _ = self.server.request("GET", "/readyz")
        self.findings.expect(ready == 200, f"{kind} is over and readyz says {ready}")
        for model in acknowledged:
            capture = self.server.data / "models" / model / "capture.zip"
            self.findings.expect(capture.read_bytes() == self.body, f"{kind}: an acknowledged capture is not what was sent")
        return acknowledged

    def job_during(self, kind):
        """A job that finds the disk failing at a random moment, for a while."""
        model = self.post()[1]
        time.sleep(self.random.uniform(0.0, 1.5))
        self.disk.set(*KINDS[kind])
        time.sleep(self.random.uniform(0.2, 1.2))
        self.look_around(kind)
        self.disk.set(0, 0)
        self.findings.expect(self.finish(model) == self.frames, f"{kind}: the frames of {model} are others")


def main():
    given = support.arguments(__doc__, times=6)
    findings = support.Findings("disk_faults", given)
    library = given.anyrate.parent / "tests/fault/libio_faults.so"
    if not library.exists():
        print(f"{library} is missing: build the target io_faults", file=sys.stderr)
        sys.exit(77)
    with support.temporary_folder() as name:
        test = Test(given, findings, support.Path(name), library)
        acknowledged = [model for kind in KINDS for model in test.upload_during(kind)]
        for i in range(given.times):
            test.job_during(list(KINDS)[i % len(KINDS)])
        for model in acknowledged:
            findings.expect(test.finish(model) == test.frames, f"the frames of {model} are others")
        findings.expect(test.server.stop() == 0, "the server did not end well")
        findings.finish(answers=test.answers, jobs=given.times, acknowledged=len(acknowledged))


main()
