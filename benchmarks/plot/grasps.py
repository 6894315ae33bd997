"""How grasps change with errors of the pose and with meshes: charts and tables."""
import math
from collections import defaultdict

from plot import page
from plot.page import tag
from plot.pictures import HUES, SOFT, draw_lines, foot, panels, sample, save
from plot.words import number, percent, power, quantile, unique

COLOURS = {"ours": HUES["ours"][0], "ours, tolerance 0.1 µm": HUES["ours"][1],
           "stepping, GraspIt! steps": HUES["sampled"][0],
          "stepping, steps / 10": HUES["sampled"][1]}
SIZES = (1000, 4000, 16000)
# Quantity: what it is, lowest value that is drawn.
NOISE = {"posture": ("change of the posture [rad]", 1e-7),
         "ratio": ("posture / error, same links [rad per metre]", 1.0),
         "shift": ("shift of contact points [m]", 1e-8), "epsilon": ("change of epsilon", 1e-7)}
NOISE_SHARES = {"sameLinks": "the same links in contact",
                "success": "still a force closure, no penetration"}
MESHES = {"posture": ("posture, from the finest mesh [rad]", 1e-7),
          "epsilon": ("epsilon, from the finest mesh", 1e-7)}
MESH_SHARES = {"sameLinks": "the links of the finest mesh in contact",
               "success": "a force closure here, too"}


def noise_groups(measured):
    """{(method, error): rows} of grasps that are force closures without an error. A row counts
    draws and has lists of values; the ratio is |dq| / error where the same links are in contact."""
    groups = defaultdict(list)
    for row in measured["noise"]:
        if row["before"]["success"]:
            groups[row["method"], row["noise"]].append(
                row | {"ratio": [value / row["noise"] for value in row["quietPosture"]]})
    return groups


def mesh_groups(measured):
    """The same by nominal number of triangles, of starts that give a force closure on the finest
    mesh; one draw each."""
    def start(row):
        return [row[key] for key in ("method", "hand", "object", "grasp")]
    good = [start(r) for r in measured["meshes"] if r["finest"] and r["success"]]
    groups = defaultdict(list)
    for row in measured["meshes"]:
        if start(row) in good:
            size = min(SIZES, key=lambda size: abs(math.log(row["triangles"] / size)))
            values = {key: [row[key]] if row["closed"] and not (key in MESHES and row["finest"])
                      else [] for key in ("posture", "epsilon", "contacts")}
            groups[row["method"], size].append(row | {"draws": 1} | values)
    return groups


def values_of(rows, key):
    return [value for row in rows for value in row[key]]


def sums_of(rows, key):
    """How many draws, of all."""
    return sum(r[key] for r in rows), sum(r["draws"] for r in rows)


def share_of(rows, key):
    part, whole = sums_of(rows, key)
    return part / whole if whole else None


def draw(groups, methods, label, ticks, quantities, shares):
    """Medians and 95 % of quantities, and shares, over the ticks; ours is drawn last, on top."""
    figure, axes = panels(len(quantities) + len(shares))
    solid, dashed = {"marker": "o", "markersize": 4}, {"linestyle": "--", "linewidth": 1.1}
    for one, (key, (title, lowest)) in zip(axes, quantities.items()):
        lines = [([(x, quantile(values_of(groups[method, x], key), share)) for x in ticks
                   if values_of(groups[method, x], key)], {"color": COLOURS[method], **looks})
                 for method in reversed(methods) for share, looks in ((0.5, solid), (0.95, dashed))]
        draw_lines(one, title, ticks, lines, lowest)
    for one, (key, title) in zip(axes[len(quantities):], shares.items()):
        lines = [([(x, share_of(groups[method, x], key)) for x in ticks if groups[method, x]],
                  {"color": COLOURS[method], **solid}) for method in reversed(methods)]
        draw_lines(one, title, ticks, lines, is_share=True)
    for one in axes:
        one.set_xlabel(label)
    foot(figure, [sample(m, color=COLOURS[m], **solid) for m in methods] +
         [sample("median", color=SOFT, **solid),
          sample("95 % of the draws are below", color=SOFT, **dashed)], 3)
    return figure


