"""How grasps change with errors of the pose and with meshes: charts, tables and what they show. The
text is computed from the data, where ours is worse, too."""
import math
from collections import defaultdict

from plot import page
from plot.page import tag
from plot.pictures import HUES, SOFT, draw_lines, foot, panels, sample, save
from plot.words import number, percent, power, quantile, unique

OURS, STEPPING = "ours", "stepping, GraspIt! steps"
COLOURS = {OURS: HUES["ours"][0], "ours, tolerance 0.1 µm": HUES["ours"][1],
           STEPPING: HUES["sampled"][0], "stepping, steps / 10": HUES["sampled"][1]}
SIZES = (1000, 4000, 16000)
# Quantity: what it is, lowest value that is drawn.
NOISE = {"posture": ("change of the posture [rad]", 1e-7),
         "ratio": ("posture / error, same links [rad a metre]", 1.0),
         "shift": ("shift of contact points [m]", 1e-8), "epsilon": ("change of epsilon", 1e-7)}
NOISE_SHARES = {"sameLinks": "the same links in contact",
                "success": "still a force closure, no penetration"}
MESHES = {"posture": ("posture, from the finest mesh [rad]", 1e-7),
          "epsilon": ("epsilon, from the finest mesh", 1e-7)}
MESH_SHARES = {"sameLinks": "the links of the finest mesh in contact",
               "success": "a force closure here, too"}


def noise_groups(measured):
    """{(method, error): rows} of grasps that are force closures where there is no error. A row counts
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


def proportion_of(groups, noises, method):
    found = [spread(values_of(groups[method, n], "ratio")) for n in noises if groups[method, n]]
    medians, upper, largest = zip(*found) if found else ((), (), ())
    return (f"{', '.join(map(number, medians))} rad a metre in the median, "
            f"{', '.join(map(number, upper))} at 95 %, {number(max(largest, default=None))} at most")


def sentences_of_noise(measured):
    """What the chart shows, the bad with the good."""
    groups, noises = noise_groups(measured), measured["noises"]
    return (f"While the same links stay in contact, the posture moves, for errors of {', '.join(map(number, noises))}, by "
            f"{proportion_of(groups, noises, OURS)} with ours; by {proportion_of(groups, noises, STEPPING)} "
            f"with stepping. Geometry asks for about 1 / length of a phalanx, 10 to 40 rad a metre "
            f"(more where a link grazes): a method that follows it has the same ratio at every "
            f"size. 0 means that the gap in which a bisection may end hides the error, large "
            f"ratios that it ended elsewhere.")


def sentences_of_loss(measured):
    """Where ours degrades or is no better."""
    groups, large, parts = noise_groups(measured), max(measured["noises"]), []
    for method in (OURS, STEPPING):
        own = [r for r in measured["noise"] if r["method"] == method and r["noise"] == large and
               r["planned"] == "force closure"]
        parts.append(f"{method} {sum(r['before']['success'] for r in own)} of {len(own)}")
    words = "Planned force closures that are reproduced without an error: " + ", ".join(parts) + "."
    shares = {m: share_of(groups[m, large], "success") for m in measured["methods"]}
    kept = ", ".join(f"{m} {100 * s:.0f} %" for m, s in shares.items() if s is not None)
    words += (f" Where ours degrades: at {number(large)} m and rad grasps are lost, whoever closes "
              f"them (kept: {kept}); an exact closing follows the error into other contacts, too.")
    if None not in (shares.get(OURS), shares.get(STEPPING)) and shares[OURS] < shares[STEPPING]:
        words += (" Ours keeps fewer than stepping, whose contacts may be twice as far from the "
                  "object (0.2 mm) and so are more.")
    hands = [(share_of([r for r in groups[OURS, large] if r["hand"] == h], "success"), h)
             for h in unique(r["hand"] for r in measured["noise"])]
    few = sorted((s, h) for s, h in hands if s is not None and s < 0.5)
    if few:
        words += (" Fewest are kept with " + ", ".join(f"{h} ({100 * s:.0f} %)" for s, h in few) +
                  ". (Of a gripper with one motor the jaw that touches first stops both, and a "
                  "closing at a given pose does not centre the jaws as the planner does.)")
    medians = [quantile(values_of(groups[m, large], "epsilon"), 0.5)
               for m in (OURS, STEPPING)]
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
        found.append("{}: {} of {}".format(method, *sums_of(rows, "success")))
    return (" Closings that are no force closures without an error become one with it: " +
            ", ".join(found) + " draws of all sizes.")


def sentences_of_meshes(measured):
    groups, parts = mesh_groups(measured), []
    for method in (OURS, STEPPING):
        rows = [groups[method, size] for size in SIZES[:2]]
        medians = [number(quantile(values_of(own, "posture"), 0.5)) for own in rows]
        kept = [percent(*sums_of(own, "success")) for own in rows]
        parts.append(f"{method}: the posture on 1K triangles is {medians[0]} rad from that on 16K "
                     f"in the median, on 4K {medians[1]} rad; {kept[0]} and {kept[1]} of the force "
                     f"closures are kept.")
    return " ".join(parts + ["Faceting itself moves the surface by up to radius × (π / segments)² "
                             "/ 2: what both methods share is the mesh's."])


def section_of(measured, folder):
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
                 f"{measured['draws']} times with every size of error: a shift and a turn of exactly "
                 f"that size in directions drawn from seed {measured['seed']}, the same for all "
                 "methods. Every method makes its own approach and closing and is compared with "
                 "itself without the error. Success is epsilon ≥ 0.005 and no penetration by the "
                 "independent check."),
        tag("h3", "Errors of the pose"),
        picture("noise", noise, methods, "error of the pose [m and rad]", errors, NOISE,
                NOISE_SHARES),
        tag("p", sentences_of_noise(measured)),
        tag("p", sentences_of_loss(measured), sentences_of_others(measured)),
        table_of(noise, "error", errors, {"posture": "posture [rad]", "ratio": "posture / error",
                                          "epsilon": "epsilon"}),
        tag("p", "At the largest error, hand by hand:"), hand_table(measured),
        tag("h3", "Meshes of 1K, 4K and 16K triangles"),
        picture("meshes", meshes, methods, "triangles of the object", sizes, MESHES, MESH_SHARES),
        tag("p", sentences_of_meshes(measured)),
        table_of(meshes, "triangles", sizes, {"contacts": "contacts", "posture": "posture [rad]",
                                              "epsilon": "epsilon"}))
