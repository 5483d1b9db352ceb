"""What the command line's tests share: running the binary, one small capture, meshes as the files hold them."""
import atexit
import functools
import os
import pathlib
import shutil
import struct
import subprocess
import tempfile
import zlib

ANYRATE = os.environ.get("ANYRATE") or str(pathlib.Path(__file__).resolve().parents[3] / "build" / "anyrate")

N_COARSE, N_VERTICES = 600, 1500


def anyrate(*arguments, stdin=b""):
    """Runs `anyrate ARGUMENTS` on these input bytes; the result has returncode, stdout and stderr (text)."""
    done = subprocess.run([ANYRATE, *map(str, arguments)], input=stdin, capture_output=True, timeout=600)
    done.stdout, done.stderr = done.stdout.decode(), done.stderr.decode()
    return done


def must(*arguments, stdin=b""):
    """The same, but it has to succeed."""
    done = anyrate(*arguments, stdin=stdin)
    if done.returncode != 0:
        raise AssertionError(f"anyrate {' '.join(map(str, arguments))}: exit {done.returncode}\n{done.stderr}")
    return done


@functools.cache
def scratch():
    """A folder that is gone when the tests are over."""
    folder = tempfile.mkdtemp(prefix="anyrate-e2e-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return pathlib.Path(folder)


@functools.cache
def capture():
    """A small simulated capture of a textured sphere. Do not change it: take copy_of_capture()."""
    folder = scratch() / "capture"
    must("simulate", "--scene", "sphere", "-o", folder, "--views", 12, "--width", 200, "--height", 150)
    return folder


def copy_of_capture(name):
    folder = scratch() / name
    shutil.copytree(capture(), folder)
    return folder


def reconstruct_arguments(source, model):
    return ["reconstruct", source, "-o", model, "--coarse", N_COARSE, "--vertices", N_VERTICES]


@functools.cache
def model():
    """The capture's model, and its report beside it as model.json."""
    file = scratch() / "model.arl"
    must(*reconstruct_arguments(capture(), file), "--report", scratch() / "model.json")
    return file


def read_ply(file):
    """(positions, triangles) of a binary PLY of float positions and normals, uchar colours and triangles."""
    data = pathlib.Path(file).read_bytes()
    header, body = data.split(b"end_header\n", 1)
    lines = header.decode().splitlines()
    assert "format binary_little_endian 1.0" in lines, lines
    n_vertices = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    n_faces = next(int(line.split()[2]) for line in lines if line.startswith("element face"))
    vertex = struct.Struct("<6f" + "B" * sum(line.startswith("property uchar") for line in lines))
    face = struct.Struct("<B3i")
    assert len(body) == vertex.size * n_vertices + face.size * n_faces, "the body has another size than the header says"
    positions = [v[:3] for v in vertex.iter_unpack(body[: vertex.size * n_vertices])]
    triangles = [f[1:] for f in face.iter_unpack(body[vertex.size * n_vertices :])]
    return positions, triangles


def fault_of_manifold(n_vertices, triangles):
    """Why the triangles are no closed, consistently oriented manifold that uses every vertex; None if they are."""
    after = {}  # after[v][a] = b: the face (v, a, b); around a manifold vertex this is one cycle
    for a, b, c in triangles:
        for v, first, second in ((a, b, c), (b, c, a), (c, a, b)):
            ring = after.setdefault(v, {})
            if first in ring:
                return f"two faces run along the edge {v}-{first} the same way"
            ring[first] = second
    if len(after) != n_vertices:
        return f"{n_vertices - len(after)} vertices have no face"
    for v, ring in after.items():
        start = next(iter(ring))
        current, n_walked = ring[start], 1
        while current != start:
            if current not in ring:
                return f"the edge {v}-{current} has one face"
            current = ring[current]
            n_walked += 1
        if n_walked != len(ring):
            return f"the faces of vertex {v} form more than one fan"
    return None


def png(width, height, rows):
    """The bytes of a grey 8-bit PNG; `rows` may be fewer than `height` (a file whose header promises too much)."""

    def chunk(kind, payload):
        return struct.pack(">I", len(payload)) + kind + payload + struct.pack(">I", zlib.crc32(kind + payload))

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")
