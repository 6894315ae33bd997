"""Draws points of time against error as SVG: a panel a scene, a colour and a mark a method.

Colours of text and lines are in classes, so that a page or a dark reader can change them; every
point is a group with its number in the measurement, for scripts.
"""
import math
from xml.sax.saxutils import escape

from chart_points import BEST_ERROR, duration, error_of, flaws_of, front, is_right, unique

COLUMNS = 3
PANEL_WIDTH = 385
PLOT_HEIGHT = 230
LEFT, RIGHT, TOP, BOTTOM = 86, 12, 30, 48
FLAW_ROW = 14
HEADER, MARGIN, LEGEND_ROW = 74, 16, 22

# Whose a method is shows in its hue: blue ours, violet ours sampled, orange FCL, green Bullet.
HUES = {
    "ours": ["#1c64d9", "#0aa5c9", "#6d4fe0", "#138a72", "#8093ad", "#b9739f", "#3f8fb5"],
    "sampled": ["#a636b8", "#e0559d"],
    "fcl": ["#dd5a12", "#e5a50a"],
    "bullet": ["#2f9e44", "#7cae12", "#a1702c"],
}

STYLE = """
.chart { --ink: #1d232b; --soft: #5d6773; --grid: #e6e9ed; --frame: #a8b0ba; --paper: #ffffff;
  font-family: system-ui, -apple-system, "Segoe UI", "Helvetica Neue", Arial, sans-serif; }
@media (prefers-color-scheme: dark) {
  .chart { --ink: #e8ebef; --soft: #a0aab6; --grid: #2b323b; --frame: #59636f; --paper: #171b21; }
  .chart .method, .chart .key { filter: brightness(1.35); }
}
.chart text { fill: var(--ink); }
.chart .soft { fill: var(--soft); }
.chart .paper { fill: var(--paper); }
.chart .frame { fill: none; stroke: var(--frame); }
.chart .grid { stroke: var(--grid); }
.chart .front { fill: none; stroke: var(--ink); stroke-width: 2; stroke-opacity: 0.8; }
.chart .anyfront { fill: none; stroke: var(--ink); stroke-width: 1.2; stroke-dasharray: 4 3;
  stroke-opacity: 0.65; }
.chart .way { fill: none; stroke: currentColor; stroke-width: 1.3; stroke-opacity: 0.5; }
.chart .mark { fill: currentColor; stroke: currentColor; stroke-width: 1.6; }
.chart .flawed .mark { fill: var(--paper); }
.chart .best .mark { stroke: var(--ink); }
.chart .cross { fill: none; stroke: currentColor; stroke-width: 2; }
.chart text.setting { fill: currentColor; font-size: 10px; paint-order: stroke;
  stroke: var(--paper); stroke-width: 2.5px; stroke-linejoin: round; }
"""

# Paths about (0, 0), about 8 across.
MARKS = ["M-4,0a4,4 0 1,0 8,0a4,4 0 1,0 -8,0z", "M-3.6,-3.6h7.2v7.2h-7.2z",
         "M0,-4.8L4.5,3.4H-4.5z", "M0,-5L5,0L0,5L-5,0z", "M0,4.8L4.5,-3.4H-4.5z",
         "M-1.7,-4.6h3.4v2.9h2.9v3.4h-2.9v2.9h-3.4v-2.9h-2.9v-3.4h2.9z",
         "M0,-5L4.8,-1.5L2.9,4.1H-2.9L-4.8,-1.5z"]


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
        owner = owner_of(method)
        number = used[owner] = used.get(owner, -1) + 1
        hues = HUES[owner]
        # Marks go on over the owners, so that no two methods share one before all are used.
        looks[method] = (hues[number % len(hues)], MARKS[len(looks) % len(MARKS)])
    return looks


def text(x, y, words, size=12, anchor="middle", extra=""):
    return (f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" {extra}>'
            f'{escape(words)}</text>')


def line(x1, y1, x2, y2, style):
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" {style}/>'


def exponents(values):
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


class Panel:
    """Axes of one scene; all panels of a family share their ranges."""

    def __init__(self, measured):
        points = measured["points"]
        self.flaws = flaws_of(measured)
        self.x, self.y = LEFT, TOP + FLAW_ROW * len(self.flaws) + 6
        self.width, self.height = PANEL_WIDTH - LEFT - RIGHT, PLOT_HEIGHT
        self.total = self.y + self.height + BOTTOM
        self.times = exponents([max(p["meanMicroseconds"], 1e-3) for p in points])
        self.none = 44 if any(p["found"] == 0 for p in points) else 0
        self.errors = exponents([error_of(p) for p in points if p["found"] > 0] or [BEST_ERROR, 1])

    def at_error(self, error):
        """At the right end is the place of those that found nothing at all."""
        if error is None:
            return self.x + self.width - 20
        low, high = self.errors
        share = (math.log10(error) - low) / (high - low)
        return self.x + 12 + share * (self.width - 28 - self.none)

    def at_micros(self, micros):
        low, high = self.times
        share = (math.log10(max(micros, 1e-3)) - low) / (high - low)
        return self.y + self.height - 4 - share * (self.height - 8)

    def place_of(self, point):
        return self.at_error(error_of(point)), self.at_micros(point["meanMicroseconds"])

    def flaw_row(self, row):
        return self.y - 10 - FLAW_ROW * (len(self.flaws) - 1 - row)


