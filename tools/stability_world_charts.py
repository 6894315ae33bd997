"""Hands that hold, squeeze, pinch and hit in simulations: charts, tables and what they show."""
from html import escape

from chart_points import unique
from chart_svg import origin_of
from stability_numbers import number, quantile, table
from stability_svg import (COLOURS, OUTCOMES, Axis, Panel, cross_sign, grid, legend, line_sign,
                           outcome_cell, outcome_sign, sheet, text)

OURS, STOCK = "ours, world", "stock"
LOWEST_DRIFT, LOWEST_DEPTH, LOWEST_ENERGY = 1e-9, 1e-7, 1e-15
# From best to worst.
RANKS = ["held", "slipped", "dropped", "through", "exploded", "timed out", "crashed"]
SHADES = {10: 0.35, 50: 0.65, 200: 1.0}


def runs_of(measured, world, method=None, rate=None, iterations=None):
    return [r for r in measured["runs"] if r["world"] == world and
            (method is None or r["method"] == method) and (rate is None or r["rate"] == rate) and
            (iterations is None or r["iterations"] == iterations)]


def worlds_of(measured):
    ran = unique(r["world"] for r in measured["runs"])
    return [w for w in measured["worlds"] if w["name"] in ran]


def describe_run(run):
    return (f"{run['world']}, {run['method']}, 1/{run['rate']} s, {run['iterations']} iterations: "
            f"{run['verdict']}; drift {number(run.get('drift'))} m, depth "
            f"{number(run.get('depth'))} m, {number(run.get('realTime'))} s a simulated second")


def outcome_picture(measured):
    """A row a world and method, a cell a time step and number of iterations."""
    rates, iterations = measured["rates"], measured["iterations"]
    cell, gap, left = 25, 10, 460
    width = left + len(rates) * (len(iterations) * cell + gap) + 20
    parts, y = [], 58
    for k, rate in enumerate(rates):
        x = left + k * (len(iterations) * cell + gap)
        parts.append(text(x, 22, f"1/{rate} s", 13, "start", 'font-weight="600"'))
        parts += [text(x + (i + 0.5) * cell, 42, str(n), 10.5, extra='class="soft"')
                  for i, n in enumerate(iterations)]
    parts.append(text(20, 42, "iterations of the solver", 11, "start", 'class="soft"'))
    for world in worlds_of(measured):
        methods = unique(r["method"] for r in runs_of(measured, world["name"]))
        parts.append(text(20, y + 12, world["title"], 12, "start", 'font-weight="600"'))
        y += 18
        for method in methods:
            parts.append(text(left - 12, y + 12, method, 12, "end"))
            for run in runs_of(measured, world["name"], method):
                x = (left + rates.index(run["rate"]) * (len(iterations) * cell + gap) +
                     iterations.index(run["iterations"]) * cell)
                parts.append(outcome_cell(x, y, cell, run["verdict"], describe_run(run)))
            y += 17
        y += 8
    seen = unique(r["verdict"] for r in measured["runs"])
    signs, more = legend([(outcome_sign(o), o) for o in OUTCOMES if o in seen], y, width)
    return sheet(width, y + more, "".join(parts) + signs, "Outcomes of simulated grasps")


def shown_iterations(measured):
    wanted = [n for n in measured["iterations"] if n in SHADES]
    return wanted or measured["iterations"]


def world_panels(measured, key, lowest, is_valid):
    """A panel a world: stock and ours over the time step, shades for iterations."""
    ticks = [(rate, str(rate)) for rate in measured["rates"]]
    worlds = [w for w in worlds_of(measured) if any(
        key in r and is_valid(w, r) for r in runs_of(measured, w["name"]))]
    values = [r[key] for w in worlds for r in runs_of(measured, w["name"])
              if key in r and is_valid(w, r)]
    axis = Axis(values, lowest=lowest)
    panels = []
    for world in worlds:
        title, _, surface = world["title"].rpartition(", ")
        panel = Panel(f"{surface}\n{title}", "steps a second", ticks, axis)
        for method in (STOCK, OURS):
            for iterations in shown_iterations(measured):
                points = []
                for rate in measured["rates"]:
                    for run in runs_of(measured, world["name"], method, rate, iterations):
                        valid = key in run and is_valid(world, run)
                        points.append((rate, run[key] if valid else None))
                panel.add(points, COLOURS[method], f"{method}, {iterations} iterations", "line",
                          SHADES.get(iterations, 0.7), -5 if method == STOCK else 5)
        panels.append(panel)
    return panels


def world_picture(measured, key, lowest, is_valid, name, lost):
    entries = [(line_sign(COLOURS[m], opacity=SHADES.get(n, 0.7)), f"{m}, {n} iterations")
               for m in (STOCK, OURS) for n in shown_iterations(measured)]
    panels = world_panels(measured, key, lowest, is_valid)
    return grid(panels, entries + [(cross_sign(), lost)], name) if panels else ""