def table_of(groups, label, ticks, quantities):
    rows = [[method, words, sum(r["draws"] for r in groups[method, x])] +
            [number(n) for key in quantities for n in spread(values_of(groups[method, x], key))] +
            [percent(*sums_of(groups[method, x], key)) for key in ("sameLinks", "success")]
            for method in unique(m for m, _ in groups) for x, words in ticks.items()]
    return page.table(["method", label, "draws"] +
                      [words for title in quantities.values()
                       for words in (f"{title}, median", "95 %", "largest")] +
                      ["same links", "success"], rows)


def spread(values):
    return quantile(values, 0.5), quantile(values, 0.95), max(values, default=None)


def hand_table(measured):
    """By hand: what is left at the largest error."""
    groups, rows = noise_groups(measured), []
    for hand in unique(r["hand"] for r in measured["noise"]):
        kept = [sums_of([r for r in groups[method, max(measured["noises"])] if r["hand"] == hand],
                        "success") for method in measured["methods"]]
        rows.append([hand] + [f"{percent(*k)} of {k[1]}" for k in kept])
    return page.table(["hand"] + [f"success, {m}" for m in measured["methods"]], rows)


def loss_table(measured):
    """What closings give that are to repeat a force closure, and that are none without an error."""
    rows = []
    for method in measured["methods"]:
        own = [r for r in measured["noise"] if r["method"] == method]
        planned = [r for r in own if r["planned"] == "force closure" and
                   r["noise"] == max(measured["noises"])]
        others = [r for r in own if not r["before"]["success"]]
        rows.append([method, f"{sum(r['before']['success'] for r in planned)} of {len(planned)}",
                     "{} of {}".format(*sums_of(others, "success"))])
    return page.table(["method", "planned force closures that it repeats without an error",
                       "draws in which an error makes a force closure of none"], rows)


def section_of(measured, folder, _=()):
    """HTML of the section; writes its pictures into the folder, too."""
    pairs, methods = measured["pairs"], measured["methods"]
    noise, meshes = noise_groups(measured), mesh_groups(measured)
    errors = {n: power(n) for n in measured["noises"]}
    sizes = {size: f"{size // 1000}K" for size in SIZES}
    def picture(name, *what):
        return tag("div", page.Html(save(draw(*what), folder, f"grasps_{name}")), class_="figure")
    return page.section(
        measured,
        tag("p", f"{len(unique(p['hand'] for p in pairs))} hands, "
                 f"{len(unique(p['object'] for p in pairs))} objects, "
                 f"{sum(p['grasps'] for p in pairs)} grasps of the planner "
                 f"({sum(p['closures'] for p in pairs)} of them force closures), each repeated "
                 f"{measured['draws']} times with every size of error: a shift and a turn of that "
                 f"size in directions drawn from seed {measured['seed']}, the same for all. "
                 "Every method makes its own approach and closing and is compared with itself "
                 "without the error. Success is epsilon ≥ 0.005 and no penetration by the "
                 "independent check."),
        tag("h3", "Errors of the pose"),
        picture("noise", noise, methods, "error of the pose [m and rad]", errors, NOISE,
                NOISE_SHARES),
        tag("p", "While the same links stay in contact, geometry asks for about 1 / length of a "
                 "phalanx, 10 to 40 rad per metre, more where a link grazes: a method that follows "
                 "it has the same ratio at every size. 0 means that the gap in which a bisection "
                 "may end hides the error, large ratios that it ended elsewhere."),
        table_of(noise, "error", errors, {"posture": "posture [rad]", "ratio": "posture / error",
                                          "epsilon": "epsilon"}),
        tag("p", "At the largest error, hand by hand:"), hand_table(measured),
        loss_table(measured),
        tag("h3", "Meshes of 1K, 4K and 16K triangles"),
        picture("meshes", meshes, methods, "triangles of the object", sizes, MESHES, MESH_SHARES),
        tag("p", "Faceting moves the surface by up to radius × (π / segments)² / 2."),
        table_of(meshes, "triangles", sizes, {"contacts": "contacts", "posture": "posture [rad]",
                                              "epsilon": "epsilon"}))
