"""Decompression bombs and mutated captures: each is refused with a sentence of its own, or is harmless; no worker dies
of one, and the server's memory stays flat.

Most are refused before a job begins, by a process that looks through them; what only decoding tells fails its job.

Bombs: zips that unpack to gigabytes, hold too many files or lie about sizes; images that claim or unpack to more pixels
than a capture may have. Mutants: images inside a capture and whole zips, by zzuf. Times are from the upload to the
refusal, as a clock tells them and as processors do. Both are those of a machine that does other things too: on one that does
nothing else, --times 50 --bombs 50 gives them for the bombs alone. A fault is a refusal that takes several times the processor
time of most mutants, which hide nothing: something was unpacked.
"""
import io
import json
import shutil
import statistics
import struct
import subprocess
import sys
import time
import zipfile
import zlib

import support

MOST_TIMES_A_MUTANT = 16  # a second, on a machine that does nothing else


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, rows=b"", extra=b""):
    """A PNG that claims a size; what it holds is another matter."""
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) + extra +
            chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def jpeg(width, height):
    return (b"\xff\xd8\xff\xc0\x00\x11\x08" + struct.pack(">HH", height, width) + b"\x03\x01\x22\x00\x02\x11\x01\x03\x11\x01" +
            b"\xff\xda\x00\x0c\x03\x01\x00\x02\x11\x03\x11\x00\x3f\x00" + b"\x00" * 64 + b"\xff\xd9")


def packed(files, method=zipfile.ZIP_DEFLATED):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return out.getvalue()


def with_image(files, data):
    """The capture with another first image."""
    image = next(name for name in files if name.startswith("images/"))
    return packed({**files, image: data}, zipfile.ZIP_STORED)


def bombs(files, random, n):
    """n bombs of all kinds, as (kind, zip)."""
    zeros = bytes(1 << 20)

    def big_zip(n_megabytes):
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in files.items():
                archive.writestr(name, data)
            with archive.open("images/bomb.png", "w", force_zip64=True) as member:
                for _ in range(n_megabytes):
                    member.write(zeros)
        return out.getvalue()

    def lying_zip():
        """Sizes in the central directory that are not those of the data."""
        bytes_ = bytearray(packed(files))
        at = bytes_.find(b"PK\x01\x02")
        struct.pack_into("<I", bytes_, at + 24, random.choice([0, 1, 0x7FFFFFFF, 0xFFFFFFFE]))
        struct.pack_into("<I", bytes_, at + 20, random.choice([0, 5, 0x7FFFFFFF]))
        return bytes(bytes_)

    kinds = [
        ("zip of gigabytes", lambda: big_zip(random.randint(200, 1500))),
        ("zip of many files", lambda: packed({f"images/{i}": b"" for i in range(20_001 + random.randrange(2000))})),
        ("lying zip", lying_zip),
        ("PNG of gigapixels", lambda: with_image(files, png(random.randint(8000, 65535), random.randint(8000, 65535)))),
        ("JPEG of gigapixels", lambda: with_image(files, jpeg(random.randint(20000, 65535), random.randint(20000, 65535)))),
        ("PNG whose rows never end", lambda: with_image(files, png(160, 120, zeros * random.randint(50, 200)))),
        ("PNG with a text of gigabytes", lambda: with_image(files, png(
            160, 120, bytes(120 * 481), chunk(b"zTXt", b"a\0\0" + zlib.compress(zeros * random.randint(50, 200), 9))))),
        ("PNG with a profile of gigabytes", lambda: with_image(files, png(
            160, 120, bytes(120 * 481), chunk(b"iCCP", b"a\0\0" + zlib.compress(zeros * random.randint(50, 200), 9))))),
        ("cameras.json of arrays", lambda: packed({**files, "cameras.json": b"[" * random.randint(10**6, 10**7)})),
        ("cameras.json of zeros", lambda: packed({**files, "cameras.json": b"0" * random.randint(9 << 20, 90 << 20)})),
    ]
    return [(kinds[i % len(kinds)][0], kinds[i % len(kinds)][1]()) for i in range(n)]


def mutant(files, random, seed, folder):
    """A capture of which zzuf has changed an image, the cameras or the zip's own bytes."""
    ratio = str(random.choice([0.0005, 0.002, 0.01, 0.05]))

    def mutated(data):
        source = folder / "source"
        source.write_bytes(data)
        return subprocess.run(["zzuf", "-q", "-s", str(seed), "-r", ratio, "cat", str(source)], capture_output=True,
                              check=True).stdout
    if random.random() < 0.3:
        bytes_ = mutated(packed(files))
        return bytes_ if bytes_.startswith(b"PK\x03\x04") else b"PK\x03\x04" + bytes_[4:]
    name = random.choice(list(files))
    return packed({**files, name: mutated(files[name])}, zipfile.ZIP_STORED)


