"""Ctrl-C ends a reconstruction with exit code 1 and a valid model."""
import json
import signal
import subprocess
import time
import unittest

from support import ANYRATE, N_COARSE, capture, fault_of_manifold, must, read_ply, scratch

MANY = 200_000  # far more vertices than are refined before the signal comes


def start(model, *options):
    arguments = ["reconstruct", capture(), "-o", model, "--coarse", N_COARSE, "--vertices", MANY, *options]
    return subprocess.Popen([ANYRATE, *map(str, arguments)], stderr=subprocess.PIPE, text=True)


def wait_for_refinement(process, model):
    """Until the growing log has its first refine frame."""
    live = model.with_name(model.name + ".part")
    while process.poll() is None:
        if live.exists():
            told = subprocess.run([ANYRATE, "info", live, "--json"], capture_output=True, text=True)
            if told.returncode == 0 and any(f["type"] == "refine" for f in json.loads(told.stdout)["frames"]):
                return
        time.sleep(0.05)
    raise AssertionError("it ended before it was interrupted: " + process.stderr.read())


class Interrupt(unittest.TestCase):
    def assert_leaves_a_valid_model(self, name, sent):
        model = scratch() / f"{name}.arl"
        with start(model) as process:
            wait_for_refinement(process, model)
            process.send_signal(sent)
            _, said = process.communicate(timeout=300)
        self.assertEqual(process.returncode, 1, said)
        self.assertIn("interrupted", said)
        must("verify", model)
        must("decode", model, "-o", scratch() / f"{name}.ply")
        positions, triangles = read_ply(scratch() / f"{name}.ply")
        self.assertGreater(len(positions), N_COARSE)
        self.assertLess(len(positions), MANY - 2)
        self.assertIsNone(fault_of_manifold(len(positions), triangles))
        self.assertEqual(list(scratch().glob(f"{name}.arl.part*")), [])

    def test_an_interrupt_leaves_a_valid_model(self):
        self.assert_leaves_a_valid_model("interrupted", signal.SIGINT)

    def test_a_termination_leaves_a_valid_model(self):
        self.assert_leaves_a_valid_model("terminated", signal.SIGTERM)

    def test_an_interrupt_at_the_first_stage_leaves_no_rubbish(self):
        model = scratch() / "early.arl"
        with start(model) as process:
            process.stderr.readline()
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=300)
        self.assertEqual(process.returncode, 1, said)
        self.assertIn("interrupted", said)
        self.assertEqual(list(scratch().glob("early.arl.part*")), [])
        if model.exists():
            must("verify", model)


if __name__ == "__main__":
    unittest.main()
