"""Small multiples of lines and of outcomes as SVG, in the style of chart_svg.py."""
import math
from xml.sax.saxutils import escape

from chart_svg import HUES, STYLE, line, text

COLUMNS = 4
WIDTH, HEIGHT = 300, 150  # of the plot of a panel
LEFT, RIGHT, TOP, BOTTOM = 62, 16, 40, 42
LEGEND_ROW = 20

OWN_STYLE = STYLE + """
.chart .line { fill: none; stroke: currentColor; stroke-width: 2; stroke-linejoin: round; }
.chart .upper { stroke-dasharray: 5 3; stroke-width: 1.4; stroke-opacity: 0.75; }
.chart .dot { fill: currentColor; }
.chart .gone { fill: none; stroke: currentColor; stroke-width: 1.8; }
.chart .outcome { stroke: var(--paper); stroke-width: 1.5; }
.chart text.letter { fill: #10151b; font-weight: 600; }
"""

COLOURS = {
    "ours": HUES["ours"][0], "ours, tolerance 0.1 µm": HUES["ours"][1],
    "stepping, GraspIt! steps": HUES["sampled"][0], "stepping, steps / 10": HUES["sampled"][1],
    "ours, world": HUES["ours"][0], "ours, action": HUES["ours"][1],
    "stock": HUES["bullet"][0], "stock CCD": HUES["bullet"][1]}

# Fill and letter of what a simulated grasp came to: told apart without colours, too.
OUTCOMES = {"held": ("#9ec9f5", "H"), "slipped": ("#f3e08a", "S"), "dropped": ("#f2a65e", "D"),
            "through": ("#e5636f", "T"), "exploded": ("#b07cc6", "X"),
            "crashed": ("#9aa1a9", "C"), "timed out": ("#9aa1a9", "O")}


class Axis:
    """A logarithmic axis, or a linear one from 0 to 100 %."""

    def __init__(self, values, is_share=False, lowest=None):
        self.is_share = is_share
        self.lowest = lowest
        positive = [v for v in values if v is not None and v > 0]
        if lowest is not None:
            positive = [max(v, lowest) for v in positive] + [lowest]
        if is_share:
            self.low, self.high = 0.0, 1.0
        elif positive:
            self.low = math.floor(math.log10(min(positive)) + 1e-9)
            self.high = max(math.ceil(math.log10(max(positive)) - 1e-9), self.low + 1)
        else:
            self.low, self.high = -1, 0

    def at(self, value):
        """0 at the low end, 1 at the high one; what is below the lowest is there."""
        if self.is_share:
            return value
        if value <= 0 or (self.lowest is not None and value < self.lowest):
            return 0.0
        return (math.log10(value) - self.low) / (self.high - self.low)

    def ticks(self):
        if self.is_share:
            return [(0.0, "0 %"), (0.5, "50 %"), (1.0, "100 %")]
        step = max(1, math.ceil((self.high - self.low) / 5))
        ticks = []
        for exponent in range(self.low, self.high + 1, step):
            words = "1" if exponent == 0 else f"1e{exponent}"
            is_lowest = self.lowest is not None and exponent == self.low
            ticks.append((10.0 ** exponent, ("≤ " if is_lowest else "") + words))
        return ticks


def polyline(places, kind):
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    return f'<polyline class="{kind}" points="{points}"/>'


def cross(x, y, size=4.0):
    return (f'<path class="gone" d="M{x - size:.1f},{y - size:.1f}l{2 * size},{2 * size}'
            f'm0,{-2 * size}l{-2 * size},{2 * size}"/>')


