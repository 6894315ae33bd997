"""Hands that hold, squeeze, pinch and hit in simulated worlds: outcomes, and ours beside stock
Bullet, setting by setting."""
from plot import page
from plot.page import tag
from plot.pictures import INK, SOFT, Figure, cell_samples, draw_cells, foot, save
from plot.words import number, quantile, unique

STOCK, OURS = "stock", "ours, world"
# From best to worst: letter, colour of the cell, colour of the letter; told apart without colours.
LOOKS = {"held": ("H", "#9ec9f5", INK), "slipped": ("S", "#f3e08a", INK),
         "dropped": ("D", "#f2a65e", INK), "through": ("T", "#e5636f", INK),
         "exploded": ("X", "#b07cc6", INK), "timed out": ("O", "#9aa1a9", INK),
         "crashed": ("C", "#9aa1a9", INK)}


def is_in_hand(world, run):
    return not world["passive"] and run["verdict"] in ("held", "slipped")


def is_finite(_, run):
    return run["verdict"] not in ("crashed", "timed out")


# Quantity: title, where it means something, up to where two values count as the same.
QUANTITIES = {
    "drift": ("Drift of the object in the hand [m]", is_in_hand, 1e-5),
    "depth": ("Deepest penetration at the ends of steps [m]", is_finite, 1e-5),
    "maxKinetic": ("Kinetic energy where rest is expected [J]", is_in_hand, 1e-9),
    "realTime": ("Processor time of a simulated second [s]", is_finite, 0.0)}


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
            for key, (title, valid, floor) in QUANTITIES.items()]
    return page.join([
        tag("p", "Setting by setting. Quantities are compared where both hold what they hold; ours "
                 "counts as better or worse if they differ by more than half."),
        page.table(["our world beside stock Bullet", "settings", "better", "worse", "median factor",
                    "the worst"], rows, around="wide")])


def outcomes_table(measured):
    """What became of all runs, by shapes and method."""
    shapes = {w["name"]: w["title"].rpartition(", ")[2] for w in measured["worlds"]}
    groups = {}
    for run in measured["runs"]:
        groups.setdefault((shapes[run["world"]], run["method"]), []).append(run)
    rows = [[*names, len(runs)] + [sum(r["verdict"] == v for r in runs) or "" for v in LOOKS] +
            [number(max((r["depth"] for r in runs if "depth" in r), default=None)),
             sum(r.get("impacts", 0) for r in runs) or ""] for names, runs in groups.items()]
    return page.table(["shapes", "method", "runs", *LOOKS, "deepest penetration [m]", "impacts"],
                      rows)


def section_of(measured, folder, _=()):
    """HTML of the section; writes its picture into the folder, too."""
    figure, tips = draw_outcomes(measured)
    outcomes = page.Html(save(figure, folder, "simulation_outcomes", tips))
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
        tag("h3", "Outcomes"), tag("div", outcomes, class_="figure"),
        outcomes_table(measured), tag("h3", "Ours beside stock"), comparison_table(measured))
