"""The examples of python/README.md run as they stand."""
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import bullet_ccd as ccd
from shapes import box

README = Path(__file__).resolve().parents[2] / "python" / "README.md"
HAND = (Path(os.environ["BULLET_CCD_SHARE"]) /
        "robots/anthropomorphic_hand/anthropomorphic_hand.urdf")


def test_examples_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    mesh = box(0.03)
    ball = tmp_path / "ball.obj"
    ball.write_text("".join("v %r %r %r\n" % tuple(v) for v in mesh.vertices.tolist()) +
                    "".join("f %d %d %d\n" % tuple(t + 1) for t in mesh.triangles))
    examples = re.findall(r"```python\n(.*?)```", README.read_text(), flags=re.S)
    assert len(examples) == 6
    names = {"HAND": HAND, "BALL": ball}
    printed = []
    for example in examples:
        assert len(example.strip().splitlines()) <= 12
        exec(example, names)
        printed.append(capsys.readouterr().out)
    assert "`" + printed[0].strip() + "`" in README.read_text()
    assert (tmp_path / "grasps.jsonl").exists()


def test_stubs_name_what_there_is():
    stubs = (README.parent / "bullet_ccd" / "_core.pyi").read_text()
    described = set(re.findall(r"^(?:class|def) ([a-zA-Z]\w+)", stubs, flags=re.M))
    there = {name for name in vars(ccd._core) if not name.startswith("_") and
             callable(getattr(ccd._core, name))}
    assert described == there
    for name in there:
        members = {m for m in vars(getattr(ccd._core, name)) if not m.startswith("_")} \
            if isinstance(getattr(ccd._core, name), type) else set()
        body = re.search(rf"^class {name}\b.*?(?=^\S|\Z)", stubs, flags=re.M | re.S)
        for member in members - {"name", "value"}:
            assert body and re.search(rf"\b{member}\b", body[0]), f"{name}.{member}"


def test_a_users_program_passes_mypy(tmp_path):
    pytest.importorskip("mypy")
    package = Path(ccd.__file__).parent
    checked = subprocess.run([sys.executable, "-m", "mypy", "--strict", f"--cache-dir={tmp_path}",
                              Path(__file__).with_name("typed_user.py"), package],
                             env={**os.environ, "MYPYPATH": str(package.parent)}, check=False,
                             capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout
