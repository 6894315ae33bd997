"""How grasps change with errors of the pose and with meshes: charts, tables and what they show."""
import math
from html import escape

from chart_points import unique
from chart_svg import origin_of
from stability_numbers import number, percent, quantile, table
from stability_svg import COLOURS, Axis, Panel, grid, line_sign

LOWEST_ANGLE, LOWEST_RATIO, LOWEST_LENGTH, LOWEST_EPSILON = 1e-7, 1.0, 1e-8, 1e-7


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