def draw_front(panel, points, kind):
    places = [panel.place_of(p) for p in front(points)]
    if not places:
        return f'<path class="{kind}" d=""/>'
    # From the cheapest on: a smaller error costs the next time up.
    path = "M{:.1f},{:.1f}".format(*places[0])
    path += "".join(f"V{y:.1f}H{x:.1f}" for x, y in places[1:])
    return f'<path class="{kind}" d="{path}"/>'


def draw_axes(panel, title, measured):
    right, bottom = panel.x + panel.width, panel.y + panel.height
    parts = [text(14, 18, title, 14, "start", 'font-weight="600"')]
    low, high = panel.errors
    step = max(1, math.ceil((high - low) / 7))
    for exponent in range(high, low - 1, -step):
        x = panel.at_error(10.0 ** exponent)
        parts.append(line(x, panel.y, x, bottom, 'class="grid"'))
        parts.append(text(x, bottom + 16, "1" if exponent == 0 else f"1e{exponent}"))
    if panel.none:
        parts.append(text(panel.at_error(None), bottom + 16, "none"))
    for exponent in range(panel.times[0], panel.times[1] + 1):
        y = panel.at_micros(10.0 ** exponent)
        parts.append(line(panel.x, y, right, y, 'class="grid"'))
        parts.append(text(panel.x - 6, y + 4, duration(10.0 ** exponent), 12, "end"))
    for row, (_, label) in enumerate(panel.flaws):
        y = panel.flaw_row(row)
        parts.append(text(panel.x - 6, y + 4, label, 11, "end", 'class="soft"'))
        parts.append(line(panel.x, y, right, y, 'class="grid"'))
    parts.append(f'<rect class="frame" x="{panel.x}" y="{panel.y}" width="{panel.width}" '
                 f'height="{panel.height}"/>')
    parts.append(text(panel.x + panel.width / 2, bottom + 35, "median " + measured["error"], 12,
                      extra='class="soft"'))
    middle = panel.y + panel.height / 2
    parts.append(text(14, middle, measured["time"], 12,
                      extra=f'class="soft" transform="rotate(-90 14 {middle:.1f})"'))
    return parts


def describe(point, measured):
    flaws = ", ".join(f"{label} {point[key]}" for key, label in flaws_of(measured)
                      if point[key] > 0)
    return (f"{point['method']}, {point['setting']}: {duration(point['meanMicroseconds'])}, "
            f"median error {point['medianError']:.2g}, largest {point['maxError']:.2g}, "
            f"{point['found']} of {point['hits']} found in {point['queries']} queries; "
            f"{flaws or 'all right'}")


def draw_point(panel, number, point, measured, look):
    x, y = panel.place_of(point)
    mark, is_best = look
    kind = "" if is_right(point) else " flawed"
    parts = [f'<g class="point{kind}{" best" if is_best else ""}" data-point="{number}" '
             f'data-x="{x:.1f}" data-y="{y:.1f}"><title>{escape(describe(point, measured))}</title>'
             f'<path class="mark" d="{mark}" transform="translate({x:.1f} {y:.1f})"/>']
    for row, (key, _) in enumerate(panel.flaws):
        if point[key] > 0:
            of = point["queries"] if key in ("false", "timedOut") else point["hits"]
            size = 2.2 + 3.0 * math.sqrt(point[key] / max(of, 1))
            top = panel.flaw_row(row)
            parts.append(f'<path class="cross" d="M{x - size:.1f},{top - size:.1f}'
                         f'l{2 * size:.1f},{2 * size:.1f}m0,{-2 * size:.1f}'
                         f'l{-2 * size:.1f},{2 * size:.1f}"/>')
    return "".join(parts) + "</g>"


class Labels:
    """Places words beside points where they cover nothing."""

    def __init__(self, panel, points):
        self.panel = panel
        self.taken = [(x - 5, y - 5, x + 5, y + 5)
                      for x, y in (panel.place_of(p) for p in points)]

    def add(self, point):
        x, y = self.panel.place_of(point)
        width, words = 5.6 * len(point["setting"]), point["setting"]
        # Beside comes last: lines leave there.
        for left, middle in ((x - width / 2, y - 12), (x - width / 2, y + 12), (x + 5, y - 10),
                             (x - 5 - width, y + 10), (x + 7, y), (x - 7 - width, y)):
            box = (left, middle - 5, left + width, middle + 5)
            inside = (box[0] > self.panel.x + 1 and box[1] > self.panel.y and
                      box[2] < self.panel.x + self.panel.width - 1 and
                      box[3] < self.panel.y + self.panel.height)
            if inside and not any(box[0] < t[2] and t[0] < box[2] and box[1] < t[3] and
                                  t[1] < box[3] for t in self.taken):
                self.taken.append(box)
                return (f'<text class="setting" x="{left:.1f}" y="{middle + 3.5:.1f}">'
                        f'{escape(words)}</text>')
        return ""


