"""Draws points of time against error as SVG: a panel a scene, a colour a method."""
import math
from xml.sax.saxutils import escape

# Colours that stay apart for colour-blind readers (Okabe and Ito), ours first and darkest.
COLOURS = ["#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#d55e00",
           "#7f3f00", "#8f8f00", "#7f7f7f"]
COLUMNS = 3
PANEL_WIDTH, PANEL_HEIGHT = 400, 300
LEFT, RIGHT, TOP, BOTTOM = 52, 12, 74, 40
HEADER, MARGIN, LEGEND_ROW = 62, 14, 19
BEST_ERROR = 1e-12  # the references themselves are known to this
FLAWS = [("missed", "missed"), ("late", "late"), ("false", "false"), ("timedOut", "too slow")]
FLAW_ROW = 11


class Panel:
    """Axes of one scene; all panels share their ranges."""

    def __init__(self, x, y, micros):
        self.x, self.y = x + LEFT, y + TOP
        self.width = PANEL_WIDTH - LEFT - RIGHT
        self.height = PANEL_HEIGHT - TOP - BOTTOM
        self.low, self.high = micros

    def at_error(self, error):
        """Right of 1 is the place of those that found no contact at all."""
        if error is None:
            return self.x + self.width - 8
        share = (math.log10(max(error, BEST_ERROR)) + 12) / 12
        return self.x + 6 + share * (self.width - 32)

    def at_micros(self, micros):
        share = (math.log10(max(micros, 1e-3)) - self.low) / (self.high - self.low)
        return self.y + self.height - min(max(share, 0.0), 1.0) * self.height


def text(x, y, words, size=11, anchor="middle", extra=""):
    return (f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" {extra}>'
            f'{escape(words)}</text>')


def line(x1, y1, x2, y2, style):
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" {style}/>'


def error_of(point):
    """Median error; None if no contact was found."""
    return max(point["medianToiError"], BEST_ERROR) if point["found"] > 0 else None


def is_right(point):
    return all(point[key] == 0 for key, _ in FLAWS)


def front(points):
    """Points that no other beats in both time and error."""
    best = []
    for point in sorted((p for p in points if p["found"] > 0),
                        key=lambda p: (p["meanMicroseconds"], p["medianToiError"])):
        if not best or error_of(point) < error_of(best[-1]):
            best.append(point)
    return best


def draw_front(panel, points, style):
    steps = front(points)
    if not steps:
        return []
    # From the cheapest on: a smaller error costs the next time up.
    places = [(panel.at_error(error_of(p)), panel.at_micros(p["meanMicroseconds"]))
              for p in steps]
    path = "M{:.1f},{:.1f}".format(*places[0])
    path += "".join(f"V{y:.1f}H{x:.1f}" for x, y in places[1:])
    return [f'<path d="{path}" fill="none" {style}/>']