def main():
    n_bombs = None
    if "--bombs" in sys.argv:  # else a hundredth of all, 10 at least
        at = sys.argv.index("--bombs")
        n_bombs = int(sys.argv[at + 1])
        del sys.argv[at:at + 2]
    given = support.arguments(__doc__, times=60)
    n_bombs = max(10, given.times // 100) if n_bombs is None else n_bombs
    findings = support.Findings("hostile_captures", given)
    if not shutil.which("zzuf"):
        print("zzuf is missing", file=sys.stderr)
        sys.exit(77)
    harness = support.load_harness(given.anyrate)
    with support.temporary_folder() as name:
        root = support.Path(name)
        # So few and small views that a mutant which is harmless costs little too.
        capture, _ = support.make_capture(given.anyrate, root, views=3, width=48, height=36)
        files = {str(f.relative_to(capture)): f.read_bytes() for f in sorted(capture.rglob("*"))
                 if f.suffix in (".png", ".json")}
        server = harness.Server(root / "data", "--workers", "2")
        times, n_harmless, sentences = [], 0, set()  # times: of clock and processor, and of what
        n_at_once = 0

        def judge(kind, body, must_be_refused):
            nonlocal n_harmless, n_at_once
            begun, used = time.monotonic(), support.processor_seconds(server.process.pid)

            def refused(sentence):
                took = support.processor_seconds(server.process.pid) - used
                times.append((time.monotonic() - begun, took, kind))
                sentences.add(sentence.split(":")[-1][:40])
                findings.expect(len(sentence) > 10 and "ended the process" not in sentence, f"{kind}: {sentence or 'no sentence'}")
            status, _, answer = server.request("POST", "/v1/models?vertices=150&coarse=100", body,
                                               {"Content-Type": "application/zip"})
            if status != 202:
                findings.expect(400 <= status < 500, f"{kind}: answered with {status}")
                refused(json.loads(answer)["detail"])
                n_at_once += 1
                return
            model = json.loads(answer)["id"]
            state = server.model(model)
            while state["state"] in ("queued", "running"):
                time.sleep(0.01)
                state = server.model(model)
            if state["state"] == "failed":
                error = state.get("error", "")
                refused(error)
                findings.expect(error and "worker process ended" not in error, f"{kind}: {error or 'no sentence'}")
                findings.expect(state["attempts"] == 1, f"{kind}: took {state['attempts']} attempts")
            else:
                n_harmless += 1
                findings.expect(state["state"] == "done" and not must_be_refused, f"{kind}: is {state['state']}")
            server.request("DELETE", f"/v1/models/{model}")

        judge("warm-up", packed(files), False)
        memory_before = support.rss_bytes(server.process.pid)
        memory_most = memory_before
        for kind, body in bombs(files, given.random, n_bombs):
            judge(kind, body, kind not in ("PNG with a text of gigabytes", "PNG with a profile of gigabytes",
                                           "PNG whose rows never end", "lying zip"))
            memory_most = max(memory_most, support.rss_bytes(server.process.pid))
        bomb_times, times = times, []
        n_mutants = 0
        for i in support.rounds(given.times - n_bombs):
            n_mutants += 1
            judge("mutant", mutant(files, given.random, given.seed * 100_000 + i, root), False)
            memory_most = max(memory_most, support.rss_bytes(server.process.pid))
        usual = statistics.median(used for _, used, _ in times)
        for _, used, kind in bomb_times + times:
            findings.expect(used <= MOST_TIMES_A_MUTANT * usual,
                            f"{kind}: refused after {used:.2f} s of processor time, most mutants after {usual:.2f}")
        memory_after = support.rss_bytes(server.process.pid)
        findings.expect(memory_after - memory_before < 48 << 20, f"memory grew by {(memory_after - memory_before) >> 20} MB")
        findings.expect(server.request("GET", "/healthz")[0] == 200, "the server is not well afterwards")
        findings.expect(server.stop() == 0, "the server did not end well")

        def seconds(refusals, which):
            ordered = sorted(refusal[which] for refusal in refusals) or [0]
            return {"median": round(ordered[len(ordered) // 2], 3), "p99": round(ordered[int(0.99 * (len(ordered) - 1))], 3),
                    "most": round(ordered[-1], 3), "over_1": sum(value > 1 for value in ordered)}
        slowest = [{"kind": kind, "seconds": round(clock, 2)} for clock, _, kind in sorted(bomb_times, reverse=True)[:5]]
        findings.finish(slowest_bombs=slowest, bombs=n_bombs, mutants=n_mutants, harmless=n_harmless, refused_at_once=n_at_once,
                        kinds_of_sentences=len(sentences), seconds_to_refuse_bombs=seconds(bomb_times, 0),
                        seconds_to_refuse_mutants=seconds(times, 0), processor_seconds_bombs=seconds(bomb_times, 1),
                        processor_seconds_mutants=seconds(times, 1),
                        memory_before_mb=memory_before >> 20, memory_most_mb=memory_most >> 20,
                        memory_after_mb=memory_after >> 20)


main()
