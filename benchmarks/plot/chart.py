"""Time against accuracy: a panel per scene, a mark per method, and which setting to take."""
import math

import numpy

from plot import page
from plot.page import tag
from plot.pictures import (HUES, INK, PAPER, SOFT, Figure, decades, foot, head, sample, save,
                           svg)
from plot.points import (BEST_ERROR, choices, error_of, flaws_of, front, is_right, scenes_of,
                         strictest)
from plot.words import duration, origin_of, power, unique

COLUMNS = 3
MARKS = "os^DvPp<>"
SIGNS = dict(zip(MARKS, "●■▲◆▼✚⬟◀▶"))


def owner_of(method):
    if "FCL" in method:
        return "fcl"
    if "Bullet" in method:
        return "bullet"
    return "sampled" if "sampling" in method or "stepping" in method else "ours"


def looks_of(measured):
    """Colour and mark of every method, the same in all scenes."""
    looks, used = {}, {}
    for method in unique(p["method"] for p in measured["points"]):
        hues = HUES[owner_of(method)]
        number = used[owner_of(method)] = used.get(owner_of(method), -1) + 1
        # Marks go on over the owners, so that no two methods share one before all are used.
        looks[method] = (hues[number % len(hues)], MARKS[len(looks) % len(MARKS)])
    return looks


class Ranges:
    """Axes of the family, the same in all scenes; at the right is the place of those that found
    nothing at all."""

    def __init__(self, measured):
        points = measured["points"]
        self.errors = decades([error_of(p) for p in points if p["found"] > 0] or [BEST_ERROR, 1.0])
        self.times = decades([max(p["meanMicroseconds"], 1e-3) for p in points])
        self.none = 10.0 ** (self.errors[-1] + 1.6)
        self.has_none = any(p["found"] == 0 for p in points)

    def place_of(self, point):
        return error_of(point) or self.none, max(point["meanMicroseconds"], 1e-3)

    def apply(self, axes):
        step = math.ceil(len(self.errors) / 8)
        ticks = [10.0 ** exponent for exponent in self.errors[::-step]]
        axes.set(xscale="log", yscale="log", ylim=(10.0 ** (self.times[0] - 0.1),
                                                   10.0 ** (self.times[-1] + 0.1)),
                 xlim=(10.0 ** (self.errors[0] - 0.5), self.none * (3.0 if self.has_none else 0.3)))
        axes.set_xticks(ticks + [self.none] * self.has_none,
                        [power(t) for t in ticks] + ["none"] * self.has_none)
        times = [10.0 ** exponent for exponent in self.times]
        axes.set_yticks(times, [duration(t) for t in times])
        axes.minorticks_off()


def facts_of(point, measured):
    """What there is to know of a point: {name: (words, value)}."""
    facts = {name: (duration(point[key]), point[key]) for name, key in (
        ("mean time", "meanMicroseconds"), ("median time", "medianMicroseconds"))}
    facts |= {name: (power(point[key], 1) if point["found"] else "–", point[key])
              for name, key in (("median error", "medianError"), ("largest error", "maxError"))}
    return facts | {name: (str(point[key]), point[key]) for key, name in [
        ("queries", "queries"), ("hits", "with contact"), ("found", "found"), *flaws_of(measured)]}


def tips_of(measured):
    return {f"{measured['family']}-{n}": "\n".join(
        [f"{p['method']}, {p['setting']}", p["title"]] +
        [f"{name}\t{words}" for name, (words, _) in facts_of(p, measured).items()])
        for n, p in enumerate(measured["points"])}


def draw_flaws(axes, measured, own, looks, ranges):
    """Rows above the panel: a cross where a setting had that flaw, larger for more."""
    flaws = flaws_of(measured)
    rows = axes.inset_axes([0.0, 1.0, 1.0, 0.065 * len(flaws)], sharex=axes)
    rows.set_ylim(len(flaws) - 0.5, -0.5)
    rows.set_yticks(range(len(flaws)), [words for _, words in flaws])
    rows.tick_params(labelbottom=False, labelsize=8, labelcolor=SOFT)
    rows.grid(False, axis="x")
    rows.spines[:].set_visible(False)
    for number, point in own:
        for height, (key, _) in enumerate(flaws):
            if point[key] > 0:
                of = point["queries"] if key in ("false", "timedOut") else point["hits"]
                rows.plot(ranges.place_of(point)[0], height, "x", clip_on=False,
                          color=looks[point["method"]][0], markeredgewidth=1.6, zorder=3,
                          markersize=3.2 + 4.5 * math.sqrt(point[key] / max(of, 1)),
                          gid=f"{measured['family']}-{number}-{key}")
    return rows


