"""Hands that hold, squeeze, pinch and hit in simulated worlds: outcomes, and how far what is held
drifts at what cost."""
from plot import page
from plot.page import tag
from plot.pictures import HUES, INK, SOFT, Figure, cell_samples, draw_cells, foot, save
from plot.words import number, unique

# From best to worst: letter, colour of the cell, colour of the letter; told apart without colours.
LOOKS = {"held": ("H", "#9ec9f5", INK), "slipped": ("S", "#f3e08a", INK),
         "dropped": ("D", "#f2a65e", INK), "through": ("T", "#e5636f", INK),
         "exploded": ("X", "#b07cc6", INK), "timed out": ("O", "#9aa1a9", INK),
         "crashed": ("C", "#9aa1a9", INK)}


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


def draw_drift(measured):
    """Drift against the time of a step, a mark per run of a world that must hold."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.add_subplot(xlabel="processor time of a step [µs]", xscale="log", yscale="log",
                              ylabel="drift in the hand [mm]")
    worlds = {w["name"] for w in measured["worlds"] if not w["passive"] and w["group"] != "thin"}
    methods = unique(r["method"] for r in measured["runs"])
    for method, colour in zip(methods, [h for k in ("bullet", "sampled", "ours") for h in HUES[k]]):
        runs = [r for r in measured["runs"] if r["method"] == method and r["world"] in worlds
                and r.get("realTime")]
        axes.plot([1e6 * r["realTime"] / r["rate"] for r in runs],
                  [1e3 if LOOKS[r["verdict"]][0] in "XOC" else max(1e3 * r["drift"], 1e-7)
                   for r in runs], ".", color=colour, label=method)
    for axis in axes.xaxis, axes.yaxis:
        axis.set(major_formatter=lambda value, _: number(value), minor_formatter="")
    axes.axhline(0.1, color=INK, linewidth=0.8)
    axes.legend(fontsize=8)
    return figure


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
        outcomes_table(measured), tag("h3", "Drift against the time of a step"),
        tag("p", "The line is 0.1 mm; what exploded is at 1 m. The holding solver is of trials."),
        tag("div", page.Html(save(draw_drift(measured), folder, "simulation_drift")),
            class_="figure"))
