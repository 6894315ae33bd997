#!/usr/bin/python3
"""What tools/grasp_trials adds up, on rows whose answer is known: SOURCES GRASP_PROGRAM."""
import argparse
import importlib.util
import json
import subprocess
import sys
import tempfile
from importlib.machinery import SourceFileLoader
from pathlib import Path

sys.dont_write_bytecode = True
SOURCES, PROGRAM = map(Path, sys.argv[1:3])
TOOL = SOURCES / "tools" / "grasp_trials"
loader = SourceFileLoader("grasp_trials", str(TOOL))
tool = importlib.util.module_from_spec(importlib.util.spec_from_loader("grasp_trials", loader))
loader.exec_module(tool)

# Spearman: whatever grows together has 1; 1, 2, 3, 4 beside 1, 3, 2, 4 has 1 - 6 * 2 / 60.
assert abs(tool.correlation([1.0, 2.0, 9.0], [0.1, 5.0, 6.0]) - 1.0) < 1e-12
assert abs(tool.correlation([1.0, 2.0, 9.0], [3.0, 2.0, 1.0]) + 1.0) < 1e-12
assert abs(tool.correlation([1, 2, 3, 4], [1, 3, 2, 4]) - 0.8) < 1e-12
assert tool.correlation([1, 1, 1], [1, 2, 3]) == 0.0


def said(*words):
    ended = subprocess.run([TOOL, *map(str, words)], check=False, capture_output=True, text=True)
    return ended.returncode, ended.stdout + ended.stderr


with tempfile.TemporaryDirectory() as folder:
    rows = Path(folder) / "rows.json"

    def trial(ours, theirs, depth=0.0):
        one = {"slip_m": 0.02, "turn_rad": 0.0, "reason": "after 0.3 s", "penetration_m": depth}
        return {"suite": "six", "rank": 1, "epsilon": 0.05, "scored_first": True, "candidate": 7,
                "ours": one | {"outcome": ours}, "mujoco": one | {"outcome": theirs}}

    def summary(*trials):
        rows.write_text(json.dumps({"state": [{"hand": "h", "object": "o/x", "trials": trials}]}))
        return said("summary", rows)

    alike = [trial("held", "held")] * 9
    code, text = summary(*alike, trial("dropped", "held"))
    assert code == 0, text
    assert "10 grasps, held: ours  90.0 %; of 10: MuJoCo 100.0 %, agree  90.0 %, same outcome  90.0 %" in text, text
    assert "differ:    1 x six: ours dropped, MuJoCo held" in text, text
    assert "six           epsilon up to 0.1                    10 grasps" in text, text
    assert "of the best five:    1 x six: lost here, held in MuJoCo" in text, text
    assert "failed:    1 x six: dropped: after N s" in text, text
    assert summary(*alike, *[trial("dropped", "held")] * 2)[0] == 1
    assert summary(*alike, trial("held", "held", 1e-5))[0] == 1
    # Of grasps that MuJoCo was not asked about it says nothing.
    alone = [trial("held", "held") | {"mujoco": None}, trial("dropped", "held") | {"mujoco": None}]
    text = summary(*alike, *alone, trial("dropped", "held"))[1]
    assert "12 grasps, held: ours  83.3 %; of 10: MuJoCo 100.0 %, agree  90.0 %" in text, text
    code, text = summary(*alone)
    assert code == 0 and "2 grasps, held: ours  50.0 %\n" in text and "differ" not in text, text

    # Nor of grasps without a squeeze, which it was not asked about either.
    text = summary(*alike, trial("dropped", "held"), *[trial("no squeeze", "dropped")] * 10)[1]
    assert "20 grasps, held: ours  45.0 %; of 10: MuJoCo 100.0 %, agree  90.0 %" in text, text
    text = summary(trial("dropped", "slipped"), trial("held", "held"))[1]
    assert "agree 100.0 %, same outcome  50.0 %" in text, text
    # What is no table of rows is said in a line.
    rows.write_text('{"state": []}')
    half = Path(folder) / "half.json"
    half.write_text('{"state": [{"hand": ')
    no_trials = Path(folder) / "no_trials.json"
    no_trials.write_text('{"state": [{"hand": "h", "object": "o/x"}]}')
    for file in rows, half, no_trials, Path(folder) / "missing.json", Path(folder):
        code, text = said("summary", file)
        assert code == 2 and text.startswith(f"{file}: ") and text.count("\n") == 1, (code, text)

    # A soak goes on where it ended, and a program that crashes is found.
    ball = Path(folder) / "ball.obj"
    ball.write_text("v 0.02 0 0\nv 0 0.02 0\nv 0 0 0.02\nv -0.02 -0.02 -0.02\n"
                    "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n")
    where = ("--hand", "parallel_gripper", "--object", ball, "-o", Path(folder) / "soak", "-j", 1)
    code, text = said("soak", *where, "--program", PROGRAM, "-n", 1)
    assert code == 0 and "wrong: 0" in text, text
    log = Path(folder) / "soak" / "soak.jsonl"
    before = log.read_text()
    trials = json.loads(before)["trials"]
    assert trials > 0
    # A last line that is half written is dropped; any other one that is no row ends the program.
    log.write_text(before + '{"turn": 1, "ha')
    code, text = said("soak", *where, "--program", PROGRAM, "-n", 0)
    assert code == 0 and "soak.jsonl:2: half written, and dropped" in text, text
    assert log.read_text() == before
    log.write_text('{"turn": 1, "ha\n' + before)
    code, text = said("soak", *where, "--program", PROGRAM, "-n", 0)
    assert code == 2 and "soak.jsonl:1: no row" in text and "Traceback" not in text, text
    log.write_text(before)
    broken = Path(folder) / "broken"
    broken.write_text(f"#!/bin/sh\n[ $1 = plan ] && exec '{PROGRAM}' \"$@\"\nkill -SEGV $$\n")
    broken.chmod(0o755)
    code, text = said("soak", *where, "--program", broken, "-n", trials + 1)
    assert code == 1 and "crashes" in text, text
    assert log.read_text().startswith(before) and log.read_text().count("\n") == 1 + tool.IDLE

    # So is a plan that fails or crashes, and a soak that leads to nothing ends.
    code, text = said("soak", "--hand", "/nowhere.urdf", "--object", ball, "-o", Path(folder) / "none",
                      "--program", PROGRAM, "-n", 3)
    assert code == 1 and "plan fails" in text and "20 turns in a row" in text, text
    assert "0 trials with a squeeze of 20 plans, 20 of which led to no trial" in text, text
    broken.write_text("#!/bin/sh\nkill -SEGV $$\n")
    code, text = said("soak", *where[:-4], "-o", Path(folder) / "crash", "--program", broken, "-n", 1)
    assert code == 1 and "plan crashes" in text, text
    # Trials without a squeeze do not count.
    assert tool.counted({"trials": 8, "outcomes": {"held": 1, "no squeeze": 7}}) == 1

    # What waits has not stalled, however long; what works for too long has.
    tool.STALL = 1
    for name, work, answer in ("waits", "sleep 1.5", 0), ("works", "while :; do :; done", None):
        program = Path(folder) / name
        program.write_text(f"#!/bin/sh\n{work}\n")
        program.chmod(0o755)
        options = argparse.Namespace(verb="soak", output=Path(folder) / "stalls", program=program)
        assert tool.Runner(options).grasp()[0] == answer, name
