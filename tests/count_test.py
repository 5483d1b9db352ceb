"""The closing line of tests/run.sh must not lie: what count.py makes of every way a test can end."""
import unittest
import xml.etree.ElementTree as ElementTree

import count


def counted(status, output="", inner=""):
    return count.count(ElementTree.fromstring(f'<testcase status="{status}">{inner}<system-out>{output}</system-out></testcase>'))


DOCTEST = "[doctest] test cases: 7 | 5 passed | 2 failed | 0 skipped\n[doctest] Status: FAILURE!"


class Count(unittest.TestCase):
    def test_a_doctest_binary_counts_its_cases(self):
        self.assertEqual(counted("fail", DOCTEST), (5, 2, 0))
        self.assertEqual(counted("run", "[doctest] test cases: 82 |  82 passed |  0 failed | 0 skipped"), (82, 0, 0))

    def test_a_unittest_script_counts_its_methods(self):
        self.assertEqual(counted("run", "...\n---\nRan 3 tests in 0.1s\n\nOK\n"), (3, 0, 0))
        self.assertEqual(counted("run", "Ran 3 tests in 0.1s\n\nOK (skipped=1)\n"), (2, 0, 1))
        output = "Ran 9 tests in 0.1s\n\nFAILED (failures=1, errors=2, skipped=3)\n"
        self.assertEqual(counted("fail", output), (3, 3, 3))

    def test_vitest_counts_its_tests(self):
        closing = " Test Files  1 failed | 2 passed (3)\n      Tests  {}\n     Errors  1 error\n   Start at  00:02:30\n"
        self.assertEqual(counted("run", closing.format("9 passed (9)")), (9, 0, 0))
        self.assertEqual(counted("run", closing.format("7 passed | 2 skipped (9)")), (7, 0, 2))
        self.assertEqual(counted("fail", closing.format("2 failed | 4 passed | 2 skipped | 1 todo (9)")), (4, 2, 3))
        self.assertEqual(counted("fail", closing.format("9 passed (9)")), (9, 1, 0))
        self.assertEqual(counted("fail", closing.format("no tests")), (0, 1, 0))

    def test_any_other_test_counts_one(self):
        self.assertEqual(counted("run", "fine"), (1, 0, 0))
        self.assertEqual(counted("fail", "not fine"), (0, 1, 0))

    def test_a_crash_after_good_cases_is_a_failure(self):
        self.assertEqual(counted("fail", "[doctest] test cases: 3 | 3 passed | 0 failed | 0 skipped"), (3, 1, 0))

    def test_a_program_that_was_not_built_is_a_failure(self):
        self.assertEqual(counted("notrun", inner='<skipped message="Unable to find executable"/>'), (0, 1, 0))

    def test_a_test_that_asks_to_be_skipped_is_skipped(self):
        self.assertEqual(counted("notrun", inner='<skipped message="SKIP_RETURN_CODE=77"/>'), (0, 0, 1))
        self.assertEqual(counted("disabled", "Disabled"), (0, 0, 1))


if __name__ == "__main__":
    unittest.main()
