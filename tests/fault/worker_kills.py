"""Workers are killed at random moments, frozen and overtaken; the model ends as if nobody had ever touched it.

Each job is made once undisturbed and then again, from the same capture under the same id, by workers that are killed
(or stopped, overtaken by the next worker's lease, and let go). After every death the log must be a front of the
undisturbed one and no shorter than readers have seen it; a worker that finds a mark must go on there, and the finished
model must be the undisturbed one byte for byte.
"""
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import support

MODEL = "a" * 26
HEADER = 96  # bytes of a live log before its base


def worker(given, data, epoch):
    return subprocess.Popen([given.anyrate, "worker", "--data", data, "--model", MODEL, "--epoch", str(epoch), "--vertices",
                             str(given.vertices), "--coarse", "600"],
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)


def prepare(data, archive):
    folder = data / "models" / MODEL
    folder.mkdir(parents=True)
    shutil.copy(archive, folder / "capture.zip")
    return folder


def messages(process):
    return [json.loads(line) for line in process.stdout.read().splitlines()]


def n_bytes_begun(found):
    return next((m["bytes"] for m in found if m["type"] == "begun"), None)


def index_bytes(folder):
    """Of the side index, which tells readers how far the log goes."""
    index = folder / "log.live.idx"
    return index.stat().st_size if index.exists() else 0


def kill(process):
    process.send_signal(signal.SIGKILL)
    found = messages(process)
    process.wait()
    return found


def main():
    given = support.arguments(__doc__, times=12, vertices=3000)
    findings = support.Findings("worker_kills", given)
    with support.temporary_folder() as name:
        root = support.Path(name)
        _, archive = support.make_capture(given.anyrate, root)
        calm = prepare(root / "calm", archive)
        begun = time.monotonic()
        undisturbed = worker(given, root / "calm", 1)
        messages(undisturbed)
        findings.expect(undisturbed.wait() == 0, "the undisturbed worker failed")
        whole_time = time.monotonic() - begun
        sealed, live = (calm / "model.arl").read_bytes(), (calm / "log.live").read_bytes()

        n_kills = n_jobs = n_resumed = n_overtaken = 0
        while n_kills < given.times:
            n_jobs += 1
            data = root / f"job{n_jobs}"
            folder = prepare(data, archive)
            seen_rows, frozen, epoch = 0, [], 0
            while True:
                epoch += 1
                mark = (folder / "log.live.mark").exists()
                process = worker(given, data, epoch)
                for old in frozen:  # it was overtaken: whatever it tries now must change nothing
                    old.send_signal(signal.SIGCONT)
                try:
                    # Longer than a whole job now and then, until there is a mark: else it might never come to its base.
                    process.wait(given.random.uniform(0, (1.0 if mark else 1.6) * whole_time)
                                 if n_kills < given.times else None)
                except subprocess.TimeoutExpired:
                    pass
                if process.poll() is not None:
                    found = messages(process)
                    findings.expect(process.returncode == 0, f"a worker ended with {process.returncode}: {found[-1:]}")
                else:
                    n_kills += 1
                    if given.random.random() < 0.25:
                        os.kill(process.pid, signal.SIGSTOP)
                        frozen.append(process)
                        n_overtaken += 1
                        found = []
                    else:
                        found = kill(process)
                at = n_bytes_begun(found)
                if mark and at is not None:
                    n_resumed += 1
                    findings.expect(at > 0, "a worker began anew though there was a mark")
                log = (folder / "log.live").read_bytes() if (folder / "log.live").exists() else b""
                if log[:HEADER] == live[:HEADER]:  # before, it is a preview, or nothing
                    findings.expect(live.startswith(log),
                                    f"job {n_jobs}, epoch {epoch}: the log is no front of the undisturbed one")
                    rows = index_bytes(folder)
                    findings.expect(rows >= seen_rows, f"job {n_jobs}: readers lost rows: {seen_rows} to {rows} bytes")
                    seen_rows = rows
                if process.returncode == 0:
                    break
                if n_kills % 20 == 0 and n_kills:
                    print(f"{n_kills} of {given.times}", file=sys.stderr, flush=True)
                if epoch > 400:
                    findings.expect(False, f"job {n_jobs} does not end")
                    break
            for old in frozen:
                found = messages(old)
                old.wait()
                findings.expect(not found or found[-1]["type"] != "failed", f"an overtaken worker said {found[-1:]}")
            findings.expect((folder / "model.arl").read_bytes() == sealed, f"job {n_jobs}: the model is another")
            findings.expect((folder / "log.live").read_bytes() == live, f"job {n_jobs}: the live log is another")
            shutil.rmtree(data)
    findings.finish(kills=n_kills, vertices=given.vertices, overtaken=n_overtaken, jobs=n_jobs, resumed=n_resumed,
                    undisturbed_seconds=round(whole_time, 2), model_bytes=len(sealed))


main()
