"""Requests a second for prefixes of a sealed log: `anyrate serve` beside nginx that serves the same bytes as a file.

  tests/bench/static_throughput.py [--rounds 5] [--seconds 4]

Needs Debian's nginx-light and wrk. Both servers listen on this machine with as many network threads as wrk leaves them to
share; rounds alternate between the two, and the result is the ratio of the medians: of the whole log of about 400 KB, and
of ranges of 20 KB at random places of it. nginx runs with sendfile, keep-alive without a limit and no access log, which is
how it is fastest here. Prints JSON.
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request

from measuring import ROOT, machine

NGINX_CONFIG = """
worker_processes {cores};
pid {folder}/nginx.pid;
error_log {folder}/error.log;
events {{ worker_connections 1024; }}
http {{
    access_log off;
    sendfile on;
    tcp_nopush on;
    keepalive_requests 1000000000;
    client_body_temp_path {folder}/body; proxy_temp_path {folder}/proxy; fastcgi_temp_path {folder}/fastcgi;
    uwsgi_temp_path {folder}/uwsgi; scgi_temp_path {folder}/scgi;
    types {{ model/vnd.anyrate arl; }}
    {cache}
    server {{ listen 127.0.0.1:{port}; root {root}; }}
}}
"""

# Ranges of 20 KB that begin at random 1,024 bytes, so that neither server can answer from one prepared response.
RANGES_LUA = """
local size = {size}
local requests = {{}}
init = function()
    for i = 1, 1000 do
        local first = math.random(0, math.floor((size - 20480) / 1024)) * 1024
        requests[i] = wrk.format("GET", nil, {{ ["Range"] = "bytes=" .. first .. "-" .. (first + 20479) }})
    end
end
local next = 0
request = function()
    next = next % 1000 + 1
    return requests[next]
end
"""


def free_port():
    import socket
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Nginx:
    def __init__(self, folder, root, options):
        self.port = free_port()
        cache = "open_file_cache max=100 inactive=1h;" if options.open_file_cache else ""
        config = folder / "nginx.conf"
        config.write_text(NGINX_CONFIG.format(cores=os.cpu_count(), folder=folder, root=root, port=self.port, cache=cache))
        self.process = subprocess.Popen([options.nginx, "-c", config, "-p", folder, "-g", "daemon off;"],
                                        stderr=subprocess.DEVNULL)
        self.url = f"http://127.0.0.1:{self.port}/model.arl"

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()


class Anyrate:
    """A server with one finished model whose log is `log`."""

    def __init__(self, folder, build, capture):
        self.process = subprocess.Popen([build / "anyrate", "serve", "--listen", "127.0.0.1:0", "--data", folder],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.base = self.process.stdout.readline().split()[-1]
        done = subprocess.run([build / "anyrate", "push", capture, "--server", self.base, "--wait", "--vertices", "3000"],
                              check=True, capture_output=True, text=True)
        self.model = done.stdout.strip()
        self.url = f"{self.base}/v1/models/{self.model}/log"
        self.sealed = folder / "models" / self.model / "model.arl"

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()


def processor_seconds(pid):
    """Of a process and its children, in user and kernel mode."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    own = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    children = [child for task in pathlib.Path(f"/proc/{pid}/task").iterdir() for child in (task / "children").read_text().split()]
    return own + sum(processor_seconds(child) for child in children)


def wait_for(url):
    for _ in range(200):
        try:
            with urllib.request.urlopen(url) as response:
                return response.read()
        except OSError:
            time.sleep(0.05)
    raise SystemExit(f"{url} does not answer")


def requests_per_second(url, options, script=None):
    command = [options.wrk, f"-t{options.threads}", f"-c{options.connections}", f"-d{options.seconds}s"]
    if script:
        command += ["-s", script]
    said = subprocess.run([*command, url], check=True, capture_output=True, text=True).stdout
    if "Non-2xx" in said or "Socket errors" in said:
        raise SystemExit(f"{url}: {said}")
    return float(re.search(r"Requests/sec:\s+([0-9.]+)", said).group(1))


def compare(servers, options, script=None):
    """Rates of both servers in rounds that alternate, and the ratio of their medians. wrk takes its part of the same cores,
    the same for each request of either; so the processor time that the servers themselves need is told, too."""
    rates = {name: [] for name in servers}
    costs_us = {name: [] for name in servers}  # of a request
    for server in servers.values():
        requests_per_second(server.url, argparse.Namespace(**{**vars(options), "seconds": 1}), script)  # warm
    for _ in range(options.rounds):
        for name, server in servers.items():
            before = processor_seconds(server.process.pid)
            rates[name].append(requests_per_second(server.url, options, script))
            spent = processor_seconds(server.process.pid) - before
            costs_us[name].append(round(1e6 * spent / (rates[name][-1] * options.seconds), 2))
    rate = {name: statistics.median(values) for name, values in rates.items()}
    cost = {name: statistics.median(values) for name, values in costs_us.items()}
    return {"requests_per_second": rates, "ratio": rate["anyrate"] / rate["nginx"], "server_microseconds_a_request": costs_us,
            "nginx_cost_over_anyrate_cost": cost["nginx"] / cost["anyrate"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=int, default=4, help="of one round")
    parser.add_argument("--connections", type=int, default=64)
    parser.add_argument("--threads", type=int, default=2, help="of wrk")
    parser.add_argument("--size", type=int, default=400_000, help="bytes of the log")
    parser.add_argument("--open-file-cache", action="store_true", help="let nginx keep the file open")
    parser.add_argument("--nginx", default=shutil.which("nginx") or "/usr/sbin/nginx")
    parser.add_argument("--wrk", default=shutil.which("wrk"))
    options = parser.parse_args()
    if not options.wrk or not pathlib.Path(options.nginx).exists():
        raise SystemExit("static_throughput.py needs the Debian packages nginx-light and wrk")

    folder = pathlib.Path(tempfile.mkdtemp(prefix="anyrate-static-"))
    servers = []
    try:
        for name in ("nginx", "www", "data"):
            (folder / name).mkdir()
        folder.chmod(0o755)
        capture = folder / "capture"
        subprocess.run([options.build / "anyrate", "simulate", "--scene", "vessel", "-o", capture, "--views", "10", "--width",
                        "160", "--height", "120"], check=True, capture_output=True)
        servers.append(anyrate := Anyrate(folder / "data", options.build, capture))
        # A log of the wanted size: the model's own, made longer. Servers of prefixes and ranges do not look into it.
        log = bytearray(anyrate.sealed.read_bytes())
        log += os.urandom(max(0, options.size - len(log)))
        anyrate.sealed.write_bytes(log)
        (folder / "www" / "model.arl").write_bytes(log)
        servers.append(nginx := Nginx(folder / "nginx", folder / "www", options))
        both = {"anyrate": anyrate, "nginx": nginx}
        bodies = {name: wait_for(server.url) for name, server in both.items()}
        if bodies["anyrate"] != bodies["nginx"] or len(bodies["nginx"]) != len(log):
            raise SystemExit("the two servers do not serve the same bytes")
        script = folder / "ranges.lua"
        script.write_text(RANGES_LUA.format(size=len(log)))
        version = subprocess.run([options.nginx, "-v"], capture_output=True, text=True).stderr.strip()
        result = {"machine": machine(), "nginx": version, "connections": options.connections, "log_bytes": len(log),
                  "whole_log": compare(both, options), "ranges_of_20_KB": compare(both, options, script)}
        json.dump(result, sys.stdout, indent=1)
        print()
    finally:
        for server in servers:
            server.stop()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