def is_in_hand(world, run):
    return not world["passive"] and run["verdict"] in ("held", "slipped")


def is_finite(_, run):
    return run["verdict"] not in ("crashed", "timed out")


def drift_picture(measured):
    return world_picture(measured, "drift", LOWEST_DRIFT, is_in_hand,
                         "Drift of the object in the hand [m]", "no longer in the hand")


def depth_picture(measured):
    return world_picture(measured, "depth", LOWEST_DEPTH, is_finite,
                         "Deepest penetration [m]", "no answer")


def energy_picture(measured):
    return world_picture(measured, "maxKinetic", LOWEST_ENERGY, is_in_hand,
                         "Largest kinetic energy where rest is expected [J]",
                         "no longer in the hand")


def time_picture(measured):
    return world_picture(measured, "realTime", None, is_finite,
                         "Processor time of a simulated second [s]", "no answer")


def compared(measured):
    """(world, run of stock, run of ours) of every setting that both have."""
    stock = {(r["world"], r["rate"], r["iterations"]): r for r in measured["runs"]
             if r["method"] == STOCK}
    titles = {w["name"]: w for w in measured["worlds"]}
    return [(titles[r["world"]], stock[key], r) for r in measured["runs"] if r["method"] == OURS
            for key in [(r["world"], r["rate"], r["iterations"])] if key in stock]


def rank(run):
    return RANKS.index(run["verdict"])


def setting_of(run):
    return f"1/{run['rate']} s, {run['iterations']} iterations"


def sentences_of_outcomes(measured):
    pairs = compared(measured)
    better = [p for p in pairs if rank(p[2]) < rank(p[1])]
    worse = [p for p in pairs if rank(p[2]) > rank(p[1])]
    same = [p for p in pairs if p[2].get("drift") == p[1].get("drift") and
            p[2].get("depth") == p[1].get("depth") and rank(p[1]) == rank(p[2])]
    counts = {m: sum(r["verdict"] == "held" for r in measured["runs"] if r["method"] == m)
              for m in unique(r["method"] for r in measured["runs"])}
    of = {m: sum(r["method"] == m for r in measured["runs"]) for m in counts}
    words = ("Held (or, at the wall, stopped): " +
             ", ".join(f"{m} {counts[m]} of {of[m]}" for m in counts) +
             f". Setting by setting our world does better than stock Bullet in {len(better)} of "
             f"{len(pairs)}, worse in {len(worse)}, and the same to the last digit in {len(same)}: "
             "the contacts of Bullet's own shapes and the solver are Bullet's, and creep, slip and "
             "squeeze-out that come from too few iterations stay.")
    if worse:
        words += " Worse: " + "; ".join(
            f"{w['title']}, {setting_of(s)} (stock {s['verdict']}, ours {o['verdict']})"
            for w, s, o in worse[:12]) + (f"; and {len(worse) - 12} more" if len(worse) > 12
                                          else "") + "."
    through = [r for r in measured["runs"] if r["verdict"] == "through"]
    words += " Went through: " + (", ".join(
        f"{m} {sum(r['method'] == m for r in through)}" for m in of) or "nothing") + "."
    return words


def sentences_of_meshes(measured):
    """Ours with meshes beside stock Bullet with its own shapes, which users have as a choice."""
    stock = {(r["world"] + "_mesh", r["rate"], r["iterations"]): r for r in measured["runs"]
             if r["method"] == STOCK}
    titles = {w["name"]: w["title"].rpartition(", ")[0] for w in measured["worlds"]}
    pairs = [(stock[key], r) for r in measured["runs"] if r["method"] == OURS
             for key in [(r["world"], r["rate"], r["iterations"])] if key in stock]
    if not pairs:
        return ""
    worse = [titles[o["world"]] for s, o in pairs if rank(o) > rank(s)]
    words = (f"Meshes in our world beside Bullet's own shapes in stock Bullet: better in "
             f"{sum(rank(o) < rank(s) for s, o in pairs)} of {len(pairs)} settings, worse in "
             f"{len(worse)}")
    if worse:
        words += " (" + ", ".join(f"{title}: {worse.count(title)}" for title in unique(worse)) + ")"
    return (words + ". Both have the same solver, which with few iterations and unequal masses ends "
            "elsewhere for every order of the contacts: where a hold creeps, iterations help.")


def sentences_of_drift(measured):
    both = [(w, s, o) for w, s, o in compared(measured) if is_in_hand(w, s) and is_in_hand(w, o)]
    factors = [(o["drift"] / s["drift"], w, s, o) for w, s, o in both
               if s["drift"] > LOWEST_DRIFT or o["drift"] > LOWEST_DRIFT if s["drift"] > 0]
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
        is_in_hand(w, r) for m in (STOCK, OURS) for r in runs_of(measured, w["name"], m))]
    if lost:
        words += " Held in neither, and not drawn: " + "; ".join(lost) + "."
    return words


