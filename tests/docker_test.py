"""docker/ and the binary agree, as far as that can be told without a container engine.

Run by CTest; by hand: python3 tests/docker_test.py build/anyrate
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
ANYRATE = pathlib.Path(sys.argv.pop(1)) if len(sys.argv) > 1 else None
INSTALL = (ROOT / "docker/install.sh").read_text()
DOCKERFILE = (ROOT / "docker/Dockerfile").read_text()
COMPOSE = (ROOT / "docker/compose.yaml").read_text()


def packages(name):
    """The words of a list in install.sh."""
    block = re.search(rf"^{name}=\(\n(.*?)^\)", INSTALL, re.M | re.S).group(1)
    return [word for line in block.splitlines() for word in line.split("#")[0].split()]


class Docker(unittest.TestCase):
    def test_the_script_installs_nothing_that_is_there(self):
        for mode in ([], ["run"]):
            done = subprocess.run(["bash", ROOT / "docker/install.sh", *mode], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)

    def test_the_script_refuses_another_word(self):
        self.assertEqual(subprocess.run(["bash", ROOT / "docker/install.sh", "fly"], capture_output=True).returncode, 2)

    @unittest.skipUnless(ANYRATE and shutil.which("readelf") and shutil.which("dpkg"), "needs the binary, readelf, dpkg")
    def test_every_library_of_the_binary_is_in_the_image(self):
        needed = re.findall(r"\(NEEDED\).*\[(.*)\]", subprocess.run(["readelf", "-d", ANYRATE], capture_output=True, text=True,
                                                                    check=True).stdout)
        self.assertIn("libsqlite3.so.0", needed)
        places = dict(re.findall(r"^\t(\S+) .* => (\S+)$", subprocess.run(["/sbin/ldconfig", "-p"], capture_output=True,
                                                                        text=True, check=True).stdout, re.M))
        for library in needed:
            file = pathlib.Path(places[library]).resolve()
            found = subprocess.run(["dpkg", "-S", f"*/{file.name}"], capture_output=True, text=True, check=True).stdout
            owners = {line.split(":")[0] for line in found.splitlines()}
            self.assertTrue(owners & {*packages("run_packages"), "libc6", "libgcc-s1"}, f"{library} is of {owners}")

    def test_both_stages_install_by_the_script(self):
        self.assertEqual(len(re.findall(r"^FROM ", DOCKERFILE, re.M)), 2)
        self.assertEqual(len(re.findall(r"^RUN bash \S*install\.sh", DOCKERFILE, re.M)), 2)
        self.assertNotIn("apt-get install", DOCKERFILE)

    def test_the_viewer_lies_beside_the_program(self):
        places = dict(re.findall(r"^COPY --from=build /anyrate/build/(\S+) (\S+)$", DOCKERFILE, re.M))
        self.assertEqual(pathlib.Path(places["anyrate"]).parent, pathlib.Path(places["viewer"]).parent)
        self.assertRegex(DOCKERFILE, rf"ln -s {places['anyrate']} /usr/local/bin/anyrate")

    def test_egl_is_told_of_a_gpus_driver(self):
        target = re.search(r"^COPY docker/10_nvidia.json (\S+)$", DOCKERFILE, re.M).group(1)
        self.assertEqual(target, "/usr/share/glvnd/egl_vendor.d/10_nvidia.json")
        vendor = json.loads((ROOT / "docker/10_nvidia.json").read_text())
        self.assertEqual(vendor["ICD"]["library_path"], "libEGL_nvidia.so.0")
        self.assertRegex((ROOT / "docker/compose.gpu.yaml").read_text(), r"NVIDIA_DRIVER_CAPABILITIES: graphics,compute")

    def test_every_file_that_is_copied_is_there(self):
        for source in re.findall(r"^COPY (?!--from)(\S+) ", DOCKERFILE, re.M):
            self.assertTrue((ROOT / source).exists(), source)
        self.assertIn("dockerfile: docker/Dockerfile", COMPOSE)

    @unittest.skipUnless(ANYRATE and os.geteuid() == 0 and shutil.which("unshare") and shutil.which("setpriv"),
                         "needs the binary, root, unshare, setpriv")
    def test_the_server_works_with_a_read_only_root_as_nobody_special_without_capabilities(self):
        """What compose.yaml does, with this machine's root in the place of the image's."""
        if subprocess.run(["unshare", "--mount", "mount", "-o", "remount,bind,ro", "/"], capture_output=True).returncode != 0:
            self.skipTest("this machine lets nobody mount its root read-only")
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            folder.chmod(0o755)
            program, data = folder / "anyrate", folder / "data"
            shutil.copy(ANYRATE, program)
            data.mkdir()
            os.chown(data, 10001, 10001)
            inside = ('mount --bind "$2" "$2" && mount -o remount,bind,ro / && ! touch "$2/../written" 2>/dev/null && exec setpriv '
                      '--reuid=10001 --regid=10001 --clear-groups --no-new-privs --bounding-set=-all '
                      '"$1" serve --listen 127.0.0.1:0 --data "$2"')
            server = subprocess.Popen(["unshare", "--mount", "sh", "-c", inside, "sh", program, data], stdout=subprocess.PIPE,
                                      stderr=subprocess.DEVNULL, text=True, env={**os.environ, "ANYRATE_TOKEN": "secret"})
            try:
                url = server.stdout.readline().split()[-1]
                check = json.loads(re.search(r"CMD (\[\"curl.*\])", DOCKERFILE).group(1))
                check[-1] = check[-1].replace("http://127.0.0.1:8080", url)
                self.assertEqual(subprocess.run(check).returncode, 0)
                subprocess.run([ANYRATE, "simulate", "--scene", "vessel", "-o", folder / "capture", "--views", "8", "--width", "96",
                                "--height", "72"], check=True, capture_output=True)
                done = subprocess.run([ANYRATE, "push", folder / "capture", "--server", url, "--wait", "--vertices", "500"],
                                      capture_output=True, text=True, env={**os.environ, "ANYRATE_TOKEN": "secret"})
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertTrue((data / "models" / done.stdout.strip() / "model.arl").exists())
            finally:
                server.terminate()
                self.assertEqual(server.wait(120), 0)
                server.stdout.close()

    def test_the_image_runs_as_nobody_special_and_tells_its_health(self):
        last_stage = DOCKERFILE.rsplit("FROM ", 1)[1]
        self.assertRegex(last_stage, r"(?m)^USER anyrate$")
        self.assertRegex(last_stage, r"(?m)^HEALTHCHECK ")
        self.assertIn("read_only: true", COMPOSE)
        self.assertIn("no-new-privileges:true", COMPOSE)
        self.assertIn(":/data", COMPOSE)


if __name__ == "__main__":
    unittest.main()