def duration(exponent):
    """10^exponent microseconds in the largest unit that leaves no fraction."""
    units = ["ns", "µs", "ms", "s"]
    index = min(max(exponent // 3, -1), 2)
    return f"{10 ** (exponent - 3 * index)} {units[index + 1]}"


def flaw_height(panel, row):
    return panel.y - 10 - FLAW_ROW * (len(FLAWS) - 1 - row)


def draw_axes(panel, title):
    parts = [f'<rect x="{panel.x}" y="{panel.y}" width="{panel.width}" height="{panel.height}" '
             'fill="#ffffff" stroke="#808080"/>',
             text(panel.x, panel.y - TOP + 20, title, 13, "start", 'font-weight="bold"')]
    for exponent in range(-12, 1, 2):
        x = panel.at_error(10.0 ** exponent)
        parts.append(line(x, panel.y, x, panel.y + panel.height, 'stroke="#e4e4e4"'))
        label = "1" if exponent == 0 else f"1e{exponent}"
        parts.append(text(x, panel.y + panel.height + 14, label, 10))
    parts.append(text(panel.at_error(None), panel.y + panel.height + 14, "–", 10))
    for exponent in range(panel.low, panel.high + 1):
        y = panel.at_micros(10.0 ** exponent)
        parts.append(line(panel.x, y, panel.x + panel.width, y, 'stroke="#e4e4e4"'))
        parts.append(text(panel.x - 5, y + 3.5, duration(exponent), 10, "end"))
    parts.append(text(panel.x + panel.width / 2, panel.y + panel.height + 30,
                      "median error of the time of contact, fraction of the motion", 10))
    for row, (_, label) in enumerate(FLAWS):
        y = flaw_height(panel, row)
        parts.append(text(panel.x - 5, y + 3, label, 8.5, "end", 'fill="#606060"'))
        parts.append(line(panel.x, y, panel.x + panel.width, y, 'stroke="#eeeeee"'))
    return parts


def describe(point):
    flaws = ", ".join(f"{label} {point[key]}" for key, label in FLAWS if point[key] > 0)
    return (f"{point['method']} {point['setting']}: {point['meanMicroseconds']:.3g} µs, "
            f"median error {point['medianToiError']:.2g}, largest {point['maxToiError']:.2g}, "
            f"{point['found']} of {point['hits']} contacts in {point['queries']} queries; "
            f"{flaws or 'all right'}")


def draw_method(panel, points, colour):
    parts = []
    places = [(panel.at_error(error_of(p)), panel.at_micros(p["meanMicroseconds"]))
              for p in points]
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    parts.append(f'<polyline points="{path}" fill="none" stroke="{colour}" '
                 'stroke-width="1" stroke-opacity="0.55"/>')
    for point, (x, y) in zip(points, places):
        fill = colour if is_right(point) else "#ffffff"
        tip = f"<title>{escape(describe(point))}</title>"
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.6" fill="{fill}" '
                     f'stroke="{colour}" stroke-width="1.6">{tip}</circle>')
        for row, (key, _) in enumerate(FLAWS):
            if point[key] > 0:
                of = point["queries"] if key in ("false", "timedOut") else point["hits"]
                size = 2.0 + 3.2 * math.sqrt(point[key] / max(of, 1))
                top = flaw_height(panel, row)
                parts.append(f'<path d="M{x - size:.1f},{top - size:.1f}l{2 * size:.1f},'
                             f'{2 * size:.1f}m0,{-2 * size:.1f}l{-2 * size:.1f},{2 * size:.1f}" '
                             f'stroke="{colour}" stroke-width="1.8">{tip}</path>')
    return parts


def draw_legend(methods, colours, x, y):
    parts = []
    for k, method in enumerate(methods):
        left, top = x + (k % 3) * 265, y + (k // 3) * LEGEND_ROW
        parts.append(f'<circle cx="{left}" cy="{top - 4}" r="4" fill="{colours[method]}"/>')
        parts.append(text(left + 10, top, method, 12, "start"))
    left = x + 3 * 265
    parts.append(f'<circle cx="{left + 12}" cy="{y - 4}" r="3.6" fill="#404040"/>')
    parts.append(text(left + 30, y, "every answer right", 12, "start"))
    top = y + LEGEND_ROW
    parts.append(f'<circle cx="{left + 12}" cy="{top - 4}" r="3.6" fill="#ffffff" '
                 'stroke="#404040" stroke-width="1.6"/>')
    parts.append(text(left + 30, top, "some missed, late, false or too slow: × above the panel,",
                      12, "start"))
    top += LEGEND_ROW
    parts.append(text(left + 30, top, "larger for more; “–” on the axis: no contact found", 12,
                      "start"))
    top += LEGEND_ROW
    parts.append(line(left, top - 4, left + 24, top - 4, FRONT_STYLE))
    parts.append(text(left + 30, top, "Pareto front of what is right throughout", 12, "start"))
    top += LEGEND_ROW
    parts.append(line(left, top - 4, left + 24, top - 4, ANY_FRONT_STYLE))
    parts.append(text(left + 30, top, "of everything, late answers included", 12, "start"))
    return parts


FRONT_STYLE = 'stroke="#000000" stroke-width="1.4"'
ANY_FRONT_STYLE = 'stroke="#000000" stroke-width="1" stroke-dasharray="4 3"'


def unique(values):
    return list(dict.fromkeys(values))


def draw(measured):
    """SVG text of a measurement as tools/chart writes it."""
    points = measured["points"]
    scenes = unique(p["scene"] for p in points)
    methods = unique(p["method"] for p in points)
    colours = {m: COLOURS[k % len(COLOURS)] for k, m in enumerate(methods)}
    low = math.floor(math.log10(min(p["meanMicroseconds"] for p in points)))
    high = math.ceil(math.log10(max(p["meanMicroseconds"] for p in points)))
    rows = math.ceil(len(scenes) / COLUMNS)
    width = 2 * MARGIN + COLUMNS * PANEL_WIDTH
    legend = HEADER + rows * PANEL_HEIGHT + 28
    height = legend + 5 * LEGEND_ROW + MARGIN
    machine = measured.get("machine", {})
    origin = ", ".join(filter(None, [
        measured.get("command"), machine.get("processor"), measured.get("compiler"), measured.get("flags", "").strip(),
        " and ".join(filter(None, measured.get("peers", []))),
        "commit " + measured.get("commit", "unknown"), measured.get("date")]))
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
             f'viewBox="0 0 {width} {height}" font-family="Helvetica, Arial, sans-serif">',
             f'<rect width="{width}" height="{height}" fill="#fafafa"/>',
             text(MARGIN, 26, f"Time of contact, {measured['family']}: time of a query against "
                  "error (lower left is better)", 18, "start", 'font-weight="bold"'),
             text(MARGIN, 46, "mean over the queries, one core, cold; " + origin,
                  11, "start", 'fill="#505050"')]
    for k, scene in enumerate(scenes):
        panel = Panel(MARGIN + (k % COLUMNS) * PANEL_WIDTH,
                      HEADER + (k // COLUMNS) * PANEL_HEIGHT, (low, high))
        own = [p for p in points if p["scene"] == scene]
        parts += draw_axes(panel, own[0]["title"])
        parts += draw_front(panel, own, ANY_FRONT_STYLE)
        parts += draw_front(panel, [p for p in own if is_right(p)], FRONT_STYLE)
        for method in methods:
            parts += draw_method(panel, [p for p in own if p["method"] == method],
                                 colours[method])
    parts += draw_legend(methods, colours, MARGIN + 20, legend)
    return "\n".join(parts + ["</svg>", ""])
