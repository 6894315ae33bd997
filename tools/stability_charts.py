"""The stability of grasps and of simulated hands as a section of a page and as pictures.

    section(measured)   HTML <section> of one family, "grasps" or "simulation", as the programs
                        stability_grasps and stability_simulation write it
    pictures(measured)  {name: SVG} of the same charts, each a file of its own

What the text says of a chart is computed from the data, where ours is worse, too.
"""
import math
from html import escape

from chart_points import unique
from chart_svg import origin_of
from stability_svg import (COLOURS, OUTCOMES, Axis, Panel, cross_sign, grid, legend, line_sign,
                           outcome_cell, outcome_sign, sheet, text)

OURS, STOCK = "ours, world", "stock"
LOWEST_ANGLE, LOWEST_RATIO, LOWEST_LENGTH, LOWEST_EPSILON = 1e-7, 1.0, 1e-8, 1e-7
LOWEST_DRIFT, LOWEST_DEPTH, LOWEST_ENERGY = 1e-9, 1e-7, 1e-15
# From best to worst.
RANKS = ["held", "slipped", "dropped", "through", "exploded", "timed out", "crashed"]
SHADES = {10: 0.35, 50: 0.65, 200: 1.0}


def quantile(values, share):
    """The value that this share of all is not above; None for none."""
    if not values:
        return None
    ordered = sorted(values)
    return ordered[math.ceil(share * (len(ordered) - 1) - 1e-9)]


def number(value, digits=2):
    """With so many digits that count: 110, 0.018, 2e-5."""
    if value is None:
        return "–"
    return f"{float(f'{value:.{digits}g}'):g}".replace("e-0", "e-").replace("e+0", "e")


def percent(part, whole):
    return "–" if not whole else f"{100 * part / whole:.0f} %"


def table(head, rows):
    cells = "".join(f"<th>{escape(h)}</th>" for h in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(str(c))}</td>" for c in row) + "</tr>"
                   for row in rows)
    return (f'<div class="wide tall"><table><thead><tr>{cells}</tr></thead>'
            f'<tbody>{body}</tbody></table></div>')


# ---- grasps: errors of the pose -------------------------------------------------------------


def pooled(rows, key):
    return [value for row in rows for value in row[key]]


def noise_rows(measured, method, noise, hand=None):
    """Of grasps that are force closures where there is no error."""
    return [r for r in measured["noise"] if r["method"] == method and r["noise"] == noise and
            r["before"]["success"] and (hand is None or r["hand"] == hand)]


def share_of(rows, key):
    draws = sum(r["draws"] for r in rows)
    return sum(r[key] for r in rows) / draws if draws else None


def amplification(rows):
    """|dq| / error of the draws in which the same links are in contact, [rad / m and rad]."""
    return [value / row["noise"] for row in rows for value in row["quietPosture"]]


def floor_for(lines, lowest):
    """The lowest value of an axis, if there is anything that it cannot show."""
    return lowest if any(y is not None and y < lowest for points in lines.values()
                         for _, y in points) else None


def quantile_panel(title, x_label, ticks, lines, lowest):
    """Medians and 95 % of methods; lines {(method, share): points}; ours drawn last, on top."""
    axis = Axis([y for points in lines.values() for _, y in points],
                lowest=floor_for(lines, lowest))
    panel = Panel(title, x_label, ticks, axis)
    for (method, share), points in reversed(lines.items()):
        kind, words = ("line", "median") if share == 0.5 else ("line upper", "95 %")
        panel.add([p for p in points if p[1] is not None], COLOURS[method],
                  f"{method}, {words}", kind)
    return panel


def share_panel(title, x_label, ticks, lines):
    panel = Panel(title, x_label, ticks, Axis([], is_share=True))
    for method, points in reversed(lines.items()):
        panel.add([p for p in points if p[1] is not None], COLOURS[method], method)
    return panel


