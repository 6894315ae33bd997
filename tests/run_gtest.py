#!/usr/bin/env python3
"""Runs a GoogleTest program and leaves a report of its tests, whatever becomes of the program.

    run_gtest.py REPORT.xml SECONDS PROGRAM [ARGUMENT...]

REPORT.xml is the report of GoogleTest. A program that crashes, ends early or takes longer than SECONDS
leaves none; then this script writes one in which every test that had not passed by then is a failure.
GTEST_TOTAL_SHARDS and GTEST_SHARD_INDEX select a part of the tests, as GoogleTest defines it.

Prints the output of the tests that fail or are skipped. The exit code is 0 if no test fails.
"""
import os
import re
import signal
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml


def run(command, seconds):
    """Exit code (None if the time was up) and output. Ends what the program has started, too."""
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(
            command, stdout=output, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            code = process.wait(seconds)
        except subprocess.TimeoutExpired:
            code = None
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait()
        output.seek(0)
        return code, output.read().decode(errors="replace")


def names_of_shard(command):
    """Names of the tests that the program should have run; GoogleTest lists those of all shards."""
    listing = subprocess.run(
        [*command, "--gtest_list_tests"], stdout=subprocess.PIPE, timeout=60, check=True)
    names = []
    suite = ""
    for line in listing.stdout.decode(errors="replace").splitlines():
        name = line.split("#")[0].rstrip()
        if re.fullmatch(r"\S+\.", name):
            suite = name
        elif suite and re.fullmatch(r"  \S+", name):
            names.append(suite + name.strip())
    runnable = [name for name in names if "DISABLED_" not in name]
    shards = int(os.environ.get("GTEST_TOTAL_SHARDS", "1"))
    return runnable[int(os.environ.get("GTEST_SHARD_INDEX", "0"))::shards]


def ended(output, word):
    """Tests that ended with this word; what a test prints may stand before it in the line."""
    return set(re.findall(r"\[ +%s +\] ([^\s,]+).* \(\d+ ms\)" % word, output))


def write_report(path, names, output, message):
    """The report that the program owes. Its own times are not known."""
    passed = ended(output, "OK")
    skipped = ended(output, "SKIPPED")
    root = xml.Element("testsuites")
    suite = xml.SubElement(root, "testsuite", name="unfinished")
    for name in names:
        classname, _, test = name.partition(".")
        case = xml.SubElement(suite, "testcase", name=test, classname=classname, time="0")
        if name in skipped:
            xml.SubElement(case, "skipped", message="")
        elif name not in passed:
            xml.SubElement(case, "failure", message=message)
    xml.ElementTree(root).write(path)
    return len(names) - len(passed | skipped)


def blocks(output, word):
    """What stands between the start and the end of every test that ended with this word."""
    pattern = r"\[ RUN +\] (\S+)\n(?:(?!\[ RUN ).*\n)*?.*\[ +%s +\] \1.*\n" % word
    return [match.group(0) for match in re.finditer(pattern, output)]


def main():
    report, seconds, *command = sys.argv[1:]
    if os.path.exists(report):
        os.remove(report)
    os.makedirs(os.path.dirname(os.path.abspath(report)), exist_ok=True)
    code, output = run([*command, "--gtest_output=xml:" + report], float(seconds))

    if code in (0, 1) and os.path.exists(report):
        cases = list(xml.parse(report).iter("testcase"))
        print("".join(blocks(output, "SKIPPED")), end="")
        if code:
            print("".join(blocks(output, "FAILED")) or output, end="")
        print(f"{len(cases)} tests")
        if not cases:
            print("none of the tests of the program was run")
        return 0 if code == 0 and cases else 1

    if code is None:
        message = f"stopped after {seconds} s"
    elif code < 0:
        message = f"crashed: {signal.Signals(-code).name}"
    else:
        message = f"ended early with exit code {code}"
    print(output)
    try:
        names = names_of_shard(command)
    except (subprocess.SubprocessError, OSError) as error:
        print(f"{message}; its tests could not be listed: {error}")
        return 1
    failed = write_report(report, names, output, message)
    print(f"{message}; {failed} of {len(names)} tests had not passed by then")
    return 1


if __name__ == "__main__":
    sys.exit(main())
