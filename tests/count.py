"""Sums up CTest's JUnit reports: how many test cases passed, failed and were skipped.

usage: count.py REPORT.xml...      prints "PASSED FAILED SKIPPED"

A doctest binary counts its test cases, a unittest script its test methods, Vitest its tests, any other test one. A test that ends
badly without naming a failed case (a crash, a sanitizer, a time limit, a binary that was never built) counts one failure.
"""
import re
import sys
import xml.etree.ElementTree as ElementTree

DOCTEST = re.compile(r"\[doctest\] test cases: *(\d+) *\| *(\d+) passed *\| *(\d+) failed")
UNITTEST = re.compile(r"^Ran (\d+) tests? in .*\n\n(?:OK|FAILED)(?: \((.*)\))?$", re.M)
VITEST = re.compile(r"^ *Tests  ((?:\d+ [a-z ]+(?: \| )?)+) \(\d+\)$", re.M)


def cases_named_by(output):
    """(passed, failed, skipped) as the output itself tells, or None."""
    passed = failed = skipped = 0
    told = False
    for match in DOCTEST.finditer(output):
        told = True
        passed += int(match[2])
        failed += int(match[3])
    for match in UNITTEST.finditer(output):
        told = True
        odd = {name: int(n) for name, n in re.findall(r"(\w+)=(\d+)", match[2] or "")}
        bad = odd.get("failures", 0) + odd.get("errors", 0)
        failed += bad
        skipped += odd.get("skipped", 0)
        passed += int(match[1]) - bad - odd.get("skipped", 0)
    for match in VITEST.finditer(output):
        told = True
        ends = {end: int(n) for n, end in re.findall(r"(\d+) ([a-z ]*[a-z])", match[1])}
        passed += ends.pop("passed", 0)
        failed += ends.pop("failed", 0)
        skipped += sum(ends.values())
    return (passed, failed, skipped) if told else None


def count(case):
    """(passed, failed, skipped) of one <testcase> element."""
    skipped = case.find("skipped")
    if case.get("status") == "disabled":
        return 0, 0, 1
    if skipped is not None:
        # CTest calls a test whose program is missing skipped as well; only a test that asked to be skipped is.
        asked = "SKIP_RETURN_CODE" in (skipped.get("message") or "")
        return (0, 0, 1) if asked else (0, 1, 0)
    named = cases_named_by(case.findtext("system-out") or "")
    if case.get("status") == "run":
        return named or (1, 0, 0)
    passed, failed, skipped = named or (0, 0, 0)
    return passed, max(failed, 1), skipped


def main(reports):
    total = (0, 0, 0)
    for report in reports:
        for case in ElementTree.parse(report).getroot().iter("testcase"):
            total = tuple(a + b for a, b in zip(total, count(case)))
    print(*total)


if __name__ == "__main__":
    main(sys.argv[1:])
