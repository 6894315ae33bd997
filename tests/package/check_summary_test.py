#!/usr/bin/env python3
"""run_gtest.py and tools/check_summary.py count every test once, however its program ends.

    check_summary_test.py SOURCE_FOLDER OUTCOMES_PROGRAM
"""
import subprocess
import sys
import tempfile
from pathlib import Path

source, program = map(Path, sys.argv[1:])


def summary(folder, runs):
    """Last line of the summary of these runs: (name, filter, shard, shards)."""
    (folder / ".ninja_log").write_text(
        "# ninja log v5\n0\t4000\t9000000000\told.cpp.o\tx\n0\t2000\t20000000000\tnew.cpp.o\tx\n")
    entries = []
    for name, tests, shard, shards in runs:
        done = subprocess.run(
            [source / "tests/run_gtest.py", folder / "test_reports" / (name + ".xml"), "2", program,
             "--gtest_filter=" + tests],
            env={"GTEST_TOTAL_SHARDS": str(shards), "GTEST_SHARD_INDEX": str(shard)},
            stdout=subprocess.PIPE, check=False)
        status = "fail" if done.returncode else "run"
        entries.append(f'<testcase name="{name}" status="{status}" time="1"/>')
    entries.append('<testcase name="Script.Passes" status="run" time="1"/>')
    (folder / "tests.xml").write_text("<testsuite>" + "".join(entries) + "</testsuite>")
    done = subprocess.run([source / "tools/check_summary.py", folder, "10"],
                          stdout=subprocess.PIPE, check=False, text=True)
    assert "new.cpp.o" in done.stdout and "old.cpp.o" not in done.stdout, done.stdout
    assert (done.returncode == 0) == (" 0 failed" in done.stdout), done.stdout
    return done.stdout.splitlines()[-1]


EXPECTED = {
    "Good.*": "3 passed, 0 failed, 1 skipped",  # one of them is the script
    "Good.*:Bad.Fails": "3 passed, 1 failed, 1 skipped",
    # The tests after the one that ends the program have not passed.
    "Good.*:Bad.Crashes:Later.*": "3 passed, 3 failed, 1 skipped",
    "Good.*:Bad.EndsTheProgram:Later.*": "3 passed, 3 failed, 1 skipped",
    "Good.*:Bad.Hangs:Later.*": "3 passed, 3 failed, 1 skipped",
    "Nothing.*": "1 passed, 1 failed, 0 skipped",
}
def numbers(text):
    return sum(int(word) for word in text.split() if word.isdigit())


for tests, expected in EXPECTED.items():
    with tempfile.TemporaryDirectory() as folder:
        found = summary(Path(folder), [("whole", tests, 0, 1)])
        assert found == expected, f"{tests}: {found}"
for tests, expected in list(EXPECTED.items())[:-1]:
    # Shards take turns, so that a test may be in another shard than the one that crashes before it.
    with tempfile.TemporaryDirectory() as folder:
        found = summary(Path(folder), [("first", tests, 0, 2), ("second", tests, 1, 2)])
        assert numbers(found) == numbers(expected), f"{tests} in two shards: {found}"
