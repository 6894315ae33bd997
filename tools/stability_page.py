"""The page of tools/stability: the catalogue's matrix, its relations, where this library degrades,
and what the other families have to show; no other files."""
import json
from html import escape
from pathlib import Path

import chart_svg
import stability_matrix
from chart_points import duration, unique
from stability_matrix import (KINDS, MEANINGS, VERDICTS, answers_of, cases_of, label, methods_of,
                              sums_of)

TEMPLATE = Path(__file__).resolve().parent / "stability_page.html"
RELATIONS = {
    "moved": "the whole scene in three other frames",
    "swapped": "A is B",
    "rescaled": "lengths and tolerance in units of 1e-3 and 1e3",
    "permuted": "triangles in another order, from another corner",
    "subdivided": "every triangle as four",
    "reversed": "backwards: from the end, or from just before the contact, to the start",
    "split": "two queries, at several times, one just before the contact",
}


def chip(kind, name, words):
    return (f'<button class="chip" aria-pressed="true" data-{kind}="{escape(name)}">'
            f'{escape(words)}</button>')


def sign(verdict):
    letter, colour, ink = VERDICTS[verdict]
    return f'<span class="cell v-{verdict.replace(" ", "-")}">{letter or "–"}</span>'


def filters_of(measured):
    groups = {case["group"]: case["groupTitle"] for case in measured["cases"]}
    options = "".join(f'<option value="{escape(verdict)}">{escape(verdict)}</option>'
                      for verdict in VERDICTS)
    names = "".join(f'<option value="{escape(name)}">{escape(name)}</option>'
                    for name in unique(m["name"] for m in measured["methods"]))
    return (f'<div class="filters"><span>Groups</span>'
            + "".join(chip("group", g, f"{g} {words}") for g, words in sorted(groups.items()))
            + '<button class="plain" data-all="group">all / none</button></div>'
            f'<div class="filters"><span>Cases</span><label>that '
            f'<select class="of-method"><option value="">any method</option>{names}</select> answers'
            f' <select class="of-verdict"><option value="">in any way</option>{options}</select>'
            f'</label><input type="search" class="find" placeholder="find in ids and set-ups">'
            f'<span class="count"></span></div>')


def legend():
    return '<div class="legend">' + "".join(
        f'<span>{sign(verdict)} <b>{escape(verdict)}</b> {escape(meaning)}</span>'
        for verdict, meaning in MEANINGS.items()) + "</div>"


def matrix_of(measured, kind):
    methods = methods_of(measured, kind)
    head = "".join(f'<th class="tall-name{" own" if m["owner"] == "ours" else ""}"><div>'
                   f'<span>{escape(label(m))}</span></div></th>' for m in methods)
    rows = []
    for number, case in enumerate(measured["cases"]):
        if case["kind"] != kind:
            continue
        exact = "none" if case["time"] is None else f'{case["time"]:.9g}'
        cells = "".join(
            f'<td class="answer" data-method="{escape(a["method"])}" '
            f'data-verdict="{escape(a["verdict"])}">{sign(a["verdict"])}</td>'
            for a in case["answers"])
        rows.append(f'<tr data-case="{number}" data-group="{escape(case["group"])}">'
                    f'<th>{escape(case["id"])}</th><td class="set-up">{escape(case["title"])}</td>'
                    f'<td class="number">{exact}</td>{cells}</tr>')
    sums = "".join(f'<td class="sum" data-method="{escape(m["name"])}"></td>' for m in methods)
    return (f'<h3>{escape(KINDS[kind])}</h3><div class="wide field"><table class="matrix" '
            f'data-kind="{kind}"><thead><tr><th>id</th><th>set-up, and what is hard</th>'
            f'<th class="number">exact time</th>{head}</tr></thead><tbody>{"".join(rows)}</tbody>'
            f'<tfoot><tr><th></th><td>right, of those shown and asked</td><td></td>{sums}</tr>'
            f'</tfoot></table></div>')


