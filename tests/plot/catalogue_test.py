#!/usr/bin/python3
"""The page of the catalogue in a browser without a window: every case and method is there, filters
work, a cell says what is behind it, a row opens, and no error is raised; and the sums
and failures that the command reports are right.
"""
import re
import tempfile
from pathlib import Path

from checks import end, expect, expect_alone, expect_picture, see
from plot import catalogue, page
from plot.pictures import svg


def answer(method, verdict, **more):
    return {"method": method, "verdict": verdict, "seconds": 0.002, "pairs": 0, **more}


def case(name, time, answers):
    return {"id": name, "title": f"a case & {name}", "time": time, "clearance": 0.25, "closingSpeed": 2.0,
            "tolerance": 1e-6, "rounding": 1e-15, "answers": answers}


def method(name, owner):
    return {"name": name, "owner": owner, "setting": f"setting of {name}"}


def fixture(own_verdict="pass"):
    """Four cases; ours, a peer that is late, one that cannot be asked."""
    def rigid(name, time, own, peer, cast):
        return case(name, time,
                    [answer("best-first", own, time=time, error=-1e-7, pairs=123456),
                     answer("FCL sampling x97", peer, time=0.6, error=0.1),
                     answer("Bullet continuous", cast, note="not convex")])
    cases = [rigid("A01", 0.5, "pass", "late", "pass"),
             rigid("A02", 0.5, own_verdict, "missed", "not applicable"),
             rigid("D03", None, "pass", "false contact", "crashed"),
             rigid("N01", 0.25, "pass", "pass", "timed out")]
    return {"family": "catalogue", "title": "Times & cases", "compiler": "compiler",
            "flags": "-O3", "limit": 10.0, "peers": ["FCL", ""],
            "commit": "0", "cases": cases,
            "methods": [method("best-first", "ours"),
                        method("FCL sampling x97", "fcl"),
                        method("Bullet continuous", "bullet")]}


def check_sums(measured):
    sums = catalogue.sums_of(measured, measured["methods"][2])
    expect({v: n for v, n in sums.items() if n} ==
           {"pass": 1, "not applicable": 1, "crashed": 1, "timed out": 1}, f"sums: {sums}")
    expect(catalogue.failures_of_ours(measured) == [], "nothing of ours fails")
    failed = catalogue.failures_of_ours(fixture("late"))
    expect(failed == [("A02", "best-first", "late")], f"a failure of ours: {failed}")


def check_picture(measured):
    picture = svg(catalogue.draw(measured), "catalogue")
    expect_picture(picture, "the catalogue")
    letters = re.findall(r">([✓ELMFGCT])</text>", picture)
    expect(len(letters) == 11, f"a letter a cell, but for the one that cannot be asked: {letters}")
    expect("A02" in picture, "ids")


def page_of(measured):
    with tempfile.TemporaryDirectory() as folder:
        sections = {"catalogue": catalogue.section_of(measured, Path(folder)),
                    "simulation": page.missing("simulation", "not measured")}
    return page.make_page("Stability", sections)


ACTIONS = """
seen.rows = shown(".matrix tbody tr");
seen.cells = shown(".answer");
const cell = document.querySelector(".answer[data-words^='FCL sampling x97']");
seen.tip = tipOf(cell);
cell.dispatchEvent(new MouseEvent("mouseleave"));
seen.hidden = document.getElementById("tip").classList.contains("off");
cell.closest("tr").click();
seen.detail = document.querySelector(".detail").textContent;
cell.closest("tr").click();
seen.closed = document.querySelector(".detail") === null;
choose(".find", "sampling x97 LATE");
seen.late = shown(".matrix tbody tr");
choose(".find", "crashed");
seen.crashed = shown(".matrix tbody tr");
choose(".find", "N01");
seen.found = shown(".matrix tbody tr");
seen.count = document.querySelector(".count").textContent;
"""


def check_text(measured):
    text = page_of(measured)
    expect_alone(text)
    expect("Not on this page: not measured" in text, "a missing family is said")
    expect("a case &amp; A01" in text, "names are escaped")
    expect('href="#degrades"' in text, "parts of the section are in the head of the page")
    expect("123,456" in text and "A02 (best-first" in page_of(fixture("late")),
           "costs and failures of ours are said")


def check_page(measured):
    seen = see(page_of(measured), ACTIONS)
    if seen:
        tip, detail = seen.pop("tip"), seen.pop("detail")
        expect("A01, FCL sampling x97: late" in tip and "setting of FCL" in tip and
               "1.00e-1" in tip and "2 ms" in tip, f"beside a cell: {tip}")
        expect("exact time 0.5" in detail and "123,456" in detail, f"below a row: {detail}")
        expect(seen == {"rows": 4, "cells": 12, "hidden": True,
                        "closed": True, "late": 1, "crashed": 1, "found": 1, "count": "1 of 4 cases",
                        "error": ""}, f"what the page shows: {seen}")


check_sums(fixture())
check_picture(fixture())
check_text(fixture())
check_page(fixture())
end()
