"""Hands that hold, squeeze, pinch and hit in simulations: charts, tables and what they show. The
text is computed from the data, where ours is worse, too."""
from plot import page
from plot.page import tag
from plot.pictures import (HUES, SOFT, Figure, cell_samples, draw_cells, draw_lines, foot, panels,
                           sample, save)
from plot.words import number, quantile, unique

OURS, STOCK = "ours, world", "stock"
COLOURS = {STOCK: HUES["bullet"][0], OURS: HUES["ours"][0]}
INK = "#10151b"
# From best to worst: letter, colour of the cell, colour of the letter; told apart without colours.
LOOKS = {"held": ("H", "#9ec9f5", INK), "slipped": ("S", "#f3e08a", INK),
         "dropped": ("D", "#f2a65e", INK), "through": ("T", "#e5636f", INK),
         "exploded": ("X", "#b07cc6", INK), "timed out": ("O", "#9aa1a9", INK),
         "crashed": ("C", "#9aa1a9", INK)}
SHADES = {10: 0.35, 50: 0.65, 200: 1.0}
SURFACES = ("convex shapes", "meshes")
LOWEST_DRIFT = 1e-9


def is_in_hand(world, run):
    return not world["passive"] and run["verdict"] in ("held", "slipped")


def is_finite(_, run):
    return run["verdict"] not in ("crashed", "timed out")


# Quantity: title, lowest value that is drawn, where it means something, what a cross says.
CHARTS = {
    "drift": ("Drift of the object in the hand [m]", LOWEST_DRIFT, is_in_hand,
              "no longer in the hand"),
    "depth": ("Deepest penetration at the ends of steps [m]", 1e-7, is_finite, "no answer"),
    "maxKinetic": ("Kinetic energy where rest is expected [J]", 1e-15, is_in_hand,
                   "no longer in the hand"),
    "realTime": ("Processor time of a simulated second [s]", None, is_finite, "no answer")}
PICTURES = {"drift": "drift", "depth": "depth", "maxKinetic": "energy", "realTime": "time"}


def runs_of(measured, world, method=None):
    return [r for r in measured["runs"]
            if r["world"] == world and method in (None, r["method"])]


def worlds_of(measured):
    ran = {r["world"] for r in measured["runs"]}
    return [w for w in measured["worlds"] if w["name"] in ran]


def rank(run):
    return list(LOOKS).index(run["verdict"])


def setting_of(run):
    return f"1/{run['rate']} s, {run['iterations']} iterations"


def describe(run):
    return (f"{run['method']}: {run['verdict']}\n{run['world']}\n{setting_of(run)}\n"
            f"drift\t{number(run.get('drift'))} m\ndepth\t{number(run.get('depth'))} m\n"
            f"a simulated second\t{number(run.get('realTime'))} s")


def draw_outcomes(measured):
    """(figure, tips): a row a world and method, a cell a time step and number of iterations."""
    rates, iterations = measured["rates"], measured["iterations"]
    def column_of(rate, count):
        return rates.index(rate) * (len(iterations) + 0.5) + iterations.index(count)
    cells, tips, names = [], {}, {}
    row = 0
    for world in worlds_of(measured):
        names[row] = world["title"]
        for method in unique(r["method"] for r in runs_of(measured, world["name"])):
            row += 1
            names[row] = method
            for run in runs_of(measured, world["name"], method):
                name = f"outcome-{len(cells)}"
                tips[name] = describe(run)
                cells.append((column_of(run["rate"], run["iterations"]), row, run["verdict"], name))
        row += 1.4
    width = column_of(rates[-1], iterations[-1]) + 1
    figure = Figure(figsize=(3.6 + 0.27 * width, 0.8 + 0.185 * row), layout="constrained")
    axes = figure.subplots()
    draw_cells(axes, cells, LOOKS)
    axes.set_ylim(row - 0.4, -0.8)
    axes.set_xticks([column_of(rate, count) for rate in rates for count in iterations],
                    [(f"1/{rate} s\n" if count == iterations[0] else "") + str(count)
                     for rate in rates for count in iterations], size=8)
    axes.set_yticks(list(names), names.values(), size=8)
    titles = {w["title"] for w in measured["worlds"]}
    for words in axes.get_yticklabels():
        words.set_fontweight("bold" if words.get_text() in titles else "normal")
    axes.set_title("time step, iterations of the solver", size=9, color=SOFT, weight="normal")
    seen = {r["verdict"] for r in measured["runs"]}
    foot(figure, cell_samples(LOOKS, {v: v for v in LOOKS if v in seen}), 7)
    return figure, tips


