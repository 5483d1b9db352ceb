"""docker/ and the binary agree, as far as that can be told without a container engine.

Run by CTest; by hand: python3 tests/docker_test.py build/anyrate
"""
import pathlib
import re
import shutil
import subprocess
import sys
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

    def test_the_image_runs_as_nobody_special_and_tells_its_health(self):
        last_stage = DOCKERFILE.rsplit("FROM ", 1)[1]
        self.assertRegex(last_stage, r"(?m)^USER anyrate$")
        self.assertRegex(last_stage, r"(?m)^HEALTHCHECK ")
        self.assertIn("read_only: true", COMPOSE)
        self.assertIn("no-new-privileges:true", COMPOSE)
        self.assertIn(":/data", COMPOSE)


if __name__ == "__main__":
    unittest.main()
