"""The catalogue of contact times: cases x methods, what they add up to, and where this library
degrades. Verdicts have letters and colours that are told apart without."""
from plot import page
from plot.page import tag
from plot.pictures import SOFT, Figure, cell_samples, draw_cells, foot, head, save
from plot.words import duration, origin_of, power, unique

# Verdict: letter, colour of the cell, colour of the letter, meaning.
LOOKS = {
    "pass": ("✓", "#cfe8da", "#1b5e3b", "right"),
    "inaccurate": ("E", "#f3dd6d", "#3d3400", "earlier than the tolerance explains"),
    "late": ("L", "#f0a63c", "#3a2100", "after the contact: bodies overlap"),
    "missed": ("M", "#c8451b", "#ffffff", "no contact found"),
    "false contact": ("F", "#a04c93", "#ffffff", "a contact that is not there"),
    "gave up": ("G", "#4c86c6", "#ffffff", "says that it has no answer"),
    "crashed": ("C", "#101418", "#ffffff", "ended its process"),
    "timed out": ("T", "#5f6770", "#ffffff", "no answer within the limit"),
    "not applicable": ("–", "none", "#8a939e", "cannot be asked: not convex, or turns"),
}
ASKED = [verdict for verdict in LOOKS if verdict != "not applicable"]


def answers_of(measured, method):
    """Of a method, in the order of the cases."""
    return [a for case in measured["cases"] for a in case["answers"]
            if a["method"] == method["name"]]


def sums_of(measured, method):
    """How often each verdict was given."""
    verdicts = [a["verdict"] for a in answers_of(measured, method)]
    return {verdict: verdicts.count(verdict) for verdict in LOOKS}


def own_answers(measured):
    """(case, answer) of this library, over all strategies."""
    own = [m["name"] for m in measured["methods"] if m["owner"] == "ours"]
    return [(c, a) for c in measured["cases"] for a in c["answers"] if a["method"] in own]


def failures_of_ours(measured):
    """Cases that this library does not get right: (id, method, verdict)."""
    return [(case["id"], answer["method"], answer["verdict"])
            for case, answer in own_answers(measured) if answer["verdict"] != "pass"]


def label(method):
    return f"ours, {method['name']}" if method["owner"] == "ours" else method["name"]


