#!/usr/bin/env python3
"""The section of the page of tools/stability on grasps and simulations: every outcome is drawn, the
pictures are well-formed, and the text says what is in the data, where ours is worse, too.
"""
import re
import sys
import xml.etree.ElementTree as ElementTree

sys.dont_write_bytecode = True  # no __pycache__ in the sources
from page_checks import expect, failures  # noqa: E402
import stability_charts  # noqa: E402
import stability_world_charts  # noqa: E402
from stability_numbers import number, quantile  # noqa: E402


def run(world, method, rate, iterations, verdict, **values):
    numbers = {"drift": 1e-4, "depth": 1e-5, "maxKinetic": 1e-9, "energyGain": 0.0,
               "realTime": 0.01, **values}
    return {"world": world, "method": method, "rate": rate, "iterations": iterations,
            "verdict": verdict, **({} if verdict == "crashed" else numbers)}


def simulation():
    """Ours is better in one setting, worse in another, and a run crashed."""
    runs = []
    for rate in (60, 240):
        runs += [run("hold", "stock", rate, 10, "held", drift=2e-4),
                 run("hold", "ours, world", rate, 10, "slipped" if rate == 60 else "held",
                     drift=2e-3 if rate == 60 else 2e-4, realTime=0.03),
                 run("hit", "stock", rate, 10, "through", energyGain=0.5, depth=2e-3),
                 run("hit", "ours, world", rate, 10, "held" if rate == 60 else "crashed",
                     drift=0.0, depth=0.0)]
    worlds = [{"name": "hold", "group": "hold", "title": "jaws <hold>, convex shapes",
               "seconds": 1.0, "passive": False},
              {"name": "hit", "group": "light", "title": "links hit, meshes", "seconds": 1.0,
               "passive": True}]
    return {"family": "simulation", "title": "Simulated & held", "precision": "double",
            "rates": [60, 240], "iterations": [10], "slip": 1e-3, "drop": 0.02, "worlds": worlds,
            "runs": runs, "peers": ["Bullet 324"], "compiler": "compiler", "flags": "-O3"}


def grasps():
    """Joints of ours move 20 times as much as the error, those of stepping not at all or by much."""
    methods = ["ours", "stepping, GraspIt! steps"]
    noise, meshes = [], []
    for method in methods:
        for size in (1e-6, 1e-3):
            posture = ([20 * size] * 4 if method == "ours" else [0.0, 0.0, 0.0, 5e-3])
            kept = 4 if size < 1e-4 else 1
            noise.append({"hand": "hand <1>", "object": "mug", "grasp": 1, "method": method,
                          "planned": "force closure", "noise": size, "draws": 4, "closed": 4,
                          "sameLinks": 4, "success": kept, "posture": posture,
                          "quietPosture": posture, "shift": [size] * 4, "epsilon": [size] * 4,
                          "contacts": [5] * 4,
                          "before": {"success": True, "contacts": 5, "epsilon": 0.1}})
        for triangles in (1024, 4096, 16384):
            meshes.append({"hand": "hand <1>", "object": "egg", "triangles": triangles,
                           "finest": triangles == 16384, "grasp": 1, "method": method,
                           "planned": "force closure", "closed": True, "contacts": 4,
                           "value": 0.1, "epsilon": 0.0 if triangles == 16384 else 0.01,
                           "posture": 0.0 if triangles == 16384 else 1e-3, "shift": 0.0,
                           "sameLinks": True, "success": triangles > 2000})
    return {"family": "grasps", "title": "Grasps & errors", "noises": [1e-6, 1e-3],
            "methods": methods, "draws": 4, "seed": 1, "noise": noise, "meshes": meshes,
            "pairs": [{"hand": "hand <1>", "object": "mug", "grasps": 1, "closures": 1}],
            "peers": [], "compiler": "compiler", "flags": "-O3"}


def check_statistics():
    expect(quantile([], 0.5) is None, "the quantile of nothing")
    expect(quantile([3, 1, 2], 0.5) == 2 and quantile([3, 1, 2], 0.95) == 3, "quantiles")
    expect(number(0.00002) == "2e-5" and number(111) == "110" and
           number(1e-4) == "1e-4" and number(0.00123) == "0.0012" and number(0) == "0" and number(None) == "–", "numbers")


def check_pictures(measured, names):
    drawn = stability_charts.pictures(measured)
    expect(set(drawn) == names, f"pictures of {measured['family']}: {sorted(drawn)}")
    for name, picture in drawn.items():
        try:
            ElementTree.fromstring(picture)
        except ElementTree.ParseError as error:
            expect(False, f"{name} is no XML: {error}")
        expect("nan" not in picture and "inf" not in picture, f"{name} has no place for a point")


def check_section(measured, words):
    section = stability_charts.section(measured)
    expect(section.startswith("<section") and section.endswith("</section>"), "a section")
    expect(section.count("<h2>") == 1 and section.count("<h3>") >= 2, "headings")
    expect("<hold>" not in section and "hand <1>" not in section, "names are escaped")
    outside = re.findall(r'(?:src|href)="(?!#|data:)[^"]*"|url\(|@import', section)
    expect(not outside, f"the section refers to other files: {outside}")
    text = re.sub(r"<[^>]+>", "", section)
    for word in words:
        expect(word in text, f"the text of {measured['family']} does not say: {word}")


def main():
    check_statistics()
    check_pictures(simulation(), {"simulation_outcomes", "simulation_drift", "simulation_depth",
                                  "simulation_energy", "simulation_time"})
    check_pictures(grasps(), {"grasps_noise", "grasps_meshes"})
    cells = stability_world_charts.outcome_picture(simulation()).count('class="outcome"')
    expect(cells == 8 + 4, f"a cell a run and one a kind of outcome in the legend, not {cells}")
    check_section(simulation(), [
        "worse in 2", "stock held, ours slipped", "stock through, ours crashed",
        "Went through: stock 2, ours, world 0", "none in 1 of 1 runs",
        "stock 2 of 2 (largest gain 0.5", "ours, world 0 of 1"])
    check_section(grasps(), [
        "by 20, 20 rad a metre in the median", "ours 1 of 1", "kept: ours 25 %",
        "100 % of the force closures are kept"])
    print("FAILED" if failures else "OK")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