def draw_chart(measured, key):
    """A panel a world: stock and ours over the time step, shades for iterations; None if nothing
    is to be seen."""
    _, lowest, is_valid, lost = CHARTS[key]
    def is_known(world, run):
        return key in run and is_valid(world, run)
    worlds = [w for w in worlds_of(measured)
              if any(is_known(w, r) for r in runs_of(measured, w["name"]))]
    if not worlds:
        return None
    shown = [n for n in measured["iterations"] if n in SHADES] or measured["iterations"]
    looks = {(m, n): {"color": COLOURS[m], "alpha": SHADES.get(n, 0.7), "marker": "o",
                      "markersize": 3.5} for m in COLOURS for n in shown}
    figure, axes = panels(len(worlds), share=True)
    span = [r[key] for w in worlds for m in COLOURS for r in runs_of(measured, w["name"], m)
            if is_known(w, r)]
    for world, one in zip(worlds, axes):
        lines = [([(r["rate"], r[key] if is_known(world, r) else None)
                   for r in sorted(runs_of(measured, world["name"], method),
                                   key=lambda r: r["rate"]) if r["iterations"] == n], look)
                 for (method, n), look in looks.items()]
        title, _, surface = world["title"].rpartition(", ")
        draw_lines(one, f"{surface}\n{title}", {rate: str(rate) for rate in measured["rates"]},
                   lines, lowest, span=span)
        one.set_xlabel("steps a second")
    foot(figure, [sample(f"{m}, {n} iterations", **look) for (m, n), look in looks.items()] +
         [sample(lost, linestyle="", marker="x", color=SOFT)], 4)
    return figure


def compared(measured):
    """(world, run of stock, run of ours) of every setting that both have."""
    worlds = {w["name"]: w for w in measured["worlds"]}
    return [(worlds[o["world"]], s, o) for s, o in beside_stock(measured, "")]


def beside_stock(measured, suffix):
    """(run of stock, run of ours): ours in the world whose name has the suffix behind that of stock."""
    stock = {(r["world"] + suffix, r["rate"], r["iterations"]): r for r in measured["runs"]
             if r["method"] == STOCK}
    return [(stock[key], r) for r in measured["runs"] if r["method"] == OURS
            for key in [(r["world"], r["rate"], r["iterations"])] if key in stock]


def sentences_of_outcomes(measured):
    pairs = compared(measured)
    better = [p for p in pairs if rank(p[2]) < rank(p[1])]
    worse = [p for p in pairs if rank(p[2]) > rank(p[1])]
    same = [p for p in pairs if all(p[2].get(key) == p[1].get(key)
                                    for key in ("drift", "depth", "verdict"))]
    methods = unique(r["method"] for r in measured["runs"])
    verdicts = {m: [r["verdict"] for r in measured["runs"] if r["method"] == m] for m in methods}
    words = ("Held (or, at the wall, stopped): " +
             ", ".join(f"{m} {v.count('held')} of {len(v)}" for m, v in verdicts.items()) +
             f". Setting by setting our world does better than stock Bullet in {len(better)} of "
             f"{len(pairs)}, worse in {len(worse)}, and the same to the last digit in {len(same)}: "
             "the contacts of Bullet's own shapes and the solver are Bullet's, and creep, slip and "
             "squeeze-out that come from too few iterations stay.")
    if worse:
        words += " Worse: " + "; ".join(
            f"{w['title']}, {setting_of(s)} (stock {s['verdict']}, ours {o['verdict']})"
            for w, s, o in worse[:12]) + (f"; and {len(worse) - 12} more" if len(worse) > 12
                                          else "") + "."
    through = ", ".join(f"{m} {v.count('through')}" for m, v in verdicts.items())
    return f"{words} Went through: {through}."