def draw_scene(figure, measured, scene):
    """Fills a figure with the panel of a scene."""
    axes, looks, ranges = figure.subplots(), looks_of(measured), Ranges(measured)
    own = [(n, p) for n, p in enumerate(measured["points"]) if p["scene"] == scene]
    family, points = measured["family"], [p for _, p in own]
    right = front([p for p in points if is_right(p)])
    ranges.apply(axes)
    axes.set(xlabel="median " + measured["error"], ylabel=measured["time"])
    top = draw_flaws(axes, measured, own, looks, ranges) if flaws_of(measured) else axes
    top.set_title(points[0]["title"], x=-0.2)
    # From the cheapest on: a smaller error costs the next time up.
    for name, best, style in (("anyfront", front(points), {"linestyle": "--", "linewidth": 0.9}),
                              ("front", right, {"linewidth": 1.5})):
        axes.plot(*zip(*map(ranges.place_of, best)), color=INK, alpha=0.75, drawstyle="steps-pre",
                  zorder=2, gid=f"{family}-{name}-{scene}", **style)
    for method, (colour, mark) in looks.items():
        mine = [(n, p) for n, p in own if p["method"] == method]
        axes.plot(*zip(*[ranges.place_of(p) for _, p in mine]), color=colour, linewidth=1,
                  alpha=0.5, gid=f"{family}-way-" + "-".join(str(n) for n, _ in mine))
        for number, point in mine:
            axes.plot(*ranges.place_of(point), mark, markersize=6, zorder=3, markeredgewidth=1.2,
                      markerfacecolor=colour if is_right(point) else PAPER, clip_on=False,
                      markeredgecolor=INK if point in right else colour,
                      gid=f"{family}-{number}")
    return axes, right, own


def label_marks(figure, axes, right, own, measured):
    """The settings beside their marks, where they cover nothing; those on the front come first."""
    ranges, looks = Ranges(measured), looks_of(measured)
    scale = 72.0 / figure.dpi
    places = {n: scale * axes.transData.transform(ranges.place_of(p)) for n, p in own}
    low, high = scale * axes.bbox.get_points()
    taken = [(place - 4.0, place + 4.0) for place in places.values()]
    for number, point in sorted(own, key=lambda pair: pair[1] not in right):
        size = numpy.array([2.25 * len(point["setting"]), 4.0])
        # Beside comes last: lines leave there.
        for offset in ((0, 9), (0, -9), (size[0] + 4, 8), (-size[0] - 4, -8), (size[0] + 5, 0),
                       (-size[0] - 5, 0)):
            left, right_end = places[number] + offset - size, places[number] + offset + size
            if all(left > low) and all(right_end < high) and not any(
                    all(left < end) and all(right_end > begin) for begin, end in taken):
                taken.append((left, right_end))
                axes.annotate(point["setting"], ranges.place_of(point), offset, size=7.5,
                              textcoords="offset points", ha="center", va="center", in_layout=False,
                              color=looks[point["method"]][0],
                              bbox={"facecolor": PAPER, "alpha": 0.6, "linewidth": 0, "pad": 0.2},
                              gid=f"{measured['family']}-{number}-setting")
                break


def draw_panels(measured, scenes):
    columns = min(len(scenes), COLUMNS)
    rows = math.ceil(len(scenes) / columns)
    figure = Figure(figsize=(4.2 * columns, 3.8 * rows), layout="constrained")
    parts = figure.subfigures(rows, columns, squeeze=False).flat
    drawn = [draw_scene(part, measured, scene) for part, scene in zip(parts, scenes)]
    figure.draw_without_rendering()
    for panel in drawn:
        label_marks(figure, *panel, measured)
    return figure


