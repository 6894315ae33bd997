#!/usr/bin/env python3
"""The page of tools/stability in a browser without a window: every case and method is there,
filters work, a cell says what is behind it, a row opens, sums follow, and no error is raised; and
the sums and failures that the command reports are right.

Exit code 77 (skipped) where Chromium is missing, after the parts that need none.
"""
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True  # no __pycache__ in the sources
from page_checks import expect, failures  # noqa: E402
import stability_matrix  # noqa: E402
import stability_page  # noqa: E402


def answer(method, verdict, **more):
    return {"method": method, "verdict": verdict, "seconds": 0.002, "pairs": 0, **more}


def case(kind, name, time, answers):
    return {"kind": kind, "id": name, "group": name[0], "groupTitle": f"Group <{name[0]}>",
            "title": f"a case & {name}", "time": time, "clearance": 0.25, "closingSpeed": 2.0,
            "tolerance": 1e-6, "rounding": 1e-15, "answers": answers}


def method(kind, name, owner, lost):
    relations = {"moved": {"asked": 4, "kept": 4 - len(lost), "largestShift": 0.01, "lost": lost}}
    return {"kind": kind, "name": name, "owner": owner, "setting": f"setting of {name}",
            "relations": relations}


def fixture(own_verdict="pass"):
    """Four rigid cases and a chain; ours, a peer that is late, one that cannot be asked."""
    def rigid(name, time, own, peer, cast):
        return case("rigid", name, time,
                    [answer("best-first", own, time=time, error=-1e-7, pairs=123456),
                     answer("FCL sampling x97", peer, time=0.6, error=0.1),
                     answer("Bullet continuous", cast, note="not convex")])
    cases = [rigid("A01", 0.5, "pass", "late", "pass"),
             rigid("A02", 0.5, own_verdict, "missed", "not applicable"),
             rigid("D03", None, "pass", "false contact", "crashed"),
             rigid("N01", 0.25, "pass", "pass", "timed out"),
             case("articulated", "G01", 1.0 / 3.0,
                  [answer("best-first", "pass", time=0.33, error=0.0, pairs=77)])]
    lost = [{"id": "A01", "variant": "frame 2", "verdict": "late"}]
    return {"family": "catalogue", "title": "Times & cases", "compiler": "compiler",
            "flags": "-O3", "limit": 10.0, "peers": ["FCL", ""], "defaultIterations": 1000,
            "relations": ["moved"], "commit": "0", "cases": cases,
            "methods": [method("rigid", "best-first", "ours", []),
                        method("rigid", "FCL sampling x97", "fcl", lost),
                        method("rigid", "Bullet continuous", "bullet", []),
                        method("articulated", "best-first", "ours", [])],
            "elsewhere": [{"id": "H01", "groupTitle": "Deformable", "title": "vertex",
                           "tested": "comes with deformable bodies"}]}


def check_sums(measured):
    sums = stability_matrix.sums_of(measured, "rigid", "Bullet continuous")
    expect({v: n for v, n in sums.items() if n} ==
           {"pass": 1, "not applicable": 1, "crashed": 1, "timed out": 1}, f"sums: {sums}")
    expect(stability_matrix.failures_of_ours(measured) == [], "nothing of ours fails")
    failed = stability_matrix.failures_of_ours(fixture("late"))
    expect(failed == [("A02", "best-first", "late")], f"a failure of ours: {failed}")


def check_picture(measured):
    picture, width, height = stability_matrix.draw(measured)
    letters = re.findall(r">([✓ELMFGCT])</text>", picture)
    # A cell each, but for the one that cannot be asked; eight in the legend.
    expect(len(letters) == 12 + 8, f"{len(letters)} letters in the picture")
    expect(width > 0 and height > 0 and "A02" in picture, "the picture has a size and ids")


