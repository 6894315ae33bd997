"""Hands that hold, squeeze, pinch and hit in simulated worlds: outcomes, quantities over the time
step, and ours beside stock Bullet, setting by setting."""
from plot import page
from plot.page import tag
from plot.pictures import (HUES, INK, SOFT, Figure, cell_samples, draw_cells, draw_lines, foot,
                           panels, sample, save)
from plot.words import number, quantile, unique

STOCK, OURS = "stock", "ours, world"
COLOURS = {STOCK: HUES["bullet"][0], OURS: HUES["ours"][0]}
# From best to worst: letter, colour of the cell, colour of the letter; told apart without colours.
LOOKS = {"held": ("H", "#9ec9f5", INK), "slipped": ("S", "#f3e08a", INK),
         "dropped": ("D", "#f2a65e", INK), "through": ("T", "#e5636f", INK),
         "exploded": ("X", "#b07cc6", INK), "timed out": ("O", "#9aa1a9", INK),
         "crashed": ("C", "#9aa1a9", INK)}
SHADES = {10: 0.35, 50: 0.65, 200: 1.0}  # by the number of iterations


def is_in_hand(world, run):
    return not world["passive"] and run["verdict"] in ("held", "slipped")


def is_finite(_, run):
    return run["verdict"] not in ("crashed", "timed out")


# Quantity: name of the picture, title, lowest value that is drawn, where it means something, what a
# cross says, up to where two values count as the same.
CHARTS = {
    "drift": ("drift", "Drift of the object in the hand [m]", 1e-9, is_in_hand,
              "no longer in the hand", 1e-5),
    "depth": ("depth", "Deepest penetration at the ends of steps [m]", 1e-7, is_finite,
              "no answer", 1e-5),
    "maxKinetic": ("energy", "Kinetic energy where rest is expected [J]", 1e-15, is_in_hand,
                   "no longer in the hand", 1e-9),
    "realTime": ("time", "Processor time of a simulated second [s]", None, is_finite,
                 "no answer", 0.0)}


def runs_of(measured, world, method=None):
    return [r for r in measured["runs"] if r["world"] == world and method in (None, r["method"])]


def worlds_of(measured):
    ran = {r["world"] for r in measured["runs"]}
    return [w for w in measured["worlds"] if w["name"] in ran]


def describe(run):
    return (f"{run['method']}: {run['verdict']}\n{run['world']}\n1/{run['rate']} s, "
            f"{run['iterations']} iterations\ndrift\t{number(run.get('drift'))} m\n"
            f"depth\t{number(run.get('depth'))} m\n"
            f"a simulated second\t{number(run.get('realTime'))} s")


def draw_outcomes(measured):
    """(figure, tips): a row per world and method, a cell per time step and number of iterations."""
    rates, iterations = measured["rates"], measured["iterations"]
    columns = {(rate, count): k * (len(iterations) + 0.5) + i
               for k, rate in enumerate(rates) for i, count in enumerate(iterations)}
    cells, tips, names, row = [], {}, {}, 0
    for world in worlds_of(measured):
        names[row] = world["title"]
        for method in unique(r["method"] for r in runs_of(measured, world["name"])):
            row += 1
            names[row] = method
            for run in runs_of(measured, world["name"], method):
                tips[f"outcome-{len(cells)}"] = describe(run)
                cells.append((columns[run["rate"], run["iterations"]], row, run["verdict"],
                              f"outcome-{len(cells)}"))
        row += 1.4
    figure = Figure(figsize=(5.2 + 0.27 * max(columns.values()), 0.8 + 0.185 * row),
                    layout="constrained")
    axes = figure.subplots()
    draw_cells(axes, cells, LOOKS)
    axes.set_ylim(row - 0.4, -0.8)
    axes.set_xticks(list(columns.values()), [
        (f"1/{rate} s\n" if count == iterations[0] else "") + str(count)
        for rate, count in columns], size=8)
    axes.set_yticks(list(names), names.values(), size=8)
    for words in axes.get_yticklabels():
        is_world = words.get_text() in [w["title"] for w in measured["worlds"]]
        words.set_fontweight("bold" if is_world else "normal")
    axes.set_title("time step, iterations of the solver", size=9, color=SOFT, weight="normal")
    seen = {r["verdict"] for r in measured["runs"]}
    foot(figure, cell_samples(LOOKS, {v: v for v in LOOKS if v in seen}), 7)
    return figure, tips


def draw_chart(measured, key):
    """A panel per world: stock and ours over the time step, shades for iterations; None if there is
    nothing to be seen."""
    _, _, lowest, is_valid, lost, _ = CHARTS[key]
    def value_of(world, run):
        return run[key] if key in run and is_valid(world, run) else None
    worlds = [w for w in worlds_of(measured)
              if any(value_of(w, r) is not None for r in runs_of(measured, w["name"]))]
    if not worlds:
        return None
    shown = [n for n in measured["iterations"] if n in SHADES] or measured["iterations"]
    looks = {(m, n): {"color": COLOURS[m], "alpha": SHADES.get(n, 0.7), "marker": "o",
                      "markersize": 3.5} for m in COLOURS for n in shown}
    lines = {w["name"]: [([(r["rate"], value_of(w, r)) for r in runs_of(measured, w["name"], method)
                           if r["iterations"] == n], look) for (method, n), look in looks.items()]
             for w in worlds}
    span = [y for own in lines.values() for points, _ in own for _, y in points if y is not None]
    figure, axes = panels(len(worlds), share=True)
    for world, one in zip(worlds, axes):
        title, _, surface = world["title"].rpartition(", ")
        draw_lines(one, f"{surface}\n{title}", {rate: str(rate) for rate in measured["rates"]},
                   lines[world["name"]], lowest, span=span)
        one.set_xlabel("steps per second")
    foot(figure, [sample(f"{m}, {n} iterations", **look) for (m, n), look in looks.items()] +
         [sample(lost, linestyle="", marker="x", color=SOFT)], 4)
    return figure


