"""Hostile paths, ids and headers: no answer shows a file of the machine, none is a 5xx, and the server stays well."""
import socket

import support

SECRET = b"root:x:0:"


def paths(random):
    ids = ["a" * 26, "A" * 26, "..", "../../../../etc/passwd", "%2e%2e%2f%2e%2e%2fetc%2fpasswd", "a" * 25, "a" * 27,
           "a" * 5000, "%00" * 26, "a" * 25 + "%00", "a" * 25 + "/", "a" * 25 + "'", "%FF" * 26, "0" * 26, "\u202e" * 9,
           "a" * 13 + "/../" + "a" * 9, "....//....//etc/passwd", "..;/..;/etc/passwd", "..\\..\\etc\\passwd", "~root",
           "file:///etc/passwd", "$(id)", "`id`", "%25%32%65%25%32%65/", "con", "nul", ".", "", " ", "%20", "%0d%0aX: y"]
    ends = ["", "/log", "/index", "/mesh.ply", "/live", "/events", "/../../catalog.sqlite", "/log/../../../catalog.sqlite",
            "/mesh.ply%00.obj", "/log?bytes=-1", "/log?vertices=99999999999999999999", "/log?distortion=nan", "/%2e%2e/lock",
            "/log?vertices=%00", "/log?a=" + "b" * 4000, "/mesh.glb?vertices=1e9", "/log#x", "/log?" + "&" * 500]
    tops = ["/v1/models/", "/v1/models//", "//v1/models/", "/v1/captures/", "/../", "/..%2f", "/%2e%2e/", "/v1/../../", "/"]
    return random.choice(tops) + random.choice(ids) + random.choice(ends)


def headers(random):
    name = random.choice(["Range", "If-Range", "If-None-Match", "Content-Length", "Transfer-Encoding", "Authorization",
                          "Idempotency-Key", "Host", "Expect", "Content-Type", "X" * 3000, "Accept-Encoding", "Upgrade",
                          "Content-Digest", "Connection", "Origin", "Cookie", "X-Forwarded-For"])
    value = random.choice(["bytes=0-", "bytes=-0", "bytes=5-2", "bytes=" + ",".join("0-1" for _ in range(500)),
                           "bytes=99999999999999999999-", "-1", "18446744073709551616", "0x10", "chunked, chunked",
                           "gzip, chunked", "Bearer " + "a" * 3000, "Bearer \x00", "\xff\xfe", "a" * 9000, "\"", "W/\"\"",
                           "' OR 1=1 --", "../../etc/passwd", "100-continue", "websocket", "", "sha-256=:AAAA:", "%s%s%n"])
    return f"{name}: {value}"


def ask(server, data):
    try:
        with socket.create_connection(server.address, timeout=30) as connection:
            connection.sendall(data)
            connection.settimeout(30)
            answer = b""
            while len(answer) < 100_000:
                piece = connection.recv(65536)
                if not piece:
                    break
                answer += piece
                if b"\r\n\r\n" in answer and b"text/event-stream" in answer:
                    break
            return answer
    except (ConnectionError, socket.timeout):
        return b""


def main():
    given = support.arguments(__doc__, times=200)
    findings = support.Findings("hostile_requests", given)
    harness = support.load_harness(given.anyrate)
    with support.temporary_folder() as name:
        server = harness.Server(support.Path(name) / "data")
        statuses = {}
        for _ in range(given.times):
            random = given.random
            method = random.choice(["GET"] * 6 + ["HEAD", "POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "G\x00T", "get",
                                                  "M" * 300])
            lines = [f"{method} {paths(random)} HTTP/1.1", "Host: test", "Connection: close"]
            lines += [headers(random) for _ in range(random.randrange(4))]
            data = ("\r\n".join(lines) + "\r\n\r\n").encode("latin-1", "replace")
            answer = ask(server, data)
            status = int(answer[9:12]) if answer.startswith(b"HTTP/1.1 ") else 0  # 0: closed without a word
            statuses[status] = statuses.get(status, 0) + 1
            findings.expect(status < 500 or status == 501, f"{status} to {data[:200]!r}")
            findings.expect(SECRET not in answer and b"SQLite format" not in answer, f"a file escaped to {data[:200]!r}")
            findings.expect(server.process.poll() is None, f"the server died of {data[:200]!r}")
            if server.process.poll() is not None:
                break
        findings.expect(server.request("GET", "/healthz")[0] == 200, "the server is not well afterwards")
        findings.expect(server.stop() == 0, "the server did not end well")
        findings.finish(requests=given.times, statuses={str(k): v for k, v in sorted(statuses.items())})


main()
