#!/usr/bin/env python3
"""Lets the fuzz targets of a part look for inputs for hours; prints JSON: executions, coverage and processor time of each.

usage: tests/fuzz/long_run.py [--build build-sanitized] [--part proto] [--hours 2] [--jobs 2] [--work FOLDER] [--out FILE]

Build the targets first, as tests/run.sh does (build-sanitized). Hours are of processor time, of all targets of the part together: a
machine that is busy with other things takes longer, and finds no less. Whichever target has had least runs next, on a copy of
its corpus that grows in the work folder. A run that was stopped goes on where it was if it is given the same work folder: the
inputs that it had kept, and the time and executions that its targets had had. The first finding ends everything (exit code 1):
its input is named, and joins tests/fuzz/PART/corpus with the fix.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SLICE_SECONDS = 300  # of a target at a time
# As in tests/fuzz/CMakeLists.txt, but for the time an input may take: a machine that stands still is no finding.
LIMITS = ["-timeout=1200", "-rss_limit_mb=1024", "-malloc_limit_mb=128"]


class Target:
    """A target's program, its growing corpus, and what it has done so far, in earlier runs on the same work folder too."""

    def __init__(self, program, inputs, work):
        self.name, self.program = program.name, program
        self.corpus, self.found = work / program.name / "corpus", work / program.name / "found"
        self.found.mkdir(parents=True, exist_ok=True)
        shutil.copytree(inputs, self.corpus, dirs_exist_ok=True)
        self.history = work / program.name / "done.json"
        self.done = {"cpu_seconds": 0.0, "executions": 0, "covered_edges": 0, "features": 0}
        if self.history.exists():
            self.done.update(json.loads(self.history.read_text()))
        self.is_running, self.trouble = False, None

    @property
    def cpu_seconds(self):
        return self.done["cpu_seconds"]

    def run(self, seconds):
        """One slice; the processor time is the process's own."""
        command = [self.program, f"-max_total_time={seconds}", *LIMITS, "-print_final_stats=1"]
        command += [f"-artifact_prefix={self.found}/", self.corpus]
        with tempfile.TemporaryFile("w+", errors="replace") as log:
            process = subprocess.Popen([str(part) for part in command], stdout=log, stderr=subprocess.STDOUT)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            log.seek(0)
            said = log.read()
        executed = re.findall(r"stat::number_of_executed_units:\s*(\d+)", said)
        progress = re.findall(r"cov: (\d+) ft: (\d+)", said)
        self.done["cpu_seconds"] += usage.ru_utime + usage.ru_stime
        self.done["executions"] += int(executed[-1]) if executed else 0
        if progress:
            for what, reached in zip(("covered_edges", "features"), progress[-1]):
                self.done[what] = max(self.done[what], int(reached))
        self.history.write_text(json.dumps(self.done))
        if process.returncode != 0:
            inputs = sorted(map(str, self.found.iterdir()))
            self.trouble = {"exit": process.returncode, "inputs": inputs, "said": said[-4000:]}

    def report(self):
        told = dict(self.done, cpu_seconds=round(self.cpu_seconds, 1))
        told.update(corpus_inputs=sum(1 for _ in self.corpus.iterdir()), finding=self.trouble)
        return told


def targets_of(part, build, work):
    """The part's targets, as its CMakeLists.txt lists them."""
    listed = (ROOT / "tests/fuzz" / part / "CMakeLists.txt").read_text()
    names = re.findall(r"^add_fuzz_target\((\w+) (\w+)", listed, re.MULTILINE)
    programs = [(build / "tests/fuzz" / part / name, ROOT / "tests/fuzz" / part / "corpus" / corpus) for name, corpus in names]
    missing = [str(program) for program, _ in programs if not program.exists()]
    if missing:
        sys.exit(f"expected built fuzz targets, found none at {', '.join(missing)}: build them as tests/run.sh does")
    return [Target(program, inputs, work) for program, inputs in programs]


def run_all(targets, wanted, jobs, tell):
    """Until all targets together have had `wanted` seconds of processor time, or one has found something."""
    lock = threading.Lock()

    def enough():
        return sum(target.cpu_seconds for target in targets) >= wanted or any(target.trouble for target in targets)

    def keep_running():
        while True:
            with lock:
                idle = [target for target in targets if not target.is_running]
                if enough() or not idle:
                    return
                target = min(idle, key=lambda target: target.cpu_seconds)
                target.is_running = True
                left = wanted - sum(target.cpu_seconds for target in targets)
            target.run(max(5, min(SLICE_SECONDS, int(left / jobs) + 1)))
            with lock:
                target.is_running = False
                tell()

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for done in [pool.submit(keep_running) for _ in range(jobs)]:
            done.result()


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--build", type=pathlib.Path, default=ROOT / "build-sanitized")
    options.add_argument("--part", default="proto", help="a folder of tests/fuzz")
    options.add_argument("--hours", type=float, default=2, help="of processor time")
    options.add_argument("--jobs", type=int, default=os.cpu_count())
    options.add_argument("--work", type=pathlib.Path, help="where corpora grow and findings lie; a new folder by default")
    options.add_argument("--out", type=pathlib.Path, help="also writes the JSON here, after every slice")
    options = options.parse_args()
    work = options.work or pathlib.Path(tempfile.mkdtemp(prefix="anyrate-fuzz-"))
    targets = targets_of(options.part, options.build, work)
    began = time.monotonic()

    def report():
        told = {"work": str(work), "wall_seconds": round(time.monotonic() - began, 1)}
        told["cpu_seconds"] = round(sum(target.cpu_seconds for target in targets), 1)
        told["executions"] = sum(target.done["executions"] for target in targets)
        told["targets"] = {target.name: target.report() for target in targets}
        return json.dumps(told, indent=2)

    def tell():
        if options.out:
            options.out.write_text(report() + "\n")
        done = sum(target.cpu_seconds for target in targets)
        print(f"{done:.0f} of {3600 * options.hours:.0f} s", file=sys.stderr, flush=True)

    run_all(targets, 3600 * options.hours, min(options.jobs, len(targets)), tell)
    print(report())
    return 1 if any(target.trouble for target in targets) else 0


if __name__ == "__main__":
    sys.exit(main())