def sentences_of_meshes(measured):
    """Ours with meshes beside stock Bullet with its own shapes, which users have as a choice."""
    titles = {w["name"]: w["title"].rpartition(", ")[0] for w in measured["worlds"]}
    pairs = beside_stock(measured, "_mesh")
    if not pairs:
        return ""
    worse = [titles[o["world"]] for s, o in pairs if rank(o) > rank(s)]
    where = ", ".join(f"{title}: {worse.count(title)}" for title in unique(worse))
    return (f"Meshes in our world beside Bullet's own shapes in stock Bullet: better in "
            f"{sum(rank(o) < rank(s) for s, o in pairs)} of {len(pairs)} settings, worse in "
            f"{len(worse)}{f' ({where})' if worse else ''}. Both have the same solver, which with "
            "few iterations and unequal masses ends elsewhere for every order of the contacts: "
            "where a hold creeps, iterations help.")


def sentences_of_drift(measured):
    both = [(w, s, o) for w, s, o in compared(measured) if is_in_hand(w, s) and is_in_hand(w, o)]
    factors = [(o["drift"] / s["drift"], w, s, o) for w, s, o in both
               if s["drift"] > 0 and max(s["drift"], o["drift"]) > LOWEST_DRIFT]
    more = sorted((f for f in factors if f[0] > 1.5 and f[3]["drift"] > 1e-5),
                  key=lambda f: -f[3]["drift"])
    words = (f"Where both still hold the object ({len(both)} settings) ours drifts more than 1.5 "
             f"times as far as stock (and by more than 10 µm) in {len(more)}, less than 1 / 1.5 in "
             f"{sum(f[0] < 1 / 1.5 for f in factors)}.")
    if more:
        words += " The farthest of ours among them: " + "; ".join(
            f"{w['title']}, {setting_of(o)}: {number(o['drift'])} m instead of "
            f"{number(s['drift'])} m" for _, w, s, o in more[:3]) + "."
    lost = [w["title"] for w in worlds_of(measured) if not w["passive"] and not any(
        is_in_hand(w, r) for m in COLOURS for r in runs_of(measured, w["name"], m))]
    if lost:
        words += " Held in neither, and not drawn: " + "; ".join(lost) + "."
    return words


def sentences_of_depth(measured):
    words = []
    for surface in SURFACES:
        for method in COLOURS:
            depths = [(r["depth"], w, r) for w in worlds_of(measured)
                      if w["title"].endswith(surface)
                      for r in runs_of(measured, w["name"], method) if "depth" in r]
            if depths:
                depth, world, run = max(depths, key=lambda d: d[0])
                where = f"{world['title'].rpartition(', ')[0]}, {setting_of(run)}"
                words.append(f"{surface}, {method}: none in {sum(d[0] == 0 for d in depths)} of "
                             f"{len(depths)} runs" + (
                                 f", deepest {number(1e3 * depth)} mm ({where})" if depth else ""))
    return ("Penetration between meshes of the bodies, by an exact check of all triangles: " +
            "; ".join(words) + ". Convex shapes are Bullet's, which lets them sink in while it "
            "stops them; that is the same with ours once they have touched.")