# What a user does, then what the page shows; the document carries it out.
ACTIONS = """<script>
const seen = {};
const shown = selector => [...document.querySelectorAll(selector)]
    .filter(element => !element.closest(".off")).length;
const sums = () => [...document.querySelectorAll(".sum")].map(cell => cell.textContent).join(" ");
const choose = (selector, value) => {
    const input = document.querySelector(selector);
    input.value = value;
    input.dispatchEvent(new Event("input"));
};
seen.rows = shown(".matrix tbody tr");
seen.cells = shown(".answer");
seen.sums = sums();
const cell = document.querySelector(".answer[data-method='FCL sampling x97']");
cell.dispatchEvent(new MouseEvent("mouseenter", { clientX: 300, clientY: 300 }));
seen.tip = document.getElementById("tip").textContent;
cell.dispatchEvent(new MouseEvent("mouseleave"));
seen.hidden = document.getElementById("tip").classList.contains("off");
cell.closest("tr").click();
seen.detail = document.querySelector(".detail").textContent;
cell.closest("tr").click();
seen.closed = document.querySelector(".detail") === null;
[...document.querySelectorAll(".chip")].find(c => c.dataset.group === "A").click();
seen.afterGroup = shown(".matrix tbody tr");
seen.sumsAfterGroup = sums();
document.querySelector("[data-all]").click();
choose(".of-method", "FCL sampling x97");
choose(".of-verdict", "late");
seen.late = shown(".matrix tbody tr");
choose(".of-method", "");
choose(".of-verdict", "crashed");
seen.crashed = shown(".matrix tbody tr");
choose(".of-verdict", "");
choose(".find", "N01");
seen.found = shown(".matrix tbody tr");
seen.count = document.querySelector(".count").textContent;
seen.error = document.body.dataset.error ?? "";
document.body.dataset.seen = JSON.stringify(seen);
</script></body>"""


def check_text(measured):
    page = stability_page.make_page(measured, [("grasps", stability_page.missing_section(
        "grasps", "not measured"))])
    outside = re.findall(r'(?:src|href)="(?!#|data:)[^"]*"|url\(|@import|fetch\(', page)
    expect(not outside, f"the page refers to other files: {outside}")
    expect("Not on this page: not measured" in page, "a missing family is said")
    expect("Group &lt;A&gt;" in page and "a case &amp; A01" in page, "names are escaped")
    expect("3 of 4" in page and "frame 2: late" in page, "the relations are counted")
    expect("123,456" in page and "A02 (best-first" in stability_page.make_page(
        fixture("late"), []), "costs and failures of ours are said")
    expect("Built without" not in page, "no method is said to be missing")
    without = {**measured, "methods": [m for m in measured["methods"] if m["owner"] == "ours"],
               "cases": [{**c, "answers": c["answers"][:1]} for c in measured["cases"]]}
    expect("Built without FCL and Bullet" in stability_page.make_page(without, []),
           "missing peers are said")
    return page


def check_page(page, browser, folder):
    file = Path(folder) / "index.html"
    file.write_text(page.replace("</body>", ACTIONS))
    dumped = subprocess.run(
        [browser, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}/user",
         "--virtual-time-budget=4000", "--dump-dom", file.as_uri()],
        capture_output=True, text=True, timeout=120, check=False).stdout
    found = re.search(r'data-seen="([^"]*)"', dumped)
    expect(found is not None, "the scripts of the page ran: " + dumped[-400:])
    if found is None:
        return
    seen = json.loads(found.group(1).replace("&quot;", '"').replace("&amp;", "&"))
    tip, detail = seen.pop("tip"), seen.pop("detail")
    expect("A01, FCL sampling x97: late" in tip and "setting of FCL" in tip and
           "1.00e-1" in tip and "2 ms" in tip, f"beside a cell: {tip}")
    expect("exact time 0.5" in detail and "123,456" in detail, f"below a row: {detail}")
    expect(seen == {"rows": 5, "cells": 13, "sums": "4/4 1/4 1/3 1/1", "hidden": True,
                    "closed": True, "afterGroup": 3, "sumsAfterGroup": "2/2 1/2 0/2 1/1",
                    "late": 1, "crashed": 1, "found": 1, "count": "1 of 5 cases",
                    "error": ""}, f"what the page shows: {seen}")


def main():
    measured = fixture()
    check_sums(measured)
    check_picture(measured)
    page = check_text(measured)
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which(
        "google-chrome")
    if browser is not None:
        with tempfile.TemporaryDirectory() as folder:
            check_page(page, browser, folder)
    if failures:
        sys.exit(1)
    if browser is None:
        print("skipped: the page in a browser: Chromium is not installed")
        sys.exit(77)


if __name__ == "__main__":
    main()
