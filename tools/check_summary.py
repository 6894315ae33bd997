#!/usr/bin/env python3
"""What tools/check says at its end.

Prints the slowest compilations and tests, the names of the tests that failed, and "N passed,
N failed, N skipped". Compilations are those of .ninja_log since START. Tests are those that ctest
ran (tests.xml); a GoogleTest program counts as many as its report in test_reports/ holds. The exit
code is 0 if no test failed, and 1 otherwise.
"""
import argparse
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

SHOWN = 10


def compilations(log, start):
    """Seconds and names of the objects compiled since then, of the last run of each."""
    seconds = {}
    for line in log.read_text().splitlines():
        fields = line.split("\t")
        if len(fields) == 5 and fields[3].endswith((".o", ".gch")) and int(fields[2]) >= start * 1e9:
            seconds[fields[3]] = (int(fields[1]) - int(fields[0])) / 1000
    return [(value, key) for key, value in seconds.items()]


def outcome(case):
    """Of a test case of ctest or of GoogleTest, which both follow the format of JUnit."""
    if case.find("failure") is not None or case.get("status") == "fail":
        return "failed"
    skipped = case.find("skipped") is not None or case.get("result") == "skipped"
    return "skipped" if skipped or case.get("status") in ("notrun", "disabled") else "passed"


def cases_of(test, reports):
    """(seconds, name, outcome) of every test case behind one test of ctest."""
    own = (float(test.get("time")), test.get("name"), outcome(test))
    report = reports / (test.get("name") + ".xml")
    if not report.exists():
        return [own]
    cases = [(float(case.get("time")), f"{case.get('classname')}.{case.get('name')}", outcome(case))
             for case in xml.parse(report).iter("testcase")]
    # It may fail as a whole, for instance at its exit.
    if own[2] == "failed" and all(result != "failed" for _, _, result in cases):
        cases.append(own)
    return cases


def print_slowest(title, entries):
    if entries:
        print(f"== slowest {title}")
        for seconds, name in sorted(entries, reverse=True)[:SHOWN]:
            print(f"{seconds:8.1f} s  {name}")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="BUILD_FOLDER", type=Path, help="such as build/check")
    parser.add_argument("start", metavar="START", type=int, help="seconds since 1970")
    arguments = parser.parse_args()
    folder = arguments.folder
    print_slowest("compilations", compilations(folder / ".ninja_log", arguments.start))
    try:
        tests = list(xml.parse(folder / "tests.xml").iter("testcase"))
    except (OSError, xml.ParseError) as error:
        print(f"error: the test runner wrote no report: {error}\n0 passed, 1 failed, 0 skipped")
        return 1
    cases = [case for test in tests for case in cases_of(test, folder / "test_reports")]
    print_slowest("tests", [case[:2] for case in cases])
    failed = [name for _, name, result in cases if result == "failed"]
    if failed:
        print("== failed")
        print("\n".join("  " + name for name in failed))
    count = {result: sum(case[2] == result for case in cases)
             for result in ("passed", "failed", "skipped")}
    print(", ".join(f"{number} {result}" for result, number in count.items()))
    return 1 if failed or not cases else 0


if __name__ == "__main__":
    sys.exit(main())