def sentences_of_energy(measured):
    parts = []
    for method in unique(r["method"] for r in measured["runs"]):
        gains = [r["energyGain"] for w in worlds_of(measured) if w["passive"]
                 for r in runs_of(measured, w["name"], method) if "energyGain" in r]
        if gains:
            parts.append(f"{method} {sum(g > 1e-3 for g in gains)} of {len(gains)} "
                         f"(largest gain {number(max(gains))} times what there was)")
    both = [(s, o) for w, s, o in compared(measured) if is_in_hand(w, s) and is_in_hand(w, o)]
    livelier = sum(o["maxKinetic"] > max(10 * s["maxKinetic"], 1e-9) for s, o in both)
    return ("Nothing drives the links that hit the wall, so energy can only fall; it grew by more "
            "than 0.1 % in: " + ", ".join(parts) + f". At rest in the hand ours has more than ten "
            f"times the kinetic energy of stock (and above 1 nJ) in {livelier} of {len(both)} "
            "settings in which both hold.")


def sentences_of_time(measured):
    words = []
    for surface in SURFACES:
        factors = [o["realTime"] / s["realTime"] for w, s, o in compared(measured)
                   if w["title"].endswith(surface) and s.get("realTime", 0) > 0 and
                   rank(s) <= 1 and rank(o) <= 1 and "realTime" in o]
        if factors:
            words.append(f"{surface}: {quantile(factors, 0.5):.2g} times in the median, "
                         f"{max(factors):.2g} times at most")
    return ("Time of our world as a multiple of stock's, where both hold: " +
            ("; ".join(words) or "nowhere") + ". Against meshes stock's GImpact is the yardstick.")


def worlds_table(measured):
    rows = []
    for world in worlds_of(measured):
        for method in unique(r["method"] for r in runs_of(measured, world["name"])):
            runs = runs_of(measured, world["name"], method)
            held = [r for r in runs if is_in_hand(world, r)]
            drifts, depths = [r["drift"] for r in held], [r["depth"] for r in runs if "depth" in r]
            times = [r["realTime"] for r in runs if "realTime" in r]
            rows.append([world["title"], method] +
                        [sum(r["verdict"] == v for r in runs) or "" for v in LOOKS] +
                        [number(n) for n in (
                            quantile(drifts, 0.5), max(drifts, default=None),
                            quantile(depths, 0.5), max(depths, default=None),
                            quantile([r["maxKinetic"] for r in held], 0.5),
                            quantile(times, 0.5))] + [sum(r.get("impacts", 0) for r in runs) or ""])
    return page.table(["world", "method", *LOOKS, "drift, median [m]", "worst", "depth, median [m]",
                       "worst", "kinetic, median [J]", "s / s, median", "impacts"], rows)


def section_of(measured, folder):
    """HTML of the section; writes its pictures into the folder, too."""
    def picture(name, figure, tips=None):
        return tag("div", page.Html(save(figure, folder, f"simulation_{name}", tips)),
                   class_="figure")
    parts = []
    for (key, (title, *_)), say in zip(CHARTS.items(), (
            sentences_of_drift, sentences_of_depth, sentences_of_energy, sentences_of_time)):
        figure = draw_chart(measured, key)
        parts += [tag("h3", title), picture(PICTURES[key], figure) if figure else "",
                  tag("p", say(measured))]
    return page.section(
        measured,
        tag("p", f"{len(worlds_of(measured))} worlds of Bullet in {measured['precision']} "
                 f"precision, each with {len(measured['rates'])} time steps and "
                 f"{len(measured['iterations'])} numbers of iterations, every run in a process of "
                 "its own. Hands are multibodies with motors; one finger is held by its servo, the "
                 f"other presses. Slipped: more than {1e3 * measured['slip']:g} mm in the hand, "
                 f"dropped: more than {1e3 * measured['drop']:g} mm or gone, through: something "
                 "has passed through something else, exploded: faster than anything in the world "
                 "can make it, or twice the energy. Meshes are GImpact in stock Bullet and "
                 "btCcdMeshShape in ours."),
        tag("h3", "Outcomes"), picture("outcomes", *draw_outcomes(measured)),
        tag("p", sentences_of_outcomes(measured)), tag("p", sentences_of_meshes(measured)), *parts,
        tag("h3", "All worlds"), worlds_table(measured))