class Panel:
    """One plot: lines of (x, y) over a common range."""

    def __init__(self, title, x_label, x_ticks, y_axis):
        self.title, self.x_label, self.x_ticks, self.y_axis = title, x_label, x_ticks, y_axis
        low, high = (math.log10(f(x for x, _ in x_ticks)) for f in (min, max))
        self.x_at = lambda value: LEFT + 14 + (WIDTH - 28) * (
            (math.log10(value) - low) / ((high - low) or 1.0))
        self.parts = []

    def place(self, x, y):
        share = min(max(self.y_axis.at(y), 0.0), 1.0)
        return self.x_at(x), TOP + HEIGHT - 6 - share * (HEIGHT - 12)

    def add(self, points, colour, words, kind="line", opacity=1.0, nudge=0.0):
        """A line through points (x, y); where y is None, a cross at the top: there is no value.
        Crosses are nudged aside, so that those of two methods do not hide each other."""
        places = [self.place(x, y) for x, y in points if y is not None]
        body = polyline(places, kind) if len(places) > 1 else ""
        if kind == "line":
            body += "".join(f'<circle class="dot" cx="{x:.1f}" cy="{y:.1f}" r="2.6"/>'
                            for x, y in places)
            body += "".join(cross(self.x_at(x) + nudge, TOP + 6) for x, y in points if y is None)
        self.parts.append(f'<g style="color:{colour}" opacity="{opacity}">'
                          f'<title>{escape(words)}</title>{body}</g>')

    def draw(self):
        bottom = TOP + HEIGHT
        parts = []
        for row, words in enumerate(self.title.split("\n")):
            parts.append(text(LEFT, 16 + 15 * row, words, 13 if row == 0 else 11.5, "start",
                              'font-weight="600"' if row == 0 else 'class="soft"'))
        for x, words in self.x_ticks:
            at = self.x_at(x)
            parts += [line(at, TOP, at, bottom, 'class="grid"'), text(at, bottom + 15, words, 11)]
        for value, words in self.y_axis.ticks():
            y = self.place(self.x_ticks[0][0], value)[1]
            parts += [line(LEFT, y, LEFT + WIDTH, y, 'class="grid"'),
                      text(LEFT - 6, y + 4, words, 11, "end")]
        parts.append(f'<rect class="frame" x="{LEFT}" y="{TOP}" width="{WIDTH}" '
                     f'height="{HEIGHT}"/>')
        parts.append(text(LEFT + WIDTH / 2, bottom + 32, self.x_label, 11, extra='class="soft"'))
        return "\n".join(parts + self.parts)


def sheet(width, height, body, name):
    """A whole SVG document, which may stand in a page, too."""
    return (f'<svg xmlns="http://www.w3.org/2000/svg" class="chart" role="img" '
            f'aria-label="{escape(name)}" width="{width:.0f}" height="{height:.0f}" '
            f'viewBox="0 0 {width:.0f} {height:.0f}" '
            f'style="width:100%;max-width:{width:.0f}px;height:auto">'
            f'<style>{OWN_STYLE}</style><rect class="paper" width="{width:.0f}" '
            f'height="{height:.0f}" rx="8"/>{body}</svg>')


def legend(entries, y, room=COLUMNS * (LEFT + WIDTH + RIGHT)):
    """Entries (sign, words) in rows; a sign is drawn about (0, 0), 30 wide. (SVG, height)"""
    parts, x, row = [], 20.0, 0
    for sign, words in entries:
        width = 46 + 6.6 * len(words)
        if x + width > room:
            x, row = 20.0, row + 1
        top = y + 14 + row * LEGEND_ROW
        parts.append(f'<g transform="translate({x + 15:.1f} {top - 4:.1f})">{sign}</g>')
        parts.append(text(x + 36, top, words, 12, "start"))
        x += width + 14
    return "".join(parts), (row + 1) * LEGEND_ROW + 12


def line_sign(colour, kind="line", opacity=1.0):
    dot = '<circle class="dot" r="2.6"/>' if kind == "line" else ""
    return (f'<g style="color:{colour}" opacity="{opacity}"><path class="{kind}" d="M-13,0h26"/>'
            f'{dot}</g>')


def cross_sign(colour="var(--soft)"):
    return f'<g style="color:{colour}">{cross(0, 0)}</g>'


def grid(panels, entries, name):
    """Panels in rows with one legend below."""
    columns = 3 if len(panels) in (5, 6) else COLUMNS
    wide, high = LEFT + WIDTH + RIGHT, TOP + HEIGHT + BOTTOM
    rows = math.ceil(len(panels) / columns)
    parts = [f'<g transform="translate({(k % columns) * wide} {8 + (k // columns) * high})">'
             f'{panel.draw()}</g>' for k, panel in enumerate(panels)]
    signs, more = legend(entries, 8 + rows * high, columns * wide)
    return sheet(columns * wide, 8 + rows * high + more, "".join(parts) + signs, name)


def outcome_cell(x, y, width, outcome, words, height=16):
    fill, letter = OUTCOMES.get(outcome, ("#9aa1a9", "?"))
    return (f'<g><title>{escape(words)}</title><rect class="outcome" x="{x:.1f}" y="{y:.1f}" '
            f'width="{width}" height="{height}" rx="3" fill="{fill}"/>'
            f'<text class="letter" x="{x + width / 2:.1f}" y="{y + height / 2 + 4:.1f}" '
            f'font-size="10.5" text-anchor="middle">{letter}</text></g>')


def outcome_sign(outcome):
    return outcome_cell(-9, -9, 18, outcome, outcome)
