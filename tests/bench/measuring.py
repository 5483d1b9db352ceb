"""What the benchmark scripts of this folder share: finding captures and tools, running a command and what it cost, and
measuring a mesh. Python's standard library only.

Captures are folders, or names in ANYRATE_SHARED/data (../shared beside the project if that is not set). Distances are
those of ANYRATE_SHARED/tools/eval_mesh if it is there, else of `anyrate compare`; results say which.
"""
import argparse
import json
import os
import pathlib
import platform
import subprocess
import sys
import tempfile
import time
from types import SimpleNamespace

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = pathlib.Path(os.environ.get("ANYRATE_SHARED") or ROOT.parent / "shared")


class CommandFailed(RuntimeError):
    """A program of a benchmark ended badly; the message is its own last line."""


def machine():
    cpu = platform.processor()
    try:
        with open("/proc/cpuinfo") as f:
            cpu = next((line.split(":", 1)[1].strip() for line in f if line.startswith("model name")), cpu)
    except OSError:
        pass
    return {"cpu": cpu, "cores": os.cpu_count(), "load_average": os.getloadavg()[0], "system": platform.platform()}


def run(*command):
    """Runs a program to its end. @return stdout, wall seconds, CPU seconds and peak resident bytes of it alone."""
    start = time.monotonic()
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen([str(word) for word in command], stdout=out, stderr=err)
        _, status, usage = os.wait4(process.pid, 0)  # unlike wait(), tells what this one child used
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.monotonic() - start
        out.seek(0)
        err.seek(0)
        if process.returncode != 0:
            said = err.read().decode(errors="replace").strip().splitlines() or ["nothing said"]
            raise CommandFailed(f"{pathlib.Path(str(command[0])).name} ended with {process.returncode}: {said[-1]}")
        return SimpleNamespace(
            stdout=out.read().decode(),
            seconds=seconds,
            cpu_seconds=usage.ru_utime + usage.ru_stime,
            peak_memory_bytes=usage.ru_maxrss * 1024,
        )


CAMERAS = {"pot": "cameras_2ring.json"}  # of the shared captures that are measured with others than cameras.json


def parser(doc, captures):
    """The options that all benchmarks have."""
    options = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help="where anyrate and bench/ were built")
    options.add_argument("--captures", nargs="*", default=captures, help="names of shared captures, or folders")
    options.add_argument("--out", type=pathlib.Path, help="folder that results are written into")
    options.add_argument("--work", type=pathlib.Path, help="keeps models and meshes there")
    return options


def find_capture(name):
    """The folder of a capture, or None, saying so, if it is one of the shared ones and they are not here."""
    for folder in (pathlib.Path(name), SHARED / "data" / name):
        if (folder / "cameras.json").is_file():
            return folder
    print(f"skipped {name}: no capture there, nor in {SHARED / 'data'}", file=sys.stderr)
    return None


def evaluator():
    return "eval_mesh" if (SHARED / "tools" / "eval_mesh").exists() else "anyrate compare"


class Bench:
    """The programs of one build, and a folder for what they write."""

    def __init__(self, build, work):
        self.anyrate = build / "anyrate"
        self.tools = build / "bench"
        self.work = work
        work.mkdir(parents=True, exist_ok=True)
        if not self.anyrate.exists() or not (self.tools / "mesh_report").exists():
            sys.exit(f"{build}: not built; run: cmake --build {build} --target bench_tools")

    def tool(self, name, *arguments):
        """The JSON that a tool of this folder prints."""
        return json.loads(run(self.tools / name, *arguments).stdout)

    def reconstruct(self, capture, name, *options):
        """Runs `anyrate reconstruct`. @return (model file, its report with "wall_seconds" and "peak_memory_bytes")"""
        model, report = self.work / f"{name}.arl", self.work / f"{name}.json"
        done = run(self.anyrate, "reconstruct", capture, "-o", model, "--report", report, "--quiet", *options)
        told = json.loads(report.read_text())
        told.update(wall_seconds=done.seconds, cpu_seconds=done.cpu_seconds, peak_memory_bytes=done.peak_memory_bytes)
        return model, told

    def mesh_of(self, name, n_vertices=None):
        """Where decode() puts the mesh of a model that reconstruct() named."""
        return self.work / f"{name}-{n_vertices or 'all'}.ply"

    def decode(self, model, n_vertices=None):
        budget = [] if n_vertices is None else ["--vertices", n_vertices]
        mesh = self.mesh_of(model.stem, n_vertices)
        run(self.anyrate, "decode", model, "-o", mesh, *budget)
        return mesh

    def simplify(self, mesh, n_vertices):
        simple = self.work / f"{mesh.stem}-simplified-{n_vertices}.ply"
        self.tool("simplify_mesh", mesh, "-o", simple, "--vertices", n_vertices)
        return simple

    def psi(self, mesh, capture):
        return self.tool("surface_distortion", mesh, capture)

    def seen(self, mesh, capture, truth=None, cameras="cameras.json"):
        """Distances to the true surface where two cameras see it, in parts of its diagonal; None without a truth."""
        truth = truth or capture / "gt.ply"
        if not truth.exists():
            return None
        if evaluator() == "eval_mesh":
            done = run(SHARED / "tools" / "eval_mesh", mesh, truth, "--cameras", capture / cameras)
        else:
            done = run(self.anyrate, "compare", mesh, truth, "--capture", capture, "--json")
        told = json.loads(done.stdout)["seen"]
        return {key: told[key] for key in ("mean", "accuracy", "completeness", "p90", "hausdorff")}


def in_work_folder(options, measure):
    """Calls measure(bench) with a work folder that is gone afterwards unless --work names one."""
    with tempfile.TemporaryDirectory(prefix="anyrate-bench-") as temporary:
        return measure(Bench(options.build, options.work or pathlib.Path(temporary)))


def finish(result, options, name):
    """Prints the result as JSON, and writes it to --out too."""
    text = json.dumps(result, indent=1)
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / f"{name}.json").write_text(text + "\n")
    print(text)


def start(main):
    """Calls main(); a command that fails ends the script with its sentence."""
    try:
        main()
    except CommandFailed as failure:
        sys.exit(str(failure))


def note(text):
    print(text, file=sys.stderr, flush=True)
