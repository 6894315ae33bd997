"""The catalogue's cases x methods as SVG, and what it adds up to; colours that the colour-blind can
tell apart, and a letter for each verdict."""
from html import escape

from chart_svg import origin_of

# Verdict: letter, colour of the cell, colour of the letter.
VERDICTS = {
    "pass": ("✓", "#cfe8da", "#1b5e3b"),
    "inaccurate": ("E", "#f3dd6d", "#3d3400"),
    "late": ("L", "#f0a63c", "#3a2100"),
    "missed": ("M", "#c8451b", "#ffffff"),
    "false contact": ("F", "#a04c93", "#ffffff"),
    "gave up": ("G", "#4c86c6", "#ffffff"),
    "crashed": ("C", "#101418", "#ffffff"),
    "timed out": ("T", "#5f6770", "#ffffff"),
    "not applicable": ("", "none", "#8a939e"),
}
MEANINGS = {
    "pass": "right",
    "inaccurate": "earlier than the tolerance explains",
    "late": "after the contact: bodies overlap",
    "missed": "no contact found",
    "false contact": "a contact that is not there",
    "gave up": "says that it has no answer",
    "crashed": "ended its process",
    "timed out": "no answer within the limit",
    "not applicable": "cannot be asked: not convex, or turns",
}
KINDS = {"rigid": "Two rigid bodies", "articulated": "A chain of joints among obstacles"}
CELL, ROW, NAMES = 22, 15, 110
LEFT, TOP, FOOT = 46, 152, 84


def methods_of(measured, kind):
    return [m for m in measured["methods"] if m["kind"] == kind]


def cases_of(measured, kind):
    return [c for c in measured["cases"] if c["kind"] == kind]


def answers_of(measured, kind, method):
    """Of a method, in the order of the cases."""
    return [next(a for a in case["answers"] if a["method"] == method)
            for case in cases_of(measured, kind)]


def sums_of(measured, kind, method):
    """How often each verdict was given."""
    sums = dict.fromkeys(VERDICTS, 0)
    for answer in answers_of(measured, kind, method):
        sums[answer["verdict"]] += 1
    return sums


def failures_of_ours(measured):
    """Cases that this library does not get right: (id, method, verdict)."""
    ours = {(m["kind"], m["name"]) for m in measured["methods"] if m["owner"] == "ours"}
    return [(case["id"], answer["method"], answer["verdict"]) for case in measured["cases"]
            for answer in case["answers"]
            if (case["kind"], answer["method"]) in ours and answer["verdict"] != "pass"]


def label(method):
    return f"ours, {method['name']}" if method["owner"] == "ours" else method["name"]


def words(x, y, what, size=11, extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" {extra}>{escape(what)}</text>'


def draw_cell(x, y, verdict, width=CELL - 2, height=ROW - 2):
    letter, colour, ink = VERDICTS[verdict]
    if verdict == "not applicable":
        return f'<path class="frame" d="M{x + width / 2 - 3:.1f},{y + height / 2:.1f}h6"/>'
    return (f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="2.5" fill="{colour}"/>'
            f'<text x="{x + width / 2}" y="{y + height / 2 + 3.4}" font-size="9.5" '
            f'text-anchor="middle" style="fill:{ink}">{letter}</text>')


def draw_block(measured, kind, cases, x, y):
    """Some of the cases, a row each, below the names of methods; (SVG, width, height)."""
    methods = methods_of(measured, kind)
    parts = []
    for k, method in enumerate(methods):
        left = x + LEFT + k * CELL + CELL / 2 + 3
        weight = 'font-weight="600"' if method["owner"] == "ours" else 'class="soft"'
        parts.append(words(left, y + NAMES - 6, label(method), 11,
                           f'{weight} transform="rotate(-60 {left:.1f} {y + NAMES - 6:.1f})"'))
    for row, case in enumerate(cases):
        top = y + NAMES + row * ROW
        parts.append(words(x + LEFT - 6, top + 10, case["id"], 10, 'text-anchor="end"'))
        parts += [draw_cell(x + LEFT + k * CELL, top, answer["verdict"])
                  for k, answer in enumerate(case["answers"])]
    return "\n".join(parts), LEFT + len(methods) * CELL, NAMES + len(cases) * ROW


def blocks_of(measured):
    """(kind, cases) of the blocks, side by side: the rigid cases in three."""
    blocks = []
    for kind, columns in (("rigid", 3), ("articulated", 1)):
        cases = cases_of(measured, kind)
        length = -(-len(cases) // columns)
        blocks += [(kind, cases[i:i + length]) for i in range(0, len(cases), max(length, 1))]
    return blocks


def draw_sums(measured, x, y):
    """A bar a method: how many of its cases are what; (SVG, height)."""
    parts = []
    row = 0
    for kind in KINDS:
        for method in methods_of(measured, kind):
            sums = sums_of(measured, kind, method["name"])
            asked = sum(n for v, n in sums.items() if v != "not applicable")
            top = y + row * 19
            weight = 'font-weight="600"' if method["owner"] == "ours" else ""
            parts.append(words(x + 150, top + 11, label(method), 11.5,
                               f'text-anchor="end" {weight}'))
            left = x + 158
            for verdict, count in sums.items():
                if count and verdict != "not applicable":
                    width = 2.1 * count
                    parts.append(f'<rect x="{left:.1f}" y="{top}" width="{width:.1f}" height="14" '
                                 f'fill="{VERDICTS[verdict][1]}"><title>{count} {verdict}</title>'
                                 f'</rect>')
                    left += width
            parts.append(words(left + 6, top + 11, f"{sums['pass']} of {asked} right", 11,
                               'class="soft"'))
            row += 1
        row += 0.7
    return "\n".join(parts), row * 19


def draw_legend(x, y):
    parts = []
    for k, (verdict, meaning) in enumerate(MEANINGS.items()):
        top = y + k * 19
        parts.append(draw_cell(x, top, verdict))
        parts.append(words(x + 30, top + 10, f"{verdict}: {meaning}", 11))
    return "\n".join(parts)


def draw(measured):
    """(SVG text, width, height) of the whole catalogue."""
    parts, x, high = [], 16, 0
    for kind, cases in blocks_of(measured):
        block, width, height = draw_block(measured, kind, cases, x, TOP - NAMES + 10)
        parts.append(block)
        x += width + 44
        high = max(high, TOP - NAMES + 10 + height)
    width = x + 8
    below = high + 30
    sums, sums_height = draw_sums(measured, 24, below)
    parts += [sums, draw_legend(560, below)]
    height = round(below + max(sums_height, 19 * len(MEANINGS)) + 16)
    count = len(measured["cases"])
    head = [f'<svg xmlns="http://www.w3.org/2000/svg" class="chart" width="{width}" '
            f'height="{height}" viewBox="0 0 {width} {height}">', "{{STYLE}}",
            f'<rect class="paper" width="{width}" height="{height}"/>',
            words(24, 30, f"{count} contact times with exact answers", 20, 'font-weight="600"'),
            words(24, 50, "every case through every method; ids as in benchmarks/reference/catalogue/README.md; " +
                  origin_of(measured), 11.5, 'class="soft"')]
    return "\n".join(head + parts + ["</svg>", ""]), width, height
