"""One page with all charts, the data behind every point and the settings to take; no other files."""
import json
from html import escape
from pathlib import Path

import chart_svg
from chart_points import choices, duration, flaws_of, power, strictest, unique

TEMPLATE = Path(__file__).resolve().parent / "chart_page.html"
ORDER = ["rigid", "articulated", "closing", "step"]


def mark_of(look):
    colour, mark = look
    return (f'<svg class="sign" viewBox="-7 -7 14 14" style="color:{colour}">'
            f'<path d="{mark}" fill="currentColor"/></svg>')


def filters_of(measured):
    looks = chart_svg.looks_of(measured)
    methods = "".join(
        f'<button class="chip" aria-pressed="true" data-method="{escape(method)}">'
        f'{mark_of(look)}{escape(method)}</button>' for method, look in looks.items())
    scenes = "".join(
        f'<button class="chip" aria-pressed="true" data-scene="{escape(scene)}">'
        f'{escape(scene)}</button>'
        for scene in unique(p["scene"] for p in measured["points"]))
    return (f'<div class="filters"><span>Methods</span>{methods}'
            f'<button class="plain" data-all="method">all / none</button></div>'
            f'<div class="filters"><span>Scenes</span>{scenes}'
            f'<button class="plain" data-all="scene">all / none</button>'
            f'<label><input type="checkbox" class="only-right"> only settings with every answer '
            f'right</label></div>')


def panels_of(measured):
    parts = []
    for scene in unique(p["scene"] for p in measured["points"]):
        width, height, body = chart_svg.draw_panel(measured, scene)
        parts.append(f'<svg class="chart panel" data-scene="{escape(scene)}" role="img" '
                     f'aria-label="{escape(scene)}" viewBox="0 0 {width} {height}">{body}</svg>')
    return "\n".join(parts)


def choice_cell(best, looks):
    if best is None:
        return '<td class="nothing">none measured</td>'
    return (f'<td>{mark_of(looks[best["method"]])}<b>{escape(best["method"])}</b> '
            f'{escape(best["setting"])}<br><span class="soft">{duration(best["meanMicroseconds"])},'
            f' largest error {power(best["maxError"])}</span></td>')


def choices_of(measured):
    """Rows of thresholds; columns: all scenes together, then each."""
    looks = chart_svg.looks_of(measured)
    scenes = unique(p["scene"] for p in measured["points"])
    columns = [choices(measured)] + [choices(measured, scene) for scene in scenes]
    head = "".join(f"<th>{escape(name)}</th>" for name in ["every scene"] + scenes)
    body = "".join(
        f'<tr><th>≤ {power(rows[0][0])}</th>' + "".join(choice_cell(best, looks) for _, best in rows)
        + "</tr>" for rows in strictest(list(zip(*columns))))
    return (f'<div class="wide"><table class="choices"><thead><tr><th>largest error</th>{head}</tr>'
            f'</thead><tbody>{body}</tbody></table></div>')


def section_of(measured):
    flaws = [label for _, label in flaws_of(measured)]
    return (
        f'<section class="family" id="{escape(measured["family"])}" '
        f'data-family="{escape(measured["family"])}">'
        f'<h2>{escape(measured["title"])}</h2>'
        f'<p>Lower left is better: {escape(measured["time"])} against {escape(measured["error"])}. '
        f'A hollow mark has wrong answers; the crosses above it say which ({escape(", ".join(flaws))})'
        f', larger for more. The solid line is the Pareto front of what is right throughout, the '
        f'dashed one of everything. Point at a mark for its data.</p>'
        f'{filters_of(measured)}<div class="panels">{panels_of(measured)}</div>'
        f'<h3>Which setting do I take for my accuracy?</h3>'
        f'<p>The fastest setting whose <em>largest</em> error over all queries is no more than '
        f'that, with not one answer wrong. Rows that would only repeat the next are left out.</p>{choices_of(measured)}'
        f'<h3>All points</h3><div class="filters"><input type="search" class="find" '
        f'placeholder="find in the table"><span class="count"></span></div>'
        f'<div class="wide tall"><table class="points"></table></div>'
        f'<p class="soft origin">{escape(chart_svg.origin_of(measured))}</p></section>')


def make_page(families):
    """Text of the page; measurements as tools/chart writes them."""
    ordered = sorted(families, key=lambda m: (ORDER.index(m["family"]) if m["family"] in ORDER
                                              else len(ORDER), m["family"]))
    links = "".join(f'<a href="#{escape(m["family"])}">{escape(m["family"])}</a>' for m in ordered)
    data = json.dumps({m["family"]: m for m in ordered}).replace("<", "\\u003c")
    page = TEMPLATE.read_text()
    for key, value in {"CHART_STYLE": chart_svg.STYLE, "LINKS": links, "DATA": data,
                       "SECTIONS": "\n".join(section_of(m) for m in ordered)}.items():
        page = page.replace("{{" + key + "}}", value)
    return page