def draw(measured):
    """A figure: the matrix in three blocks."""
    cases, methods = measured["cases"], measured["methods"]
    high = max(-(-len(cases) // 3), 1)
    figure = Figure(figsize=(15, 2.6 + 0.155 * high), layout="constrained")
    blocks = [cases[i:i + high] for i in range(0, len(cases), high)]
    for axes, block in zip(figure.subplots(1, len(blocks), squeeze=False)[0], blocks):
        draw_cells(axes, [(x, y, answer["verdict"], None) for y, case in enumerate(block)
                          for x, answer in enumerate(case["answers"])], LOOKS)
        axes.set_ylim(high - 0.4, -0.6)
        axes.set_yticks(range(len(block)), [case["id"] for case in block], size=7.5)
        axes.set_xticks(range(len(methods)), [label(m) for m in methods], rotation=60, ha="left",
                        rotation_mode="anchor", size=8)
        for words, method in zip(axes.get_xticklabels(), methods):
            words.set_fontweight("bold" if method["owner"] == "ours" else "normal")
    head(figure, f"{len(cases)} contact times with exact answers",
         "every case through every method; ids as in benchmarks/reference/catalogue/README.md; " +
         origin_of(measured))
    foot(figure, cell_samples(LOOKS, {v: f"{v}: {look[3]}" for v, look in LOOKS.items()}), 3)
    return figure


def sign(verdict):
    letter, colour, ink, _ = LOOKS[verdict]
    return tag("span", letter, class_="cell", style=f"background:{colour};color:{ink}")


def facts_of(case, answer, method):
    """What is known about an answer, in lines."""
    facts = [("exact time", "no contact" if case["time"] is None else case["time"])]
    if answer["verdict"] == "not applicable":
        facts.append(("cannot be asked", answer["note"]))
    else:
        time = answer.get("time")
        facts.append(("reported", "no contact" if time is None else time))
        if case["time"] is not None and answer.get("error") is not None:
            facts.append(("error", power(answer["error"], 2)))
        facts.append(("tolerance", case["tolerance"]))
        if case["time"] is None:
            facts.append(("smallest distance", f"at least {case['clearance']:.6g}"))
        facts.append(("took", duration(1e6 * answer["seconds"])))
        if answer["pairs"] > 0:
            facts.append(("pairs looked at", f"{answer['pairs']:,}"))
    return "\n".join([f"{case['id']}, {label(method)}: {answer['verdict']}", case["title"],
                      method["setting"]] + [f"{name}\t{value}" for name, value in facts])


def matrix_of(measured):
    methods = measured["methods"]
    names = [tag("th", tag("div", label(m), class_="own" if m["owner"] == "ours" else None),
                 class_="upright") for m in methods]
    rows = [page.row(
        [tag("th", case["id"]), tag("td", case["title"], class_="set-up"),
         "none" if case["time"] is None else f"{case['time']:.9g}"] +
        [tag("td", sign(a["verdict"]), class_="answer", data_words=f"{m['name']} {a['verdict']}",
             data_value=list(LOOKS).index(a["verdict"]), data_tip=facts_of(case, a, m))
         for a, m in zip(case["answers"], methods)]) for case in measured["cases"]]
    return page.table(["id", "set-up, and what is hard", "exact time", *names], rows, "matrix",
                      "wide field")


def sums_table(measured):
    rows = []
    for method in measured["methods"]:
        sums = sums_of(measured, method)
        bar = [tag("i", style=f"flex:{sums[v]};background:{LOOKS[v][1]}", title=f"{sums[v]} {v}")
               for v in ASKED if sums[v]]
        seconds = sum(a["seconds"] for a in answers_of(measured, method) if a["verdict"] in ASKED)
        rows.append([tag("th", label(method)), tag("td", method["setting"], class_="soft"),
                     tag("div", *bar, class_="bar"), sum(sums[v] for v in ASKED),
                     *[sums[v] or "–" for v in ASKED], (duration(1e6 * seconds), seconds)])
    return page.table(["method", "setting", "share", "asked", *ASKED, "time"], rows, "sums", "wide")


def degrades(measured):
    """What is slow or coarse with this library."""
    answers, failed = own_answers(measured), failures_of_ours(measured)
    slow = sorted(answers, key=lambda pair: -pair[1]["pairs"])
    longest = [f"{c['id']} ({a['method']}, {a['pairs']:,})" for c, a in slow[:3]]
    coarse = [c["id"] for c in measured["cases"] if c["tolerance"] / 4096 < c["rounding"]]
    def listed(names):
        return ": " + "; ".join(names) if names else ""
    items = {
        "Wrong": f" in {len(failed)} of {len(answers)} answers" +
                 listed([f"{i} ({m}: {v})" for i, m, v in failed]),
        "Slow": f" where much is near for long: the median answer looks at "
                f"{slow[len(slow) // 2][1]['pairs'] if slow else 0:,} pairs, most of all" +
                listed(longest),
        "No room left": " where the gap at a reported time, a 4096th of the tolerance, is less "
                        f"than the rounding of the scene: in {len(coarse)} cases" + listed(coarse)}
    rows = [[tag("th", c["id"]), a["method"], (f"{a['pairs']:,}", a["pairs"]),
             (duration(1e6 * a["seconds"]), a["seconds"]), tag("td", c["title"], class_="set-up")]
            for c, a in slow[:10]]
    return page.join([
        tag("h3", "Where this library degrades", id="degrades"),
        tag("ul", *[tag("li", tag("b", what), words, ".") for what, words in items.items()]),
        page.table(["id", "strategy", "pairs", "time", "the ten dearest answers"], rows,
                   around="wide")])


def section_of(measured, folder, _=()):
    """HTML of the section; writes the picture into the folder, too."""
    save(draw(measured), folder, "catalogue")
    return page.section(
        measured,
        tag("p", f"{len(measured['cases'])} scenes whose first contact time is a closed form, or "
                 "of which it is proved that there is none. An answer is right if it is not late, "
                 "not earlier than the tolerance takes at its closing speed (methods that are "
                 "asked for a time: 1e-4 of the motion if that is more), and if no contact is "
                 "invented. Sampling is late by nature, as bodies overlap when it reports; its "
                 "steps are prime numbers, as many of the exact times are round ones. Every answer "
                 f"is from a child process, with {measured['limit']:g} s of processor time to give "
                 "it. Point at a cell for the answer, click on a row for all of them."),
        sums_table(measured),
        tag("div", *[tag("span", sign(v), " ", tag("b", v), " ", look[3])
                     for v, look in LOOKS.items()], class_="legend"),
        tag("div", page.find("ids, set-ups, verdicts", "cases"), class_="filters"),
        matrix_of(measured),
        degrades(measured))