def sums_table(measured):
    shown = [v for v in VERDICTS if v != "not applicable"]
    rows = []
    for kind in KINDS:
        for method in methods_of(measured, kind):
            sums = sums_of(measured, kind, method["name"])
            asked = sum(sums[v] for v in shown)
            bar = "".join(f'<i class="v-{v.replace(" ", "-")}" style="flex:{sums[v]}" '
                          f'title="{sums[v]} {v}"></i>' for v in shown if sums[v])
            seconds = sum(a["seconds"] for a in answers_of(measured, kind, method["name"])
                          if a["verdict"] != "not applicable")
            cells = "".join(f"<td class='number'>{sums[v] or '·'}</td>" for v in shown)
            rows.append(f'<tr><th>{escape(label(method))}</th><td class="soft">'
                        f'{escape(method["setting"])}</td><td class="bar"><div>{bar}</div></td>'
                        f'<td class="number">{asked}</td>{cells}'
                        f'<td class="number">{duration(1e6 * seconds)}</td></tr>')
        rows.append(f'<tr class="gap"><td colspan="{len(shown) + 5}"></td></tr>')
    head = "".join(f"<th>{escape(v)}</th>" for v in shown)
    return (f'<div class="wide"><table class="sums"><thead><tr><th>method</th><th>setting</th>'
            f'<th>share</th><th>asked</th>{head}<th>time</th></tr></thead>'
            f'<tbody>{"".join(rows[:-1])}</tbody></table></div>')


def relation_cell(count):
    if not count or not count["asked"]:
        return '<td class="soft">–</td>'
    lost = "\n".join(f'{one["id"]}, {one["variant"]}: {one["verdict"]}' for one in count["lost"])
    share = count["kept"] / count["asked"]
    words = f'{count["kept"]} of {count["asked"]}'
    kind = "whole" if share == 1 else "part"
    return (f'<td class="number {kind}" title="{escape(lost)}"><div class="share" '
            f'style="--share:{100 * share:.1f}%">{words}</div></td>')


def relations_table(measured):
    relations = measured["relations"]
    rows = "".join(
        f'<tr><th>{escape(label(m))}</th>'
        f'<td class="soft">{"rigid" if m["kind"] == "rigid" else "chains"}</td>'
        + "".join(relation_cell(m["relations"].get(name)) for name in relations) + "</tr>"
        for m in measured["methods"])
    head = "".join(f'<th title="{escape(RELATIONS.get(name, ""))}">{escape(name)}</th>'
                   for name in relations)
    meaning = "; ".join(f"<b>{escape(name)}</b>: {escape(RELATIONS.get(name, ''))}"
                        for name in relations)
    return (f'<h3 id="relations">What has to stay the same</h3><p>Every case that a method gets '
            f'right, asked again: {meaning}. Counted is what stays right; point at a number for '
            f'what is lost. A method that gets little right is asked little.</p>'
            f'<div class="wide"><table class="relations"><thead><tr><th>method</th><th></th>{head}'
            f'</tr></thead><tbody>{rows}</tbody></table></div>')


def own_table(measured):
    ours = {(m["kind"], m["name"]) for m in measured["methods"] if m["owner"] == "ours"}
    rows = []
    for case in measured["cases"]:
        if case["group"] != "N":
            continue
        others = [a for a in case["answers"] if (case["kind"], a["method"]) not in ours and
                  a["verdict"] != "not applicable"]
        mine = [a for a in case["answers"] if (case["kind"], a["method"]) in ours]
        right = sum(a["verdict"] == "pass" for a in others)
        pairs = "–" if not mine else f'{min(a["pairs"] for a in mine):,} to ' \
                                     f'{max(a["pairs"] for a in mine):,}'
        rows.append(f'<tr><th>{escape(case["id"])}</th><td class="set-up">{escape(case["title"])}'
                    f'</td><td>{"".join(sign(a["verdict"]) for a in mine)}</td>'
                    f'<td class="number">{right} of {len(others)}</td>'
                    f'<td class="number">{pairs}</td></tr>')
    return (f'<h3 id="found">Found here: {len(rows)} cases of our own</h3><p>What once broke in '
            f'this project, and what sampling and other codes get wrong that the catalogue does '
            f'not have; where each comes from is said in <code>benchmarks/reference/catalogue/cases_found.cpp'
            f'</code> and <code>cases_found_chains.cpp</code>.</p><div class="wide"><table>'
            f'<thead><tr><th>id</th><th>set-up, and what is hard</th><th>ours</th>'
            f'<th class="number">others right</th><th class="number">pairs that ours looked at</th>'
            f'</tr></thead>'
            f'<tbody>{"".join(rows)}</tbody></table></div>')


