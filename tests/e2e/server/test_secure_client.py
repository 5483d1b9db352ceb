"""push and fetch reach servers over TLS, whose certificates they check, and with tokens, also to read."""

import os
import subprocess
import unittest

from harness import ANYRATE, PATIENCE, Server, ServerTest


def make_authority(folder):
    """A certificate authority of one's own. @return its certificate"""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=authority",
                    "-keyout", folder / "ca.key", "-out", folder / "ca.pem"], check=True, capture_output=True)
    return folder / "ca.pem"


def make_certificate(folder, name, names):
    """A server's certificate from that authority. @return the options of `serve` for it"""
    (folder / f"{name}.ext").write_text(f"subjectAltName={names}\n")
    subprocess.run(["openssl", "req", "-newkey", "rsa:2048", "-nodes", "-subj", f"/CN={name}", "-keyout", folder / f"{name}.key",
                    "-out", folder / f"{name}.csr"], check=True, capture_output=True)
    subprocess.run(["openssl", "x509", "-req", "-days", "2", "-in", folder / f"{name}.csr", "-CA", folder / "ca.pem", "-CAkey",
                    folder / "ca.key", "-CAcreateserial", "-extfile", folder / f"{name}.ext", "-out", folder / f"{name}.pem"],
                   check=True, capture_output=True)
    return ["--tls-certificate", folder / f"{name}.pem", "--tls-key", folder / f"{name}.key"]


def run(*arguments, token=None):
    """Runs the binary with a token in its environment, or with none."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("ANYRATE_")}
    if token:
        environment["ANYRATE_TOKEN"] = token
    return subprocess.run([ANYRATE, *map(str, arguments)], capture_output=True, text=True, timeout=PATIENCE, env=environment)


class Access(ServerTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.ca = make_authority(cls.shared)
        cls.tls = make_certificate(cls.shared, "right", "DNS:localhost,IP:127.0.0.1")
        cls.other_tls = make_certificate(cls.shared, "wrong", "DNS:example.org")

    def setUp(self):
        super().setUp()
        self.server.stop()

    def serve(self, *options):
        self.server = Server(self.folder / "data", *options)
        return self.server.url

    def push(self, url, *options, token=None):
        return run("push", self.capture, "--server", url, "--wait", "--vertices", 1000, *options, token=token)

    def fetch(self, url, model_id, *options, token=None):
        return run("fetch", f"{url}/v1/models/{model_id}", "-o", self.folder / "fetched.arl", *options, token=token)

    def test_push_and_fetch_speak_https(self):
        url = self.serve(*self.tls)
        self.assertTrue(url.startswith("https://127.0.0.1:"))
        for server in (url, url.replace("127.0.0.1", "localhost")):
            done = self.push(server, "--ca", self.ca)
            self.assertEqual(done.returncode, 0, done.stderr)
            model_id = done.stdout.strip()
            for options in ([], ["--vertices", 800], ["--live"], ["--throttle", 1_000_000, "--latency", 5]):
                self.assertEqual(self.fetch(server, model_id, "--ca", self.ca, *options).returncode, 0)
            self.fetch(server, model_id, "--ca", self.ca)
            self.assertEqual((self.folder / "fetched.arl").read_bytes(), self.server.sealed(model_id).read_bytes())

    def test_a_server_that_cannot_show_who_it_is_gets_nothing(self):
        url = self.serve(*self.tls)
        for command in (self.push(url, token="secret"), self.fetch(url, "a" * 26), self.fetch(url, "a" * 26, "--live")):
            self.assertEqual(command.returncode, 1)
            self.assertIn("is not to be trusted", command.stderr)
            self.assertIn("--ca", command.stderr)
        self.server.stop()
        url = self.serve(*self.other_tls)
        done = self.push(url.replace("127.0.0.1", "localhost"), "--ca", self.ca)
        self.assertEqual(done.returncode, 1)
        self.assertIn("is not to be trusted: hostname mismatch", done.stderr.lower())
        self.assertEqual(self.push(url, "--ca", self.folder / "none.pem").returncode, 3)

    def test_https_to_a_server_without_it_fails_with_a_sentence(self):
        url = self.serve()
        done = self.fetch(url.replace("http:", "https:"), "a" * 26, "--ca", self.ca)
        self.assertEqual(done.returncode, 1)
        self.assertIn("TLS", done.stderr)

    def test_a_private_server_is_read_with_a_token_of_read_scope_and_written_with_one_of_write_scope(self):
        write, read = (run("token", scope, "--data", self.folder / "data", "--scope", scope).stdout.strip()
                       for scope in ("write", "read"))
        self.server = Server(self.folder / "data", "--private", headers={"Authorization": f"Bearer {read}"})
        url = self.server.url
        self.assertEqual(self.push(url).returncode, 3)
        self.assertEqual(self.push(url, token=read).returncode, 3)
        done = self.push(url, token=write)
        self.assertEqual(done.returncode, 0, done.stderr)
        model_id = done.stdout.strip()
        refused = self.fetch(url, model_id)
        self.assertEqual(refused.returncode, 3)
        self.assertIn("token", refused.stderr)
        self.assertEqual(self.fetch(url, model_id, "--live").returncode, 3)
        (self.folder / "token").write_text(f"{read}\n")
        for options in ([], ["--vertices", 800], ["--live"]):
            self.assertEqual(self.fetch(url, model_id, *options, token=read).returncode, 0)
            self.assertEqual(self.fetch(url, model_id, *options, "--token-file", self.folder / "token").returncode, 0)
        self.assertEqual(self.fetch(url, model_id, "--token-file", self.folder / "token", token="wrong").returncode, 0)
        (self.folder / "token").write_text("\n")
        self.assertEqual(self.fetch(url, model_id, "--token-file", self.folder / "token").returncode, 3)


if __name__ == "__main__":
    unittest.main()
