"""Both ends of the stream replay the same IEEE operations (proto/FORMAT.md, "Arithmetic"): no file of ours may be compiled
with flags that change them. Values alone would not tell, for a wrong last bit rarely survives the rounding to the grid.

Run by CTest; by hand: COMPILE_COMMANDS=build/compile_commands.json python3 tests/compile_flags_test.py
"""
import json
import os
import pathlib
import shlex
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
BANNED = {"-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-fassociative-math", "-freciprocal-math",
          "-ffinite-math-only", "-fno-signed-zeros", "-mfpmath=387", "-mrecip"}


def fault(flags):
    """What is wrong with a file's flags; None if nothing is. The last of several -ffp-contract counts."""
    contract = [flag for flag in flags if flag.startswith("-ffp-contract=")]
    if contract[-1:] != ["-ffp-contract=off"]:
        return "compiled without -ffp-contract=off"
    banned = BANNED.intersection(flags)
    return f"compiled with {', '.join(sorted(banned))}" if banned else None


class CompileFlags(unittest.TestCase):
    def test_every_file_rounds_each_operation_on_its_own(self):
        commands = json.loads(pathlib.Path(os.environ["COMPILE_COMMANDS"]).read_text(encoding="utf-8"))
        checked = set()
        for command in commands:
            file = os.path.relpath(os.path.join(command["directory"], command["file"]), ROOT)
            self.assertIsNone(fault(shlex.split(command["command"])), file)
            checked.add(file)
        self.assertIn("core/progressive/refinable_mesh.cpp", checked)
        self.assertIn("proto/colour_state.cpp", checked)

    def test_wrong_flags_are_told(self):
        self.assertIsNone(fault(["c++", "-O3", "-ffp-contract=off"]))
        self.assertIn("without", fault(["c++", "-O3"]))
        self.assertIn("without", fault(["c++", "-ffp-contract=off", "-ffp-contract=fast"]))
        self.assertIn("-ffast-math", fault(["c++", "-ffp-contract=off", "-ffast-math"]))


if __name__ == "__main__":
    unittest.main()
