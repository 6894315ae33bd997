"""What the tests of benchmarks/plot share: the package on the path, a browser without a window, and
a list of what failed. Exit code 77 (skipped) where matplotlib is missing."""
import json
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

sys.dont_write_bytecode = True  # no __pycache__ in the sources
sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "benchmarks"))
try:
    import plot.pictures  # noqa: F401
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)

BROWSER = (shutil.which("chromium") or shutil.which("chromium-browser") or
           shutil.which("google-chrome"))
failures = []

# For what a user does, which follows; the document carries it out.
ACTIONS = """
const seen = {};
const shown = selector => [...document.querySelectorAll(selector)]
    .filter(element => !element.closest(".off")).length;
const tipOf = element => {
    element.dispatchEvent(new MouseEvent("mouseenter", { clientX: 300, clientY: 300 }));
    return document.getElementById("tip").textContent;
};
const choose = (selector, value) => {
    const input = document.querySelector(selector);
    input.value = value;
    input.dispatchEvent(new Event("input"));
};
"""


def expect(condition, what):
    if not condition:
        failures.append(what)
        print("FAILED:", what)


def expect_picture(picture, name):
    """Well-formed, every place a number, and no group named twice."""
    try:
        ElementTree.fromstring(picture)
    except ElementTree.ParseError as error:
        expect(False, f"{name} is no XML: {error}")
    expect(not re.search(r'[ "MLVH](nan|inf)\b', picture), f"{name} has no place for a point")
    names = re.findall(r'<g id="([^"]*)"', picture)
    expect(len(names) == len(set(names)), f"{name} has a group twice")


def expect_alone(page):
    outside = re.findall(r'(?:src|href)="(?!#|data:)[^"]*"|url\((?!#)|@import|fetch\(', page)
    expect(not outside, f"the page refers to other files: {outside}")


def see(page, actions):
    """What a user of the page sees, {} without a browser: `seen` after the actions."""
    if BROWSER is None:
        return {}
    script = ("<script>" + ACTIONS + actions + 'seen.error = document.body.dataset.error ?? "";'
              "document.body.dataset.seen = JSON.stringify(seen);</script></body>")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "index.html"
        file.write_text(page.replace("</body>", script))
        dumped = subprocess.run(
            [BROWSER, "--headless", "--no-sandbox", "--disable-gpu",
             f"--user-data-dir={folder}/user", "--virtual-time-budget=4000", "--dump-dom",
             file.as_uri()], capture_output=True, text=True, timeout=120, check=False).stdout
    found = re.search(r'data-seen="([^"]*)"', dumped)
    expect(found is not None, "the scripts of the page ran: " + dumped[-400:])
    return json.loads(found[1].replace("&quot;", '"').replace("&amp;", "&")) if found else {}


def end(needs_browser=True):
    if failures:
        sys.exit(1)
    if needs_browser and BROWSER is None:
        print("skipped: the page in a browser: Chromium is not installed")
        sys.exit(77)
