"""What the fault tests share: the end-to-end tests' server, a small capture, and the arguments of a test.

Every test runs by hand: python3 tests/fault/NAME.py build/anyrate [--times N] [--seconds S] [--seed N]; without
arguments after the binary it takes its short form, as in tests/run.sh. It prints one JSON object with what it found and
ends with 1 if anything was not as it has to be. Processes are killed by the numbers of those it started.
"""
import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def arguments(description, times=None, seconds=None, vertices=None):
    """The parsed command line; the harness learns of the binary."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("anyrate", type=Path)
    if times is not None:
        parser.add_argument("--times", type=int, default=times, help="how often the fault happens (short form: %(default)s)")
    if seconds is not None:
        parser.add_argument("--seconds", type=float, default=seconds, help="how long it runs (short form: %(default)s)")
    if vertices is not None:
        parser.add_argument("--vertices", type=int, default=vertices,
                            help="of each model: fewer for a machine that is busy (%(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    given.anyrate = given.anyrate.resolve()
    given.random = random.Random(given.seed)
    return given


def load_harness(anyrate):
    """tests/e2e/server/harness.py, which takes the binary from the command line."""
    sys.path.insert(0, str(ROOT / "tests/e2e/server"))
    sys.argv = [sys.argv[0], str(anyrate)]
    import harness
    return harness


def make_capture(anyrate, folder, views=12, width=160, height=120):
    """A small simulated capture. @return (its folder, its zip)"""
    capture = Path(folder) / "capture"
    subprocess.run([anyrate, "simulate", "--scene", "vessel", "-o", capture, "--views", str(views), "--width", str(width),
                    "--height", str(height)], check=True, capture_output=True)
    archive = Path(folder) / "capture.zip"
    with zipfile.ZipFile(archive, "w") as out:
        for file in sorted(capture.rglob("*")):
            if file.is_file() and file.suffix in (".png", ".json"):
                out.write(file, file.relative_to(capture))
    return capture, archive


def rounds(n):
    """0 to n - 1; fewer if the test is told to end (SIGTERM): then it says what it has seen so far."""
    told = []
    signal.signal(signal.SIGTERM, lambda *_: told.append(True))
    for i in range(n):
        if told:
            return
        yield i


class Stalls(threading.Thread):
    """Notices when this process did not run for a while, because the machine slept or somebody stopped its processes: what
    was in the air meanwhile is cut by the server's limits with good reason."""

    LEAST = 5.0  # seconds: a busy machine's scheduler makes nobody wait so long

    def __init__(self):
        super().__init__(daemon=True)
        self.ends = []  # of each stall, on the monotonic clock
        self.start()

    def run(self):
        last = time.monotonic()
        while True:
            time.sleep(0.1)
            now = time.monotonic()
            if now - last > self.LEAST:
                self.ends.append(now)
            last = now

    def since(self, begun):
        """Whether one ended after `begun`; waits a moment, for the thread to notice one that has just ended."""
        time.sleep(0.3)
        return any(end > begun for end in self.ends)


def temporary_folder():
    return tempfile.TemporaryDirectory(prefix="anyrate-fault-")


class Findings:
    """Collects what a test saw; ends the process with its verdict."""

    def __init__(self, test, given):
        self.report = {"test": test, "seed": given.seed}
        self.faults = []

    def expect(self, holds, sentence):
        if not holds:
            self.faults.append(sentence)
            print(f"{self.report['test']}: {sentence}", file=sys.stderr, flush=True)

    def finish(self, **figures):
        self.report.update(figures)
        self.report["faults"] = len(self.faults)
        self.report["examples"] = self.faults[:5]
        print(json.dumps(self.report))
        sys.exit(1 if self.faults else 0)


def rss_bytes(pid):
    """Resident memory of a process."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) * 1024
    return 0


def processor_seconds(pid):
    """That a process and those of its children that have ended have used: what a machine that stands still or is busy with
    other things does not change."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return sum(int(field) for field in fields[11:15]) / os.sysconf("SC_CLK_TCK")


def n_descriptors(pid):
    return len(list(Path(f"/proc/{pid}/fd").iterdir()))
