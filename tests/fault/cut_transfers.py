"""Downloads and live streams that are cut at random points and go on: the bytes are those of the log, and none comes
twice. Where the server takes captures file by file, uploads are cut as well."""
import hashlib
import http.client
import json
import socket

import support


def cut_download(server, model, log, random):
    """Fetches a log by ranges, each cut off in the middle. @return (bytes, bytes that came)"""
    got, n_came, tag = b"", 0, None
    while len(got) < len(log):
        connection = http.client.HTTPConnection(*server.address, timeout=60)
        fields = {"Range": f"bytes={len(got)}-"} | ({"If-Range": tag} if tag else {})
        connection.request("GET", f"/v1/models/{model}/log", headers=fields)
        response = connection.getresponse()
        if response.status != 206:
            raise AssertionError(f"a range was answered with {response.status}")
        tag = response.headers["ETag"]
        left = len(log) - len(got)
        piece = response.read(random.randint(1, max(1, left)))
        got += piece
        n_came += len(piece)
        connection.close()  # in the middle of the body, most often
    return got, n_came


def cut_stream(harness, server, model, random):
    """Follows a live log over WebSockets that are cut. @return (bytes, whether a frame came twice)"""
    got, sequence, twice, log_id = b"", 0, False, None
    while True:
        stream = harness.WebSocket(server, f"/v1/models/{model}/live" + (f"?from={sequence}" if sequence else ""))
        if sequence == 0:
            got = b""  # cut before the first frame: the header comes again
        n_messages = random.randint(1, 6)
        for _ in range(n_messages):
            kind, payload = stream.read()
            if kind == "close":
                return got, twice
            if kind == "text":
                hello = json.loads(payload)
                if hello.get("type") == "hello" and hello["log_id"] != log_id:  # what was there was a preview
                    log_id, got, sequence = hello["log_id"], b"", 0
                continue
            if sequence == 0 and not got:
                got += payload  # the header
                continue
            at = 0
            while at < len(payload):  # whole frames: type, flags, reserved, size, sequence, ..
                size = int.from_bytes(payload[at + 4:at + 8], "little")
                number = int.from_bytes(payload[at + 8:at + 12], "little")
                twice = twice or number != sequence
                sequence = number + 1
                at += 28 + size
            got += payload
        stream.socket.close()


def cut_uploads(server, capture, random, n, findings):
    """Uploads files of a capture, most of them cut at first. @return how many were cut"""
    status, _, answer = server.request("POST", "/v1/captures")
    if status == 404:
        return 0
    place = "/v1/captures/" + json.loads(answer)["id"]
    files = {str(f.relative_to(capture)): f.read_bytes() for f in sorted(capture.rglob("*")) if f.suffix in (".png", ".json")}
    n_cut = 0
    for name, data in files.items():
        for _ in range(max(1, n // len(files))):
            with socket.create_connection(server.address, timeout=60) as connection:
                part = data[:random.randrange(len(data))]
                connection.sendall(f"PUT {place}/files/{name} HTTP/1.1\r\nHost: test\r\nContent-Length: {len(data)}\r\n\r\n"
                                   .encode() + part)
            n_cut += 1
            listing = server.request("GET", place)[2].decode()
            findings.expect(hashlib.sha256(data).hexdigest() not in listing, f"{name} was cut and is listed as arrived")
        status, _, body = server.request("PUT", f"{place}/files/{name}", data)
        findings.expect(status in (200, 201, 204), f"{name}: {status} {body[:200]!r}")
    status, _, answer = server.request("POST", f"/v1/models?vertices=500&coarse=300&capture={place.rsplit('/', 1)[1]}")
    findings.expect(status == 202, f"the capture was answered with {status}: {answer[:200]!r}")
    if status == 202:
        state = server.wait_until_final(json.loads(answer)["id"])["state"]
        findings.expect(state == "done", f"the model of the cut uploads is {state}")
    return n_cut


def main():
    given = support.arguments(__doc__, times=40)
    findings = support.Findings("cut_transfers", given)
    harness = support.load_harness(given.anyrate)
    with support.temporary_folder() as name:
        root = support.Path(name)
        capture, archive = support.make_capture(given.anyrate, root, views=8, width=96, height=72)
        server = harness.Server(root / "data")
        status, _, answer = server.request("POST", "/v1/models?vertices=4000&coarse=400", archive.read_bytes(),
                                           {"Content-Type": "application/zip"})
        model = json.loads(answer)["id"]
        # The first streams follow the model while it is made.
        n_live = 0
        while server.model(model)["state"] in ("queued", "running"):
            got, twice = cut_stream(harness, server, model, given.random)
            n_live += 1
            findings.expect(not twice, "a frame came twice, or none came")
            findings.expect(server.live(model).read_bytes().startswith(got), "a stream is not the log")
        findings.expect(server.model(model)["state"] == "done", "the model was not made")
        log, live = server.sealed(model).read_bytes(), server.live(model).read_bytes()
        for i in range(given.times):
            if i % 2:
                got, n_came = cut_download(server, model, log, given.random)
                findings.expect(got == log, "a cut download gave other bytes")
                findings.expect(n_came == len(log), "bytes came twice")
            else:
                got, twice = cut_stream(harness, server, model, given.random)
                findings.expect(got == live, f"a cut stream gave other bytes: {len(got)} of {len(live)}")
                findings.expect(not twice, "a frame came twice, or none came")
        n_uploads = cut_uploads(server, capture, given.random, given.times // 3, findings)
        findings.expect(server.stop() == 0, "the server did not end well")
        findings.finish(transfers=given.times, while_it_was_made=n_live, cut_uploads=n_uploads, log_bytes=len(log))


main()
