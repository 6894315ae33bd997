#!/usr/bin/env python3
"""The tables of docs/headers.md name the public headers, all of them and no others, and the numbers
that stand there are right.

    public_headers_test.py ROOT
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
PAGE = (ROOT / "docs/headers.md").read_text()
TABLES = re.findall(r"^\| `([^`]+\.h)` \| (.*) \|$", PAGE, re.MULTILINE)
PARTS = re.findall(r"^- `([^`]+\.h)`: ", PAGE, re.MULTILINE)


def public_headers():
    """As the libraries list them."""
    for folder in ("bullet_ccd", "bullet_ccd/bullet", "bullet_ccd/ompl", "grasp"):
        text = (ROOT / folder / "CMakeLists.txt").read_text()
        for block in re.findall(r"\bHEADERS\b(.*?)\bSOURCES\b", text, re.DOTALL):
            for name in re.findall(r"\S+\.h\b", block):
                yield str((ROOT / folder / name).resolve().relative_to(ROOT.resolve()))


listed, public = [name for name, _ in TABLES] + PARTS, list(public_headers())
wrong = [f"not in docs/headers.md: {name}" for name in public if name not in listed]
wrong += [f"not public, or listed twice: {name}" for name in listed
          if name not in public or listed.count(name) > 1]
umbrellas = sum("umbrella" in what for _, what in TABLES)
said = [int(number) for number in re.findall(r"^grep .*# (\d+)$", PAGE, re.MULTILINE)]
counted = [umbrellas, len(TABLES) - umbrellas, len(PARTS)]
if said != counted:
    wrong.append(f"the page says {said}, its tables have {counted}")
print("\n".join(wrong))
sys.exit(1 if wrong or not public else 0)
