#!/usr/bin/python3
"""The chart and its page in a browser without a window: every point is drawn, the page filters,
sorts, shows what is behind a mark, and raises no error; and the settings that it advises are right.
"""
import json
import tempfile
from pathlib import Path

from checks import end, expect, expect_alone, expect_picture, see
from plot import chart, folder
from plot.pictures import svg
from plot.points import choices, front, is_right


def point(scene, method, setting, micros, errors, **flaws):
    hits, missed = 10, flaws.get("missed", 0)
    return {"scene": scene, "title": f"{scene} <{method}>", "method": method, "setting": setting,
            "queries": 12, "hits": hits, "found": hits - missed,
            "missed": missed, "late": flaws.get("late", 0), "false": 0, "timedOut": 0,
            "meanMicroseconds": micros, "medianMicroseconds": 0.9 * micros,
            "medianError": errors[0], "maxError": errors[1]}


def fixture():
    """Two scenes; sampling is fastest and late, one method is in one scene, one found nothing."""
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
    picture = svg(chart.draw(measured), "rigid", chart.tips_of(measured))
    expect_picture(picture, "the chart")
    for number, point in enumerate(measured["points"]):
        expect(f'<g id="rigid-{number}"><title>{point["method"]}, {point["setting"]}' in picture,
               f"point {number} is drawn and has a tip")
        for flaw in ("missed", "late"):
            expect((f'id="rigid-{number}-{flaw}"' in picture) == (point[flaw] > 0),
                   f"a cross says whether point {number} is {flaw}")
    expect("&lt;ours&gt;" in picture and "Two &amp; more" in picture, "the SVG escapes names")


def pages_of(*families, scenes=()):
    """(the page of measurements, the picture of the first)."""
    with tempfile.TemporaryDirectory() as name:
        for measured in families:
            (Path(name) / f"{measured['family']}.json").write_text(json.dumps(measured))
        expect(folder.draw("chart", Path(name), scenes) == [], "no failures in charts")
        return ((Path(name) / "index.html").read_text(),
                (Path(name) / f"{families[0]['family']}.svg").read_text())


ACTIONS = """
const firstOf = () => document.querySelector(".points tbody tr").children[1].textContent;
const marks = '.panels g[id^="rigid-"]:not([id*="-way-"], [id*="front-"], [id$="e"], ' +
    '[id$="d"], [id$="g"])';
seen.points = shown(marks);
seen.rows = shown(".points tbody tr");
seen.choices = shown(".choices tbody tr");
seen.fastest = firstOf();
const heading = [...document.querySelectorAll(".points thead th")]
    .find(cell => cell.textContent === "mean time");
heading.click();
heading.click();
seen.slowest = firstOf();
seen.tip = tipOf(document.getElementById("rigid-0"));
seen.same = shown(".panels .same");
document.getElementById("rigid-0").dispatchEvent(new MouseEvent("mouseleave"));
seen.hidden = document.getElementById("tip").classList.contains("off");
choose(".find", "FCL");
seen.afterMethod = shown(marks);
choose(".find", "fcl, second");
seen.afterScene = shown(marks);
seen.crosses = shown('.panels g[id$="late"]');
seen.count = document.querySelector(".count").textContent;
"""


def check_page(measured):
    page, picture = pages_of(measured, {**measured, "family": "step"}, scenes=["second"])
    expect_alone(page)
    expect("second &lt;" in picture and "first &lt;" not in picture, "scenes that are asked for")
    expect("Not on this page: not measured: benchmarks/run chart closing" in page,
           "a missing family is said")
    # Actions are on a page of one family, that numbers need not tell two sections apart.
    seen = see(pages_of(measured)[0], ACTIONS)
    if seen:
        tip = seen.pop("tip")
        fcl = [p for p in measured["points"] if "FCL" in p["method"]]
        expect("ours, 1e-2" in tip and "10 µs" in tip and "8.0e-3" in tip, f"beside a mark: {tip}")
        expect(seen == {"points": 10, "rows": 10, "choices": 2, "fastest": "Bullet cast",
                        "slowest": "FCL sampling", "same": 2, "hidden": True, "afterMethod": len(fcl),
                        "afterScene": sum(p["scene"].startswith("second") for p in fcl),
                        "crosses": sum(p["late"] > 0 and p["scene"].startswith("second")
                                       for p in fcl),
                        "count": "2 of 10 points", "error": ""}, f"what the page shows: {seen}")


check_choices(fixture())
check_picture(fixture())
check_page(fixture())
end()
