"""The examples of docs/tutorial.md run as they stand, in the folder that the page says."""
import os
import re
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = re.findall(r"```python\n(.*?)```", (ROOT / "docs/tutorial.md").read_text(), flags=re.S)
SHARE = Path(os.environ["BULLET_CCD_SHARE"])


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    if not (SHARE / "objects/can.obj").is_file():
        pytest.skip(f"{SHARE}/objects is not there: build the target objects")
    folder = tmp_path / "build/release/share"
    folder.mkdir(parents=True)
    (folder / "bullet_ccd").symlink_to(SHARE)
    monkeypatch.chdir(tmp_path)


def test_a_world(checkout, capsys):
    exec(EXAMPLES[0], {})
    names, time, distance = capsys.readouterr().out.rsplit(" ", 2)
    # The can stands 0.5 m up at first, and falls by one; it is not as high as that.
    assert names == "('can', 'mug')" and 0.3 < float(time) < 0.5 and 0.3 < float(distance) < 0.5
    assert float(distance) == pytest.approx(float(time), abs=1e-3)


def test_many_motions(capsys):
    names = {}
    exec(EXAMPLES[1], names)
    count, status, later = capsys.readouterr().out.split("\n")[0].split(" ")
    assert later == "True" and 0 < int(count) < 200 and status in ("SEPARATED", "HIT")
    # Dense samples find no contact before the time of a hit, and one then.
    distance = names["ccd"].distance
    for motion, hit, time in zip(names["motions"], names["hit"], names["answers"]["time"]):
        if hit:
            for t in np.linspace(0, 1, 40)[:-1] * time:
                assert distance(names["drone"], names["frame"], motion.at(t)).distance > 0
            assert distance(names["drone"], names["frame"], motion.at(time)).distance < 1.1e-4


def test_a_pybullet_script(capsys):
    sys.path.append(str(ROOT / "benchmarks/reference/bullet"))
    scenes = pytest.importorskip("pybullet_scenes")
    with tempfile.TemporaryDirectory() as folder:
        try:
            sys.modules.setdefault("pybullet", scenes.find(Path(folder)))
        except ImportError as error:
            pytest.skip(str(error))
        line = "ccd = bullet_ccd.pybullet.enable()"
        assert EXAMPLES[2].count(line) == 1
        exec(EXAMPLES[2], {})
        held, impacts, pairs = capsys.readouterr().out.strip().split(" ", 2)
        assert held == "True" and int(impacts) > 0 and pairs in ("[(0, 1)]", "[(1, 0)]")
        # The page says that it falls through without the line.
        stock = {}
        exec(re.sub(r"print\(.*", "", EXAMPLES[2].replace(line, "")), stock)
        assert stock["height"] < -1


def test_a_robot_and_its_trajectories(checkout, capsys):
    exec(EXAMPLES[3], {})
    blocked, free = capsys.readouterr().out.strip().split("\n")
    assert re.fullmatch(r"HIT 1\.\d\d? \[\('(upper|fore)', 0\).*\]", blocked)
    assert re.fullmatch(r"SEPARATED 0\.\d+", free)


def test_every_example_has_a_test():
    assert len(EXAMPLES) == 4
