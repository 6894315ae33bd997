#!/usr/bin/python3
"""What tools/fit_score says of trials whose answer is known: SOURCES. Skipped (77) without NumPy or
matplotlib."""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCES = Path(sys.argv[1])
try:
    import matplotlib  # noqa: F401, pylint: disable=unused-import
    import numpy  # noqa: F401, pylint: disable=unused-import
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)


def record(name, k):
    """What holds does so by its margin; epsilon says the contrary, and the volume nothing."""
    held = k >= 5
    points = [[0.01 * (k + 1), 0.0, 0.0], [-0.01 * (k + 1), 0.0, 0.0]]
    return {"reject": None,
            "quality": {"weight": {"margin": 1.0 + k}, "epsilon": 0.2 - 0.01 * k,
                        "volume": 0.5 if k % 2 else None},  # not known
            "contacts": [{"point_m": point} for point in points],
            "hand": {"name": "hand"}, "object": {"name": name, "radius_m": 0.1},
            "squeeze": {"reason": None, "mass_kg": 0.1, "weights_held": 1.0 + k},
            "trials": [{"protocol": "six", "held": held}]}


with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "grasps.jsonl"
    file.write_text("".join(json.dumps(record(f"object{n}", k)) + "\n"
                            for n in range(8) for k in range(10)))
    ended = subprocess.run([SOURCES / "tools" / "fit_score", file, "--chart", Path(folder) / "chart"],
                           check=False, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    for words in ("by epsilon  first   0.0 %", "by score    first 100.0 %",
                  "epsilon                      is larger of what held than of what did not in 0.0 %",
                  "volume                       is larger of what held than of what did not in 50.0 %",
                  "weights held by the squeeze  is larger of what held than of what did not in 100.0 %"):
        assert words in ended.stdout, ended.stdout
    assert (Path(folder) / "chart" / "held.png").stat().st_size > 5000
    # Rows of a table: what holds does so by epsilon, and the mass that it can hold says nothing.
    rows = Path(folder) / "rows.json"
    rows.write_text(json.dumps({"state": [{
        "hand": "hand", "object": f"folder/object{n}", "mass_kg": 0.1, "trials": [{
            "suite": "six", "epsilon": 0.2 - 0.01 * k, "largest_mass_kg": 0.2 if k % 2 else None,
            "ours": {"outcome": "held" if k < 5 else "slipped"}} for k in range(10)] + [{
                "suite": "six", "epsilon": 0.9, "largest_mass_kg": 0.0,
                "ours": {"outcome": "no squeeze"}}]} for n in range(8)]}))
    ended = subprocess.run([SOURCES / "tools" / "fit_score", "--rows", rows],
                           check=False, capture_output=True, text=True)
    for words in "by epsilon  first 100.0 %", "by score    first 100.0 %":
        assert ended.stdout.count(words) == 2, ended.stdout + ended.stderr
    assert "5 pairs, 50 grasps" in ended.stdout or "4 pairs, 40 grasps" in ended.stdout, ended.stdout
    ended = subprocess.run([SOURCES / "tools" / "fit_score", file, "--rows", rows],
                           check=False, capture_output=True, text=True)
    assert ended.returncode == 2 and "files or --rows" in ended.stderr, ended.stderr
    ended = subprocess.run([SOURCES / "tools" / "fit_score", file, "--written"],
                           check=False, capture_output=True, text=True)
    header = (SOURCES / "grasp/quality/hold_score_coefficients.h").read_text()
    for line in ended.stdout.splitlines()[:3]:
        assert f"{line.split()[1]}," in header, ended.stdout + ended.stderr
    file.write_text('{"trials": 1}\n')
    ended = subprocess.run([SOURCES / "tools" / "fit_score", file], check=False, capture_output=True,
                           text=True)
    assert ended.returncode == 1 and "grasps.jsonl:1: no record" in ended.stderr, ended.stderr
    for words in [Path(folder) / "missing"], [folder], ["--rows", Path(folder) / "missing"]:
        ended = subprocess.run([SOURCES / "tools" / "fit_score", *words], check=False,
                               capture_output=True, text=True)
        assert ended.returncode == 2 and "cannot be read" in ended.stderr, ended.stderr
        assert ended.stderr.count("\n") == 1, ended.stderr
    rows.write_text('{"state": [{"hand": ')
    ended = subprocess.run([SOURCES / "tools" / "fit_score", "--rows", rows], check=False,
                           capture_output=True, text=True)
    assert ended.returncode == 2 and ended.stderr.startswith(f"{rows}: not what"), ended.stderr