def own_answers(measured):
    """(case, answer) of this library, over all strategies."""
    ours = {(m["kind"], m["name"]) for m in measured["methods"] if m["owner"] == "ours"}
    return [(case, a) for case in measured["cases"] for a in case["answers"]
            if (case["kind"], a["method"]) in ours]


def degrades(measured):
    """What is slow, coarse or lost with this library, from the data."""
    answers = own_answers(measured)
    failed = stability_matrix.failures_of_ours(measured)
    slow = sorted(answers, key=lambda pair: -pair[1]["pairs"])[:10]
    median = sorted(a["pairs"] for _, a in answers)[len(answers) // 2] if answers else 0
    limit = measured["defaultIterations"]
    beyond = [f'{c["id"]} ({a["method"]}, {a["pairs"]:,})' for c, a in answers
              if a["pairs"] > limit]
    coarse = [c["id"] for c in measured["cases"] if c["tolerance"] / 4096 < c["rounding"]]
    lost = [(m, name, one) for m in measured["methods"] if m["owner"] == "ours"
            for name, count in m["relations"].items() for one in count["lost"]]
    shifts = [(count["largestShift"], m["name"], name) for m in measured["methods"]
              if m["owner"] == "ours" for name, count in m["relations"].items()
              if name not in ("reversed", "split")]
    table = "".join(
        f'<tr><th>{escape(c["id"])}</th><td>{escape(a["method"])}</td>'
        f'<td class="number">{a["pairs"]:,}</td>'
        f'<td class="number">{duration(1e6 * a["seconds"])}</td>'
        f'<td class="set-up">{escape(c["title"])}</td></tr>' for c, a in slow)
    parts = ['<h3 id="degrades">Where this library degrades</h3><ul>']
    parts.append(
        f"<li><b>Wrong</b> in {len(failed)} of {len(answers)} answers"
        + (": " + ", ".join(f"{i} ({m}: {v})" for i, m, v in failed) if failed else "") + ".</li>")
    parts.append(
        f"<li><b>Slow</b> where much is near for long: the median answer looks at {median:,} pairs, "
        f"the dearest at {slow[0][1]['pairs']:,}. "
        + (f"Beyond the default limit of {limit:,} pairs, which the case raises: "
           f"{escape(', '.join(beyond))}. " if beyond else "")
        + "A face that turns over an edge at a small gap (N21) costs steps in proportion to the "
          "gap: no direction at rest in space separates the two for longer.</li>" if slow else "")
    parts.append(
        "<li><b>Lost under a relation</b>: " +
        (f"{len(lost)} variants, none of them wrong without saying so: " if lost and all(
            one["verdict"] in ("gave up", "timed out") for _, _, one in lost)
         else f"{len(lost)} variants: " if lost else "none") +
        escape("; ".join(f'{one["id"]} {name}, {m["name"]}: {one["verdict"]}'
                         for m, name, one in lost[:14])) + (" …" if len(lost) > 14 else "") +
        ".</li>")
    if shifts:
        largest = max(shifts)
        parts.append(
            f"<li><b>Times move</b> within the tolerance: at most by {largest[0]:.2g} of the window "
            f"that the tolerance allows ({escape(largest[1])}, {escape(largest[2])}). Only the order "
            f"of triangles leaves the last digits as they are.</li>")
    parts.append(
        "<li><b>No room left</b>: a reported time leaves a 4096th of the tolerance as gap. In "
        f"{escape(', '.join(coarse)) or 'no case'} that is less than the rounding of the scene, and "
        "a query that goes on from there may start overlapping; <code>ToiOptions::aim</code> = 1/2 "
        "leaves room.</li>")
    parts.append(
        "<li><b>Touching exactly</b> (E02, E03, E11) is “overlapping” at time 0 however the bodies "
        "move on; within the tolerance (their forms b) leaving, sliding and spinning are free. "
        "Which of the two a distance of 0 is, rounding decides once a frame has moved: these cases "
        "have no such relations.</li>")
    parts.append("<li><b>Deformable bodies</b> are not supported: group H is not run.</li></ul>")
    return ("".join(parts) + f'<div class="wide"><table><thead><tr><th>id</th><th>strategy</th>'
            f'<th class="number">pairs</th><th class="number">time</th><th>the ten dearest answers</th></tr></thead>'
            f'<tbody>{table}</tbody></table></div>')


def elsewhere_table(measured):
    rows = "".join(f'<tr><th>{escape(row["id"])}</th><td class="set-up">{escape(row["title"])}</td>'
                   f'<td><code>{escape(row["tested"])}</code></td></tr>'
                   for row in measured["elsewhere"])
    return (f'<details><summary>{len(measured["elsewhere"])} rows of the catalogue that are '
            f'properties, tested elsewhere, or need bodies that deform</summary><div class="wide">'
            f'<table><thead><tr><th>id</th><th>what</th><th>where</th></tr></thead>'
            f'<tbody>{rows}</tbody></table></div></details>')


def absent_of(measured):
    absent = [name for name in ("FCL", "Bullet")
              if not any(m["owner"] == name.lower() for m in measured["methods"])]
    return (f'<p class="warning">Built without {escape(" and ".join(absent))}: its columns are '
            f'missing.</p>' if absent else "")


def catalogue_section(measured):
    kinds = [kind for kind in KINDS if cases_of(measured, kind)]
    return (f'<section class="family" id="catalogue"><h2>{escape(measured["title"])}</h2>'
            f'<p>{len(measured["cases"])} scenes whose first contact time is a closed form, or of '
            f'which it is proved that there is none. An answer is right if it is not late, not '
            f'earlier than the tolerance takes at the closing speed of the case (methods that are '
            f'asked for a time: 1e-4 of the motion if that is more), and if no contact is invented. '
            f'Sampling is late by nature: its letter says that bodies overlap when it reports. '
            f'Steps of sampling are prime numbers, as many of the exact times are round ones. '
            f'Every answer is from a child process, with {measured["limit"]:g} s of processor time to give it. Point '
            f'at a cell for the answer, click on a row for all of them.</p>{absent_of(measured)}'
            f'{sums_table(measured)}{legend()}{filters_of(measured)}'
            + "".join(matrix_of(measured, kind) for kind in kinds) + relations_table(measured)
            + own_table(measured) + degrades(measured) + elsewhere_table(measured)
            + f'<p class="soft origin">{escape(chart_svg.origin_of(measured))}</p></section>')


def missing_section(family, why):
    return (f'<section id="{family}"><h2>{family.capitalize()}</h2>'
            f'<p class="soft">Not on this page: {escape(why)}.</p></section>')


def style_of_verdicts():
    return "\n".join(
        f'.v-{verdict.replace(" ", "-")} {{ background: {colour}; color: {ink}; }}'
        for verdict, (_, colour, ink) in VERDICTS.items())


def make_page(catalogue, sections):
    """Text of the page; the catalogue as measured, or None, and (family, HTML) of the others."""
    parts = [] if catalogue is None else [("catalogue", catalogue_section(catalogue))]
    parts += sections
    links = "".join(f'<a href="#{family}">{family}</a>' for family, _ in parts)
    if catalogue is not None:
        links += "".join(f'<a class="sub" href="#{name}">{name}</a>'
                         for name in ("relations", "found", "degrades"))
    data = json.dumps(catalogue or {"cases": [], "methods": []}).replace("<", "\\u003c")
    page = TEMPLATE.read_text()
    for key, value in {"CHART_STYLE": chart_svg.STYLE, "VERDICT_STYLE": style_of_verdicts(),
                       "LINKS": links, "DATA": data,
                       "SECTIONS": "\n".join(html for _, html in parts)}.items():
        page = page.replace("{{" + key + "}}", value)
    return page