def noise_panels(measured):
    noises, methods = measured["noises"], measured["methods"]
    ticks = [(noise, f"1e{round(math.log10(noise))}") for noise in noises]
    label = "error of the pose [m and rad]"
    values = {"posture": lambda rows: pooled(rows, "posture"), "ratio": amplification,
              "epsilon": lambda rows: pooled(rows, "epsilon"),
              "shift": lambda rows: pooled(rows, "shift")}
    kinds = [("posture", "change of the posture [rad]", LOWEST_ANGLE),
             ("ratio", "posture / error, same links [rad a metre]", LOWEST_RATIO),
             ("shift", "shift of contact points [m]", LOWEST_LENGTH),
             ("epsilon", "change of epsilon", LOWEST_EPSILON)]
    panels = []
    for key, title, lowest in kinds:
        lines = {(m, share): [(n, quantile(values[key](noise_rows(measured, m, n)), share))
                              for n in noises] for m in methods for share in (0.5, 0.95)}
        panels.append(quantile_panel(title, label, ticks, lines, lowest))
    for key, title in (("sameLinks", "the same links in contact"),
                       ("success", "still a force closure, no penetration")):
        lines = {m: [(n, share_of(noise_rows(measured, m, n), key)) for n in noises]
                 for m in methods}
        panels.append(share_panel(title, label, ticks, lines))
    return panels


def method_entries(methods, has_quantiles=True):
    entries = [(line_sign(COLOURS[m]), m) for m in methods]
    if has_quantiles:
        entries += [(line_sign("var(--soft)"), "median"),
                    (line_sign("var(--soft)", "line upper"), "95 % of the draws are below")]
    return entries


def noise_picture(measured):
    return grid(noise_panels(measured), method_entries(measured["methods"]),
                "Changes of grasps by errors of the pose")


def noise_table(measured):
    rows = []
    for method in measured["methods"]:
        for noise in measured["noises"]:
            own = noise_rows(measured, method, noise)
            gains = amplification(own)
            posture, epsilon = pooled(own, "posture"), pooled(own, "epsilon")
            draws = sum(r["draws"] for r in own)
            rows.append([method, number(noise), draws, number(quantile(posture, 0.5)),
                         number(quantile(posture, 0.95)), number(quantile(gains, 0.5)),
                         number(quantile(gains, 0.95)), number(max(gains, default=None)),
                         number(quantile(epsilon, 0.5)),
                         number(quantile(epsilon, 0.95)),
                         percent(sum(r["sameLinks"] for r in own), draws),
                         percent(sum(r["success"] for r in own), draws)])
    return table(["method", "error", "draws", "posture, median [rad]", "95 %",
                  "posture / error, median", "95 %", "largest", "epsilon, median", "95 %", "same links",
                  "success"], rows)


def hand_table(measured):
    """By hand: what is left at the largest error."""
    noise = max(measured["noises"])
    rows = []
    for hand in unique(r["hand"] for r in measured["noise"]):
        row = [hand]
        for method in measured["methods"]:
            own = noise_rows(measured, method, noise, hand)
            draws = sum(r["draws"] for r in own)
            row.append(f"{percent(sum(r['success'] for r in own), draws)} of {draws}")
        rows.append(row)
    return table(["hand"] + [f"success, {m}" for m in measured["methods"]], rows)


def ratios_of(measured, method):
    """Medians, 95 % and largest of posture / error, one a size of the error."""
    found = [amplification(noise_rows(measured, method, n)) for n in measured["noises"]]
    return [(quantile(g, 0.5), quantile(g, 0.95), max(g)) for g in found if g]


def proportion_of(measured, method):
    ratios = ratios_of(measured, method)
    medians = ", ".join(number(r[0]) for r in ratios)
    return (f"{medians} rad a metre in the median, {', '.join(number(r[1]) for r in ratios)} at "
            f"95 %, {number(max((r[2] for r in ratios), default=None))} at most")


def sentences_of_noise(measured):
    """What the chart shows, the bad with the good."""
    ours, stepping = "ours", "stepping, GraspIt! steps"
    sizes = ", ".join(number(n) for n in measured["noises"])
    return (f"While the same links stay in contact, the posture moves, for errors of {sizes}, by "
            f"{proportion_of(measured, ours)} with ours; by {proportion_of(measured, stepping)} "
            f"with stepping. Geometry asks for about 1 / length of a phalanx, 10 to 40 rad a metre "
            f"(more where a link grazes): a method that follows it has the same ratio at every "
            f"size. 0 means that the gap in which a bisection may end hides the error, large "
            f"ratios that it ended elsewhere.")


