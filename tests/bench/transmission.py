"""Distortion against time while a finished model arrives over slow links, beside the finished mesh as one Draco file.

  tests/bench/transmission.py [--capture FOLDER] [--vertices 10000] [--out FOLDER]

`anyrate serve` holds the model; `anyrate fetch --trace --throttle --latency` gets it over HTTP (ranges) and over the
WebSocket. The Draco file (single rate, level 10, same grid, geometry only: without the colours that the log has) is what
one would download instead: nothing is seen until its last byte, whose time is that of one request over the same link.
Without --capture a vessel is simulated. Prints JSON; with --out also CSV and SVG plots.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

from measuring import ROOT, machine
from svg_plot import Series, line_plot

LINKS = {"1.6 Mbit/s": (200_000, 50), "10 Mbit/s": (1_250_000, 25), "100 Mbit/s": (12_500_000, 10)}  # bytes/s, ms one way


def call(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True).stdout


def trace_of(build, url, folder, rate, latency, *options):
    trace = folder / "trace.json"
    call(build / "anyrate", "fetch", url, "-o", folder / "fetched.arl", "--trace", trace, "--throttle", rate, "--latency",
         latency, *options)
    frames = json.loads(trace.read_text())["frames"]
    # A colour frame repeats the distortion of the geometry before it; the mesh is complete with it.
    return [{key: frame[key] for key in ("seconds", "bytes", "vertices", "distortion")} for frame in frames]


def steps(frames, end):
    """What is seen at any time: a frame's distortion until the next one arrives."""
    points = []
    for frame in frames:
        if frame["distortion"] is None:
            continue
        if points:
            points.append((frame["seconds"], points[-1][1]))
        points.append((frame["seconds"], frame["distortion"]))
    return [*points, (end, points[-1][1])]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--capture", type=pathlib.Path)
    parser.add_argument("--vertices", type=int, default=10_000)
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--data", type=pathlib.Path, help="data directory of the server; a temporary one by default")
    parser.add_argument("--model", help="of --data, made by an earlier run, whose id is in the JSON")
    options = parser.parse_args()
    anyrate = options.build / "anyrate"
    with tempfile.TemporaryDirectory(prefix="anyrate-transmission-") as name:
        folder = pathlib.Path(name)
        capture = options.capture or folder / "vessel"
        if not options.capture:
            call(anyrate, "simulate", "--scene", "vessel", "-o", capture)
        server = subprocess.Popen([anyrate, "serve", "--listen", "127.0.0.1:0", "--data",
                                   options.data or folder / "data"],
                                  stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            base = server.stdout.readline().split()[-1]
            model = options.model or call(anyrate, "push", capture, "--server", base, "--wait", "--vertices",
                                          options.vertices).strip()
            url = f"{base}/v1/models/{model}"
            call(anyrate, "fetch", url, "-o", folder / "whole.arl")
            call(anyrate, "decode", folder / "whole.arl", "-o", folder / "whole.ply")
            single = json.loads(call(options.build / "bench" / "single_rate", folder / "whole.ply", "--model",
                                     folder / "whole.arl"))
            result = {"machine": machine(), "capture": capture.name, "model": model, "log_bytes": (folder / "whole.arl").stat().st_size,
                      "single_rate": single, "links": {}}
            rows = []
            for link, (rate, latency) in LINKS.items():
                http = trace_of(options.build, url, folder, rate, latency)
                socket = trace_of(options.build, url, folder, rate, latency, "--live")
                # Connection and request take a round trip each, then the bytes come.
                seconds = 4 * latency / 1000 + single["bytes"] / rate
                whole = http[-1]["distortion"]
                half = next(frame["seconds"] for frame in http if frame["distortion"] is not None
                            and frame["distortion"] <= (http[0]["distortion"] + whole) / 2)
                result["links"][link] = {"bytes_per_second": rate, "latency_ms": latency, "http": http, "websocket": socket,
                                         "single_rate_seconds": seconds, "first_mesh_seconds": http[0]["seconds"],
                                         "half_of_the_gain_seconds": half, "all_seconds": http[-1]["seconds"]}
                if options.out:
                    options.out.mkdir(parents=True, exist_ok=True)
                    end = 1.1 * max(seconds, http[-1]["seconds"], socket[-1]["seconds"])
                    plot = line_plot(f"{capture.name} over {link}, {2 * latency} ms there and back", "seconds",
                                     "distortion (Psi)", [
                        Series("log over HTTP", steps(http, end), dots=False),
                        Series("log over WebSocket", steps(socket, end), dashed=True, dots=False),
                        Series("finished mesh, single-rate Draco", [(seconds, http[0]["distortion"]), (seconds, whole),
                                                                    (end, whole)], dots=False)])
                    slug = link.replace(" ", "_").replace("/", "_").replace(".", "_")
                    (options.out / f"transmission_{capture.name}_{slug}.svg").write_text(plot)
                    rows += [f"{link},{path},{f['seconds']:.4f},{f['bytes']},{f['vertices']},{f['distortion']}"
                             for path, frames in (("http", http), ("websocket", socket)) for f in frames]
                    rows.append(f"{link},draco,{seconds:.4f},{single['bytes']},{single['vertices']},{whole}")
            if options.out:
                table = "link,path,seconds,bytes,vertices,distortion\n" + "\n".join(rows) + "\n"
                (options.out / f"transmission_{capture.name}.csv").write_text(table)
                (options.out / f"transmission_{capture.name}.json").write_text(json.dumps(result, indent=1) + "\n")
            json.dump(result, sys.stdout, indent=1)
            print()
        finally:
            server.terminate()
            server.wait()


if __name__ == "__main__":
    main()