def draw_panel(measured, scene):
    """(width, height, SVG text) of a scene, to be put into an svg element of class "chart"."""
    panel = Panel(measured)
    looks = looks_of(measured)
    own = [(number, p) for number, p in enumerate(measured["points"]) if p["scene"] == scene]
    points = [p for _, p in own]
    parts = [f'<rect class="paper" width="{PANEL_WIDTH}" height="{panel.total}" rx="6"/>']
    parts += draw_axes(panel, points[0]["title"], measured)
    parts.append(draw_front(panel, points, "anyfront"))
    parts.append(draw_front(panel, [p for p in points if is_right(p)], "front"))
    labels = Labels(panel, points)
    best = front([p for p in points if is_right(p)])
    words = {id(p): labels.add(p) for p in best + [p for p in points if p not in best]}
    for method, (colour, mark) in looks.items():
        mine = [(number, p) for number, p in own if p["method"] == method]
        way = " ".join("{:.1f},{:.1f}".format(*panel.place_of(p)) for _, p in mine)
        parts.append(f'<g class="method" data-method="{escape(method, {chr(34): "&quot;"})}" '
                     f'style="color:{colour}"><polyline class="way" points="{way}"/>')
        parts += [draw_point(panel, number, p, measured, (mark, p in best)) + words[id(p)]
                  for number, p in mine]
        parts.append("</g>")
    return PANEL_WIDTH, panel.total, "\n".join(parts)


def draw_legend(measured, x, y):
    """(SVG text, height)."""
    parts = []
    looks = looks_of(measured)
    for k, (method, (colour, mark)) in enumerate(looks.items()):
        left, top = x + (k % 3) * 255, y + (k // 3) * LEGEND_ROW
        parts.append(f'<path class="key" d="{mark}" fill="{colour}" '
                     f'transform="translate({left} {top - 4}) scale(1.25)"/>')
        parts.append(text(left + 12, top, method, 13, "start"))
    left = x + 3 * 255
    explained = [
        (f'<path class="mark" d="{MARKS[0]}" transform="translate({left + 14} %.1f)"/>',
         "every answer right; outlined: on the front"),
        (f'<g class="flawed"><path class="mark" d="{MARKS[0]}" '
         f'transform="translate({left + 14} %.1f)"/></g>',
         "hollow: × above says what is wrong"),
        (f'<path class="front" d="M{left},%.1fh28"/>', "Pareto front of what is right throughout"),
        (f'<path class="anyfront" d="M{left},%.1fh28"/>', "Pareto front of everything")]
    for row, (sign, words) in enumerate(explained):
        top = y + row * LEGEND_ROW
        parts.append(sign % (top - 4))
        parts.append(text(left + 36, top, words, 13, "start"))
    rows = max(len(explained), math.ceil(len(looks) / 3))
    return "\n".join(parts), rows * LEGEND_ROW


def origin_of(measured):
    """What measured it: command, machine, compiler, flags, peers, commit, date."""
    machine = measured.get("machine", {})
    return ", ".join(filter(None, [
        measured.get("command"), machine.get("processor"), measured.get("compiler"),
        measured.get("flags", "").strip(), " and ".join(filter(None, measured.get("peers", []))),
        "commit " + measured.get("commit", "unknown"), measured.get("date")]))


def draw(measured):
    """(SVG text, width, height) of a measurement as tools/chart writes it."""
    scenes = unique(p["scene"] for p in measured["points"])
    columns = min(COLUMNS, max(len(scenes), 1))
    rows = math.ceil(len(scenes) / columns)
    width = 2 * MARGIN + COLUMNS * PANEL_WIDTH
    height_of_panel = Panel(measured).total
    parts = []
    for k, scene in enumerate(scenes):
        wide, high, body = draw_panel(measured, scene)
        left = MARGIN + (k % columns) * PANEL_WIDTH
        top = HEADER + (k // columns) * height_of_panel
        parts.append(f'<svg x="{left}" y="{top}" width="{wide}" height="{high}">{body}</svg>')
    legend, high = draw_legend(measured, MARGIN + 20, HEADER + rows * height_of_panel + 30)
    height = HEADER + rows * height_of_panel + 30 + high
    head = [f'<svg xmlns="http://www.w3.org/2000/svg" class="chart" width="{width}" '
            f'height="{height}" viewBox="0 0 {width} {height}">',
            f"<style>{STYLE}</style>",
            f'<rect class="paper" width="{width}" height="{height}"/>',
            text(MARGIN + 8, 32, f"{measured['title']}: {measured['time']} against error", 21,
                 "start", 'font-weight="600"'),
            text(MARGIN + 8, 54, "lower left is better; mean time over the queries, one core; " +
                 origin_of(measured), 12, "start", 'class="soft"')]
    return "\n".join(head + parts + [legend, "</svg>", ""]), width, height