def sentences_of_loss(measured):
    """Where ours degrades or is no better."""
    ours, stepping = "ours", "stepping, GraspIt! steps"
    large = max(measured["noises"])
    parts = []
    for method in (ours, stepping):
        own = [r for r in measured["noise"] if r["method"] == method and r["noise"] == large and
               r["planned"] == "force closure"]
        parts.append(f"{method} {sum(r['before']['success'] for r in own)} of {len(own)}")
    words = "Planned force closures that are reproduced without an error: " + ", ".join(parts) + "."
    shares = {m: share_of(noise_rows(measured, m, large), "success") for m in measured["methods"]}
    kept = ", ".join(f"{m} {100 * s:.0f} %" for m, s in shares.items() if s is not None)
    words += (f" Where ours degrades: at {number(large)} m and rad grasps are lost, whoever closes them "
              f"(kept: {kept}); an exact closing follows the error into other contacts, too.")
    if shares.get(ours) is not None and shares.get(stepping) is not None:
        if shares[ours] < shares[stepping]:
            words += (" Ours keeps fewer than stepping, whose contacts may be twice as far from "
                      "the object (0.2 mm) and so are more.")
    hands = [(share_of(noise_rows(measured, ours, large, h), "success"), h)
             for h in unique(r["hand"] for r in measured["noise"])]
    hands = sorted((s, h) for s, h in hands if s is not None)
    if hands and hands[0][0] < 0.5:
        words += (" Fewest are kept with " +
                  ", ".join(f"{h} ({100 * s:.0f} %)" for s, h in hands if s < 0.5) +
                  ". (Of a gripper with one motor the jaw that touches first stops both, and a "
                  "closing at a given pose does not centre the jaws as the planner does.)")
    medians = [quantile(pooled(noise_rows(measured, m, large), "epsilon"), 0.5)
               for m in (ours, stepping)]
    if None not in medians:
        words += (f" Epsilon changes by {number(medians[0])} in the median with ours, "
                  f"{number(medians[1])} with stepping.")
    return words


def sentences_of_others(measured):
    """Grasps that are no force closures."""
    found = []
    for method in measured["methods"]:
        rows = [r for r in measured["noise"]
                if r["method"] == method and not r["before"]["success"]]
        gained = sum(r["success"] for r in rows)
        found.append(f"{method}: {gained} of {sum(r['draws'] for r in rows)}")
    return ("Closings that are no force closures without an error become one with it: " +
            ", ".join(found) + " draws of all sizes.")


# ---- grasps: meshes ---------------------------------------------------------------------------


SIZES = (1000, 4000, 16000)


def size_of(row):
    """The nominal number of triangles."""
    return min(SIZES, key=lambda size: abs(math.log(row["triangles"] / size)))


def mesh_rows(measured, method, size):
    """Of starts that give a force closure on the finest mesh."""
    good = {(r["hand"], r["object"], r["grasp"]) for r in measured["meshes"]
            if r["finest"] and r["method"] == method and r["success"]}
    return [r for r in measured["meshes"] if r["method"] == method and size_of(r) == size and
            (r["hand"], r["object"], r["grasp"]) in good]


def mesh_panels(measured):
    ticks = [(size, f"{size // 1000}K") for size in SIZES]
    label, methods = "triangles of the object", measured["methods"]
    panels = []
    for key, title, lowest in (("posture", "posture, from the finest mesh [rad]", LOWEST_ANGLE),
                               ("epsilon", "epsilon, from the finest mesh", LOWEST_EPSILON)):
        lines = {(m, share): [(size, quantile([r[key] for r in mesh_rows(measured, m, size)
                                               if r["closed"]], share)) for size in SIZES[:-1]]
                 for m in methods for share in (0.5, 0.95)}
        panels.append(quantile_panel(title, label, ticks, lines, lowest))
    for key, title in (("sameLinks", "the links of the finest mesh in contact"),
                       ("success", "a force closure here, too")):
        lines = {}
        for method in methods:
            rows = {size: mesh_rows(measured, method, size) for size in SIZES}
            lines[method] = [(size, sum(r[key] for r in own) / len(own))
                             for size, own in rows.items() if own]
        panels.append(share_panel(title, label, ticks, lines))
    return panels


def mesh_picture(measured):
    return grid(mesh_panels(measured), method_entries(measured["methods"]),
                "Grasps on meshes of 1K, 4K and 16K triangles")