def draw(measured):
    """A figure of all scenes."""
    figure = draw_panels(measured, scenes_of(measured))
    head(figure, f"{measured['title']}: {measured['time']} against error",
         "lower left is better; mean time over the queries, one core; " + origin_of(measured))
    mark = {"linestyle": "", "marker": "o", "color": INK}
    foot(figure, [sample(method, linestyle="", marker=shape, markersize=7, color=colour)
                  for method, (colour, shape) in looks_of(measured).items()], COLUMNS)
    foot(figure, [
        sample("every answer right; outlined: on the front", **mark),
        sample("hollow: × above says what is wrong", markerfacecolor=PAPER, **mark),
        sample("Pareto front of what is right throughout", color=INK, linewidth=1.5),
        sample("Pareto front of everything", color=INK, linestyle="--", linewidth=0.9)], 1, 0.68)
    return figure


def sign_of(look):
    return tag("span", SIGNS[look[1]], class_="sign", style=f"color:{look[0]}")


def choice_cell(best, looks):
    if best is None:
        return tag("td", "none measured", class_="soft")
    return tag("td", sign_of(looks[best["method"]]), tag("b", best["method"]), " ", best["setting"],
               page.Html("<br>"),
               tag("span", f"{duration(best['meanMicroseconds'])}, largest error "
                           f"{power(best['maxError'])}", class_="soft"))


def choices_table(measured):
    """Rows of thresholds; columns: all scenes together, then each."""
    scenes = scenes_of(measured)
    columns = [choices(measured)] + [choices(measured, scene) for scene in scenes]
    return page.table(["largest error", "every scene"] + scenes,
                      [[tag("th", f"≤ {power(row[0][0])}")] +
                       [choice_cell(best, looks_of(measured)) for _, best in row]
                       for row in strictest(list(zip(*columns)))], "choices")


def points_table(measured):
    flaws = [name for _, name in flaws_of(measured)]
    rows = []
    for number, p in sorted(enumerate(measured["points"]), key=lambda i: i[1]["meanMicroseconds"]):
        facts = [tag("td", words, data_value=value,
                     class_="number wrong" if name in flaws and value else "number")
                 for name, (words, value) in facts_of(p, measured).items()]
        rows.append(page.row([p["scene"], p["method"], p["setting"], *facts],
                             data_point=f"{measured['family']}-{number}",
                             data_method=p["method"], data_setting=p["setting"]))
    return page.table(["scene", "method", "setting", *facts_of(measured["points"][0], measured)],
                      rows, "points")


def section_of(measured, folder, scenes):
    """HTML of the section; writes the picture, of these scenes if any, into the folder, too."""
    few = [p for p in measured["points"] if p["scene"] in scenes] or measured["points"]
    few = measured | {"points": few}
    save(draw(few), folder, measured["family"], tips_of(few))
    print_choices(measured)
    names, tips = scenes_of(measured), tips_of(measured)
    panels = [tag("div", page.Html(svg(draw_panels(measured, [name]), name, tips)))
              for name in names]
    flaws = ", ".join(words for _, words in flaws_of(measured))
    return page.section(
        measured,
        tag("p", f"Lower left is better: {measured['time']} against {measured['error']}. A hollow "
                 f"mark has wrong answers; the crosses above it say which ({flaws}), larger for "
                 "more. The solid line is the Pareto front of what is right throughout, the dashed "
                 "one of everything. Point at a mark for its data; what is in the field, "
                 "parted by commas, hides the points that lack one part."),
        tag("div", *[tag("span", sign_of(look), method)
                     for method, look in looks_of(measured).items()], class_="legend"),
        tag("div", page.find("methods, scenes, settings", "points"), class_="filters"),
        tag("div", *panels, class_="panels"),
        tag("h3", "Which setting do I take for my accuracy?"),
        tag("p", "The fastest setting whose ", tag("em", "largest"), " error over all queries is "
                 "no more than that, with not one answer wrong. Rows that would only repeat the "
                 "next are left out."),
        choices_table(measured), tag("h3", "All points"),
        points_table(measured))


def print_choices(measured):
    print(f"{measured['title']}: the fastest setting that is right in every scene")
    for ((threshold, best),) in strictest(list(zip(choices(measured)))):
        words = "none measured" if best is None else (
            f"{best['method']}, {best['setting']} ({duration(best['meanMicroseconds'])})")
        print(f"  largest error <= {power(threshold):<6} {words}")
