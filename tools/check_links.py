#!/usr/bin/env python3
"""Checks that the links between the pages of a source tree lead somewhere.

Prints file:line for every relative link of a Markdown file to a file or a heading that does not exist.
The exit code is 1 if there is one. Links to other sites are not followed.
"""
import argparse
import pathlib
import re
import sys

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
SKIPPED = {"build", "out", ".git", "node_modules"}


def anchors_of(page):
    """The names that GitHub gives to headings."""
    names = set()
    for line in lines_of(page):
        heading = re.match(r"#+ +(.*)", line)
        if heading:
            text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading[1]).lower()
            names.add(re.sub(r"[^\w\- ]", "", text).strip().replace(" ", "-"))
    return names


def lines_of(page):
    """Lines with those of code blocks emptied."""
    inside = False
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.lstrip().startswith("```"):
            inside = not inside
            yield ""
        else:
            yield "" if inside else line


def wrong_links(root):
    for page in sorted(root.rglob("*.md")):
        if SKIPPED & set(page.relative_to(root).parts):
            continue
        for number, line in enumerate(lines_of(page), 1):
            for target in LINK.findall(re.sub(r"`[^`]*`", "", line)):
                if re.match(r"[a-z]+:", target):
                    continue
                path, _, anchor = target.partition("#")
                file = (page.parent / path).resolve() if path else page
                if not file.exists():
                    yield f"{page.relative_to(root)}:{number}: {target}: there is no such file"
                elif anchor and file.suffix == ".md" and anchor not in anchors_of(file):
                    yield f"{page.relative_to(root)}:{number}: {target}: there is no such heading"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", metavar="ROOT", type=pathlib.Path, help="folder of a source tree")
    found = list(wrong_links(parser.parse_args().root.resolve()))
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