def mesh_table(measured):
    rows = []
    for method in measured["methods"]:
        for size in SIZES:
            own = mesh_rows(measured, method, size)
            closed = [r for r in own if r["closed"]]
            contacts = [r["contacts"] for r in closed]
            rows.append([method, f"{size // 1000}K", len(own),
                         number(sum(contacts) / len(contacts) if contacts else None, 3),
                         number(quantile([r["posture"] for r in closed], 0.5)),
                         number(quantile([r["posture"] for r in closed], 0.95)),
                         number(quantile([r["epsilon"] for r in closed], 0.5)),
                         number(quantile([r["epsilon"] for r in closed], 0.95)),
                         percent(sum(r["sameLinks"] for r in own), len(own)),
                         percent(sum(r["success"] for r in own), len(own))])
    return table(["method", "triangles", "grasps", "contacts, mean", "posture, median [rad]",
                  "95 %", "epsilon, median", "95 %", "same links", "success"], rows)


def sentences_of_meshes(measured):
    parts = []
    for method in ("ours", "stepping, GraspIt! steps"):
        coarse, middle = (mesh_rows(measured, method, size) for size in SIZES[:2])
        medians = [quantile([r["posture"] for r in rows if r["closed"]], 0.5)
                   for rows in (coarse, middle)]
        parts.append(
            f"{method}: the posture on 1K triangles is {number(medians[0])} rad from that on 16K in "
            f"the median, on 4K {number(medians[1])} rad; "
            f"{percent(sum(r['success'] for r in coarse), len(coarse))} and "
            f"{percent(sum(r['success'] for r in middle), len(middle))} of the force closures "
            f"are kept.")
    parts.append("Faceting itself moves the surface by up to "
                 "radius × (π / segments)² / 2: what both methods share is the mesh's.")
    return " ".join(parts)


def grasps_section(measured):
    pairs = measured["pairs"]
    hands = len(unique(p["hand"] for p in pairs))
    objects = len(unique(p["object"] for p in pairs))
    intro = (f"{hands} hands, {objects} objects, {sum(p['grasps'] for p in pairs)} grasps of the "
             f"planner ({sum(p['closures'] for p in pairs)} of them force closures), each repeated "
             f"{measured['draws']} times with every size of error: a shift and a turn of exactly "
             f"that size in directions drawn from seed {measured['seed']}, the same for all "
             f"methods. Every method makes its own approach and closing and is compared with itself "
             f"without the error. Success is epsilon ≥ 0.005 and no penetration by the "
             f"independent check.")
    return (f'<section class="family" id="grasps" data-family="grasps">'
            f'<h2>{escape(measured["title"])}</h2><p>{escape(intro)}</p>'
            f'<h3>Errors of the pose</h3>{noise_picture(measured)}'
            f'<p>{escape(sentences_of_noise(measured))}</p>'
            f'<p>{escape(sentences_of_loss(measured))} '
            f'{escape(sentences_of_others(measured))}</p>'
            f'{noise_table(measured)}<p>At the largest error, hand by hand:</p>'
            f'{hand_table(measured)}'
            f'<h3>Meshes of 1K, 4K and 16K triangles</h3>{mesh_picture(measured)}'
            f'<p>{escape(sentences_of_meshes(measured))}</p>{mesh_table(measured)}'
            f'<p class="soft origin">{escape(origin_of(measured))}</p></section>')


# ---- simulation -------------------------------------------------------------------------------


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
            f'<p>{escape(sentences_of_outcomes(measured))}</p>{body}'
            f'<h3>All worlds</h3>{simulation_table(measured)}'
            f'<p class="soft origin">{escape(origin_of(measured))}</p></section>')


def section(measured):
    """HTML of a family; raises KeyError for one that is not known."""
    return {"grasps": grasps_section, "simulation": simulation_section}[measured["family"]](
        measured)


def pictures(measured):
    """SVG documents by name, of a family."""
    draws = {"grasps": {"grasps_noise": noise_picture, "grasps_meshes": mesh_picture},
             "simulation": {"simulation_outcomes": outcome_picture,
                            "simulation_drift": drift_picture,
                            "simulation_depth": depth_picture,
                            "simulation_energy": energy_picture,
                            "simulation_time": time_picture}}[measured["family"]]
    drawn = {name: draw(measured) for name, draw in draws.items()}
    return {name: picture for name, picture in drawn.items() if picture}