def beside_stock(measured, suffix):
    """(world of stock, run of stock, run of ours): ours where the world has a suffix."""
    ours = {(r["world"], r["rate"], r["iterations"]): r for r in measured["runs"]
            if r["method"] == OURS}
    return [(w, r, ours[key]) for w in worlds_of(measured)
            for r in runs_of(measured, w["name"], STOCK)
            for key in [(r["world"] + suffix, r["rate"], r["iterations"])] if key in ours]


def comparison_row(title, triples, value_of, factor, floor):
    """How often ours is better and worse than stock by more than a factor, and where most."""
    known = [(w, s, o, value_of(w, s), value_of(w, o)) for w, s, o in triples]
    known = [entry for entry in known if None not in entry]
    worse = [entry for entry in known if entry[4] > max(factor * entry[3], floor)]
    better = sum(s > max(factor * o, floor) for *_, s, o in known)
    factors = [o / s for *_, s, o in known if s > 0.0]
    examples = "\n".join(
        f"{w['title']}, 1/{s['rate']} s, {s['iterations']} iterations: stock "
        f"{s['verdict']} ({number(a)}), ours {o['verdict']} ({number(b)})"
        for w, s, o, a, b in sorted(worse, key=lambda entry: -entry[4])[:3])
    return [tag("td", title, class_="set-up"), len(known), better,
            tag("td", len(worse), class_="number wrong" if worse else "number"),
            number(quantile(factors, 0.5)), tag("td", examples, class_="lines")]


def comparison_table(measured):
    rows = []
    for suffix, words in (("", ""), ("_mesh", "; meshes in ours, Bullet's shapes in stock")):
        triples = beside_stock(measured, suffix)
        if suffix and not triples:
            continue
        rows.append(comparison_row(f"Outcome, from 0 (held) to 6 (crashed){words}", triples,
                                   lambda _, run: list(LOOKS).index(run["verdict"]), 1.0, 0.0))
        held = [t for t in triples if all(r["verdict"] in ("held", "slipped") for r in t[1:])]
        rows += [comparison_row(
            f"{title}{words}", held,
            lambda w, r, key=key, valid=valid: r.get(key) if valid(w, r) else None, 1.5, floor)
            for key, (_, title, _, valid, _, floor) in CHARTS.items()]
    return page.join([
        tag("p", "Setting by setting. Quantities are compared where both hold what they hold; ours "
                 "counts as better or worse if they differ by more than half."),
        page.table(["our world beside stock Bullet", "settings", "better", "worse", "median factor",
                    "the worst"], rows, around="wide")])


def worlds_table(measured):
    """What became of all runs of a world and method, and how far they were off."""
    rows = []
    for world in worlds_of(measured):
        for method in unique(r["method"] for r in runs_of(measured, world["name"])):
            runs = runs_of(measured, world["name"], method)
            held = [r for r in runs if is_in_hand(world, r)]
            depths = [r["depth"] for r in runs if "depth" in r]
            gains = [r["energyGain"] for r in runs if world["passive"] and "energyGain" in r]
            drifts, kinetic = ([r[key] for r in held] for key in ("drift", "maxKinetic"))
            times = [r["realTime"] for r in runs if "realTime" in r]
            rows.append([world["title"], method] +
                        [sum(r["verdict"] == v for r in runs) or "" for v in LOOKS] +
                        [number(n) for n in (
                            quantile(drifts, 0.5), max(drifts, default=None),
                            quantile(depths, 0.5), max(depths, default=None))] +
                        [f"{depths.count(0.0)} of {len(depths)}", number(quantile(kinetic, 0.5)),
                         number(max(gains, default=None)), number(quantile(times, 0.5)),
                         sum(r.get("impacts", 0) for r in runs) or ""])
    return page.table(["world", "method", *LOOKS, "drift, median [m]", "worst", "depth, median [m]",
                       "worst", "never deep", "kinetic, median [J]", "energy gained, worst",
                       "s / s, median", "impacts"], rows)


def section_of(measured, folder, _=()):
    """HTML of the section; writes its pictures into the folder, too."""
    def picture(name, figure, tips=None):
        return tag("div", page.Html(save(figure, folder, f"simulation_{name}", tips)),
                   class_="figure")
    charts = [(title, name, draw_chart(measured, key))
              for key, (name, title, *_) in CHARTS.items()]
    return page.section(
        measured,
        tag("p", f"{len(worlds_of(measured))} worlds of Bullet in {measured['precision']} "
                 f"precision, each with {len(measured['rates'])} time steps and "
                 f"{len(measured['iterations'])} numbers of iterations; every run has a process of "
                 f"its own. Slipped: more than {1e3 * measured['slip']:g} mm in the hand; dropped: "
                 f"more than {1e3 * measured['drop']:g} mm or gone; through: something has passed "
                 "through something else; exploded: faster than anything in the world can make it, "
                 "or twice the energy. Meshes are GImpact in stock Bullet and btCcdMeshShape in "
                 "ours. Penetration is found by an exact check of all triangles; Bullet lets its "
                 "convex shapes sink in while it stops them, with ours as well once they touch. "
                 "Nothing drives the links that hit the wall, so energy can only fall."),
        tag("h3", "Outcomes"), picture("outcomes", *draw_outcomes(measured)),
        comparison_table(measured),
        *[part for title, name, figure in charts if figure
          for part in (tag("h3", title), picture(name, figure))],
        tag("h3", "All worlds"), worlds_table(measured))
