"""What the tests of the Python tools share: the tools on the path, and a list of what failed."""
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tools"))

failures = []


def expect(condition, what):
    if not condition:
        failures.append(what)
        print("FAILED:", what)
