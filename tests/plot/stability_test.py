#!/usr/bin/python3
"""The section on simulations: every outcome is drawn, the pictures are well-formed, and the table says what is in the data.
"""
import re
import tempfile
from pathlib import Path

from checks import end, expect, expect_alone, expect_picture
from plot import simulation
from plot.words import number, quantile


def run(world, method, rate, iterations, verdict, **values):
    numbers = {"drift": 1e-4, "depth": 1e-5, "maxKinetic": 1e-9, "energyGain": 0.0,
               "realTime": 0.01, **values}
    return {"world": world, "method": method, "rate": rate, "iterations": iterations,
            "verdict": verdict, **({} if verdict == "crashed" else numbers)}


def simulation_fixture():
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


def check_statistics():
    expect(quantile([], 0.5) is None, "the quantile of nothing")
    expect(quantile([3, 1, 2], 0.5) == 2 and quantile([3, 1, 2], 0.95) == 3, "quantiles")
    expect([number(n) for n in (0.00002, 111, 1e-4, 0.00123, 0, None)] ==
           ["2e-5", "110", "1e-4", "0.0012", "0", "–"], "numbers")


def check_section(family, measured, names, words):
    """Gives the pictures that came with the section."""
    with tempfile.TemporaryDirectory() as folder:
        section = family.section_of(measured, Path(folder))
        pictures = {file.stem: file.read_text() for file in Path(folder).glob("*.svg")}
        painted = {file.stem for file in Path(folder).glob("*.png") if file.stat().st_size > 5000}
    expect(set(pictures) == painted == names, f"pictures of {measured['family']}: {painted}")
    for name, picture in pictures.items():
        expect_picture(picture, name)
        expect(picture in section, f"{name} is on the page")
    expect(section.startswith("<section") and section.endswith("</section>"), "a section")
    expect(section.count("<h2>") == 1 and section.count("<h3>") >= 2, "headings")
    expect("<hold>" not in section, "names are escaped")
    expect_alone(section)
    # One line per row, | between cells.
    text = re.sub(r"<[^>]+>", "", re.sub(r"</t[dh]>", "|", section.replace("</tr>", "\n|")))
    for word in words:
        expect(re.search(word, text), f"the section on {measured['family']} does not say: {word}")
    return pictures


check_statistics()
pictures = check_section(
    simulation, simulation_fixture(),
    {"simulation_outcomes", "simulation_drift"},
    # Both runs of stock went through and sank in; of ours one ended and held.
    [r"meshes\|stock\|2\|\|\|\|2\|\|\|\|0.002\|",
     r"meshes\|ours, world\|2\|1\|\|\|\|\|\|1\|0\|"])
cells = re.findall(r'<g id="outcome-\d+"><title>([^<]*)', pictures["simulation_outcomes"])
expect(len(cells) == 8 and sum("crashed" in words for words in cells) == 1,
       f"a cell a run, with its tip: {cells}")
letters = re.findall(r">([HSTC])</text>", pictures["simulation_outcomes"])
expect(sorted(letters) == list("CHHHHSTT"), f"a letter a run: {letters}")
end(needs_browser=False)
