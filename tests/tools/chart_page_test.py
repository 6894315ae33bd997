#!/usr/bin/env python3
"""The page of tools/chart in a browser without a window: it draws every point, filters, sorts,
shows what is behind a mark, and raises no error; and the settings that it advises are right.

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
import chart_page  # noqa: E402
import chart_svg  # noqa: E402
from chart_points import choices, front, is_right  # noqa: E402


def point(scene, method, setting, micros, errors, **flaws):
    hits, missed = 10, flaws.get("missed", 0)
    return {"scene": scene, "title": f"{scene} <{method}>", "method": method, "setting": setting,
            "queries": 12, "hits": hits, "found": hits - missed,
            "missed": missed, "late": flaws.get("late", 0), "false": 0, "timedOut": 0,
            "meanMicroseconds": micros, "medianMicroseconds": 0.9 * micros,
            "medianError": errors[0], "maxError": errors[1]}


def fixture():
    """Two scenes; sampling is fastest and late, a method is only in one scene, one found nothing."""
    points = []
    for scene, factor in (("first", 1.0), ("second", 3.0)):
        points += [point(scene, "ours", "1e-2", 10 * factor, (2e-3, 8e-3)),
                   point(scene, "ours", "1e-4", 30 * factor, (2e-5, 8e-5)),
                   point(scene, "FCL sampling", "x11", 2 * factor, (1e-2, 5e-2), late=9),
                   point(scene, "FCL sampling", "x1001", 900 * factor, (1e-4, 5e-4), late=10)]
    points.append(point("first", "Bullet cast", "margin 0", 1, (1e-3, 4e-3)))
    points.append(point("second", "Bullet cast", "margin 0.04", 1, (0, 0), missed=10))
    return {"family": "rigid", "title": "Two & more bodies", "time": "time of a query",
            "error": "error", "compiler": "compiler", "flags": "-O3", "peers": ["FCL", ""],
            "flaws": {"missed": "missed", "late": "late", "false": "false", "timedOut": ""},
            "commit": "0", "points": points}


def check_choices(measured):
    everywhere = {round(t, 12): best and (best["method"], best["setting"])
                  for t, best in choices(measured)}
    expect(everywhere == {0.1: ("ours", "1e-2"), 0.03: ("ours", "1e-2"), 0.01: ("ours", "1e-2"),
                          0.003: ("ours", "1e-4"), 0.001: ("ours", "1e-4"),
                          0.0003: ("ours", "1e-4"), 0.0001: ("ours", "1e-4")},
           f"settings for every scene: {everywhere}")
    first = dict((round(t, 12), best["method"]) for t, best in choices(measured, "first"))
    expect(first[0.01] == "Bullet cast" and first[0.001] == "ours",
           f"settings for one scene: {first}")
    own = [p for p in measured["points"] if p["scene"] == "first"]
    expect([p["method"] for p in front(own)] == ["Bullet cast", "ours"], "the front of everything")
    expect(all(is_right(p) for p in front([p for p in own if is_right(p)])), "the front is right")


def check_picture(measured):
    picture, width, height = chart_svg.draw(measured)
    count = picture.count('class="point')
    expect(count == len(measured["points"]), f"{count} points in the SVG")
    expect("&lt;ours&gt;" in picture and "Two &amp; more" in picture, "the SVG escapes names")
    expect(width > 0 and height > 0, "the SVG has a size")


# What a user does, then what the page shows; the document carries it out.
ACTIONS = """<script>
const seen = {};
const shown = selector => [...document.querySelectorAll(selector)]
    .filter(element => !element.closest(".off")).length;
const firstOf = () => document.querySelector(".points tbody tr").children[1].textContent;
seen.points = shown(".point");
seen.rows = shown(".points tbody tr");
seen.choices = shown(".choices tbody tr");
seen.fastest = firstOf();
const heading = [...document.querySelectorAll(".points thead th")]
    .find(cell => cell.dataset.key === "meanMicroseconds");
heading.click();
seen.slowest = firstOf();
document.querySelector(".point").dispatchEvent(
    new MouseEvent("mouseenter", { clientX: 300, clientY: 300 }));
seen.tip = document.getElementById("tip").textContent;
seen.same = shown(".point.same");
document.querySelector(".point").dispatchEvent(new MouseEvent("mouseleave"));
seen.hidden = document.getElementById("tip").classList.contains("off");
const front = () => document.querySelector(".panel .front").getAttribute("d");
const before = front();
[...document.querySelectorAll(".chip")].find(c => c.dataset.method === "Bullet cast").click();
seen.afterMethod = shown(".point");
seen.frontMoved = front() !== before;
[...document.querySelectorAll(".chip")].find(c => c.dataset.scene === "second").click();
seen.afterScene = shown(".point");
document.querySelector(".only-right").click();
seen.onlyRight = shown(".point");
seen.count = document.querySelector(".count").textContent;
seen.error = document.body.dataset.error ?? "";
document.body.dataset.seen = JSON.stringify(seen);
</script></body>"""


def check_page(measured, browser, folder):
    page = chart_page.make_page([measured, {**measured, "family": "step"}])
    outside = re.findall(r'(?:src|href)="(?!#|data:)[^"]*"|url\(|@import|fetch\(', page)
    expect(not outside, f"the page refers to other files: {outside}")
    # Actions are on a page of one family, that numbers need not tell two sections apart.
    page = chart_page.make_page([measured])
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
    tip = seen.pop("tip")
    expect("ours, 1e-2" in tip and "10 µs" in tip and "8.0e-3" in tip, f"beside a mark: {tip}")
    expect(seen == {"points": 10, "rows": 10, "choices": 2, "fastest": "Bullet cast",
                    "slowest": "FCL sampling", "same": 2, "hidden": True, "afterMethod": 8,
                    "frontMoved": True, "afterScene": 4, "onlyRight": 2,
                    "count": "2 of 10 points", "error": ""}, f"what the page shows: {seen}")


def main():
    measured = fixture()
    check_choices(measured)
    check_picture(measured)
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which(
        "google-chrome")
    if browser is not None:
        with tempfile.TemporaryDirectory() as folder:
            check_page(measured, browser, folder)
    if failures:
        sys.exit(1)
    if browser is None:
        print("skipped: the page in a browser: Chromium is not installed")
        sys.exit(77)


if __name__ == "__main__":
    main()
