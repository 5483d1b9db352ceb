"""Enforces who may include whom: the arrows between the parts, and the few files each third party is kept behind.

Run by CTest; by hand: python3 tests/layering.py
"""
import fnmatch
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent

# A part is a folder; "core" alone is the leaf that everybody may use (core/types.h, error.h, parallel.h).
ARROWS = {
    "core": [],
    "core/capture": ["core"],
    "core/mesh": ["core"],
    "core/simulation": ["core", "core/capture", "core/mesh"],
    "core/progressive": ["core", "core/mesh"],
    "core/encoding": ["core", "core/mesh", "core/progressive"],
    "core/reconstruction": ["core", "core/capture", "core/mesh", "core/progressive"],
    "proto": ["core", "core/mesh", "core/progressive"],
    "gpu": ["core", "core/capture", "core/mesh", "core/progressive", "core/reconstruction"],
    "server": ["core", "core/capture", "core/mesh", "core/simulation", "core/progressive", "core/encoding",
               "core/reconstruction", "proto"],
}

# Heavy third parties: only these files include them (patterns of fnmatch; tests may include anything).
THIRD_PARTIES = {
    r"draco/": ["proto/draco_io.cpp", "proto/draco_glb.cpp"],
    r"png\.h": ["core/capture/png_codec.cpp"],
    r"turbojpeg\.h": ["core/capture/jpeg_codec.cpp"],
    r"opencv2/": [],
    r"OpenMesh/": ["core/mesh/surface.h", "core/mesh/decimate.cpp"],
    r"nlohmann/": ["core/capture/cameras_json.cpp", "core/mesh/glb.cpp", "server/*.cpp", "server/jobs/json_line.h"],
    r"archive(_entry)?\.h": ["core/capture/zip_archive.cpp", "server/store/zip_writer.cpp"],
    r"sqlite3\.h": ["server/store/sqlite.h"],
    r"seccomp\.h": ["server/jobs/sandbox.cpp"],
    r"boost/crc\.hpp": ["core/capture/image_header.cpp"],
    r"boost/(?!crc)": ["server/http/*", "server/client/*.cpp", "server/client/client_stream.h"],
    r"spdlog/": ["server/cli/server_log.cpp"],
    r"(epoxy|EGL|GL)/": ["gpu/*"],
    r"openssl/": ["server/store/sha256.cpp"],
    r"CLI/": ["server/main.cpp", "server/cli/*.cpp"],
}

# Beyond the arrows: the one file through which the program reaches the GPU.
SINGLE_FILES = {"server/cli/backend_choice.cpp": ["gpu"]}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"]+)"|<([^>]+)>)', re.M)


def part_of(path):
    """The part a file belongs to, None for tests and what is no part."""
    folders = path.split("/")[:-1]
    if not folders or folders[0] not in ("core", "gpu", "proto", "server"):
        return None
    return "/".join(folders[:2]) if folders[0] == "core" else folders[0]


def faults(path, text):
    """One sentence per include of the file at `path` (relative to the root, with this text) that breaks a rule."""
    part = part_of(path)
    if part is None:
        return []
    found = []
    for quoted, angled in INCLUDE.findall(text):
        target = part_of(quoted or angled)
        if quoted and target is None:
            found.append(f'{path}: "{quoted}" is not a path from the root into core, gpu, proto or server')
        elif target not in (None, part, *ARROWS[part], *SINGLE_FILES.get(path, [])):
            found.append(f"{path}: {part} must not include {quoted or angled} of {target}")
        for library, files in THIRD_PARTIES.items():
            if angled and re.match(library, angled) and not any(fnmatch.fnmatch(path, file) for file in files):
                found.append(f"{path}: <{angled}> is kept behind {', '.join(files)}")
    return found


def sources():
    for folder in ("core", "gpu", "proto", "server"):
        for pattern in ("*.h", "*.cpp"):
            yield from sorted((ROOT / folder).rglob(pattern))


class Layering(unittest.TestCase):
    def test_every_include_follows_an_arrow(self):
        files = list(sources())
        self.assertGreater(len(files), 20, "the sources were not found")
        found = []
        for file in files:
            found += faults(file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8"))
        self.assertEqual(found, [], "\n" + "\n".join(found))

    def test_every_listed_file_still_includes_its_third_party(self):
        files = [(file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8")) for file in sources()]
        for library, patterns in THIRD_PARTIES.items():
            for pattern in patterns:
                includes = [i for path, text in files if fnmatch.fnmatch(path, pattern) for i in INCLUDE.findall(text)]
                self.assertTrue(any(re.match(library, angled) for _, angled in includes), f"{pattern} needs no {library}")

    def test_an_include_against_the_arrows_is_refused(self):
        self.assertEqual(len(faults("core/mesh/remesh.cpp", '#include "core/capture/camera.h"\n')), 1)
        self.assertEqual(len(faults("core/types.h", '  #  include "core/mesh/mesh.h"\n')), 1)
        self.assertEqual(len(faults("proto/header.cpp", "#include <core/capture/camera.h>\n")), 1)
        self.assertEqual(len(faults("server/http/routes.cpp", '#include "gpu/egl_context.h"\n')), 1)
        self.assertEqual(faults("server/cli/backend_choice.cpp", '#include "gpu/egl_context.h"\n'), [])

    def test_an_include_beside_the_file_is_refused(self):
        self.assertEqual(len(faults("core/mesh/remesh.cpp", '#include "remesh.h"\n')), 1)

    def test_a_third_party_outside_its_files_is_refused(self):
        self.assertEqual(len(faults("core/reconstruction/flow.cpp", "#include <png.h>\n")), 1)

    def test_an_include_along_an_arrow_is_accepted(self):
        self.assertEqual(faults("core/simulation/simulate.cpp", '#include "core/mesh/mesh.h"\n#include <vector>\n'), [])


if __name__ == "__main__":
    unittest.main()