def sentences_of_depth(measured):
    words = []
    for surface in ("convex shapes", "meshes"):
        for method in (STOCK, OURS):
            depths = [(r["depth"], w, r) for w in worlds_of(measured)
                      if w["title"].endswith(surface)
                      for r in runs_of(measured, w["name"], method) if "depth" in r]
            if depths:
                worst = max(depths, key=lambda d: d[0])
                zero = sum(d[0] == 0 for d in depths)
                where = f"{worst[1]['title'].rpartition(', ')[0]}, {setting_of(worst[2])}"
                words.append(f"{surface}, {method}: none in {zero} of {len(depths)} runs" +
                             (f", deepest {number(1e3 * worst[0])} mm ({where})" if worst[0] > 0
                              else ""))
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
    livelier = sum(o["maxKinetic"] > 10 * s["maxKinetic"] and o["maxKinetic"] > 1e-9
                   for s, o in both)
    return ("Nothing drives the links that hit the wall, so energy can only fall; it grew by more "
            "than 0.1 % in: " + ", ".join(parts) + f". At rest in the hand ours has more than ten "
            f"times the kinetic energy of stock (and above 1 nJ) in {livelier} of {len(both)} "
            "settings in which both hold.")


def sentences_of_time(measured):
    words = []
    for surface in ("convex shapes", "meshes"):
        factors = [o["realTime"] / s["realTime"] for w, s, o in compared(measured)
                   if w["title"].endswith(surface) and s.get("realTime", 0) > 0 and
                   rank(s) <= 1 and rank(o) <= 1 and "realTime" in o]
        if factors:
            words.append(f"{surface}: {quantile(factors, 0.5):.2g} times in the median, "
                         f"{max(factors):.2g} times at most")
    return ("Time of our world as a multiple of stock's, where both hold: " +
            ("; ".join(words) or "nowhere") + ". Against meshes stock's GImpact is the yardstick.")


def simulation_table(measured):
    rows = []
    for world in worlds_of(measured):
        for method in unique(r["method"] for r in runs_of(measured, world["name"])):
            runs = runs_of(measured, world["name"], method)
            held = [r for r in runs if is_in_hand(world, r)]
            depths = [r["depth"] for r in runs if "depth" in r]
            rows.append([world["title"], method] +
                        [sum(r["verdict"] == v for r in runs) or "" for v in OUTCOMES] +
                        [number(quantile([r["drift"] for r in held], 0.5)),
                         number(max((r["drift"] for r in held), default=None)),
                         number(quantile(depths, 0.5)), number(max(depths, default=None)),
                         number(quantile([r["maxKinetic"] for r in held], 0.5)),
                         number(quantile([r["realTime"] for r in runs if "realTime" in r], 0.5)),
                         sum(r.get("impacts", 0) for r in runs) or ""])
    return table(["world", "method"] + list(OUTCOMES) +
                 ["drift, median [m]", "worst", "depth, median [m]", "worst",
                  "kinetic, median [J]", "s / s, median", "impacts"], rows)


def simulation_section(measured):
    intro = (f"{len(worlds_of(measured))} worlds of Bullet in {measured['precision']} precision, "
             f"each with {len(measured['rates'])} time steps and {len(measured['iterations'])} "
             f"numbers of iterations, every run in a process of its own. Hands are multibodies "
             f"with motors; one finger is held by its servo, the other presses. Slipped: more than "
             f"{1e3 * measured['slip']:g} mm in the hand, dropped: more than "
             f"{1e3 * measured['drop']:g} mm or gone, through: something has passed through "
             f"something else, exploded: faster than anything in the world can make it, or twice "
             f"the energy. Meshes are GImpact in stock Bullet and btCcdMeshShape in ours.")
    charts = [("Drift of the object in the hand [m]", drift_picture, sentences_of_drift),
              ("Deepest penetration at the ends of steps [m]", depth_picture, sentences_of_depth),
              ("Kinetic energy where rest is expected [J]", energy_picture, sentences_of_energy),
              ("Processor time of a simulated second [s]", time_picture, sentences_of_time)]
    body = "".join(f"<h3>{escape(title)}</h3>{draw(measured)}<p>{escape(say(measured))}</p>"
                   for title, draw, say in charts)
    return (f'<section class="family" id="simulation" data-family="simulation">'
            f'<h2>{escape(measured["title"])}</h2><p>{escape(intro)}</p>'
            f'<h3>Outcomes</h3>{outcome_picture(measured)}'
            f'<p>{escape(sentences_of_outcomes(measured))}</p>'
            f'<p>{escape(sentences_of_meshes(measured))}</p>{body}'
            f'<h3>All worlds</h3>{simulation_table(measured)}'
            f'<p class="soft origin">{escape(origin_of(measured))}</p></section>')
