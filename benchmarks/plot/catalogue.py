"""The catalogue of contact times: cases x methods, what they add up to, what has to stay the same,
and where this library degrades. Verdicts have letters and colours that are told apart without."""
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
KINDS = {"rigid": "Two rigid bodies", "articulated": "A chain of joints among obstacles"}


def methods_of(measured, kind):
    return [m for m in measured["methods"] if m["kind"] == kind]


def cases_of(measured, kind):
    return [c for c in measured["cases"] if c["kind"] == kind]


def answers_of(measured, method):
    """Of a method, in the order of the cases."""
    return [a for case in cases_of(measured, method["kind"]) for a in case["answers"]
            if a["method"] == method["name"]]


def sums_of(measured, method):
    """How often each verdict was given."""
    verdicts = [a["verdict"] for a in answers_of(measured, method)]
    return {verdict: verdicts.count(verdict) for verdict in LOOKS}


def is_ours(measured, case, answer):
    return any(m["owner"] == "ours" and (m["kind"], m["name"]) == (case["kind"], answer["method"])
               for m in measured["methods"])


def own_answers(measured):
    """(case, answer) of this library, over all strategies."""
    return [(c, a) for c in measured["cases"] for a in c["answers"] if is_ours(measured, c, a)]


def failures_of_ours(measured):
    """Cases that this library does not get right: (id, method, verdict)."""
    return [(case["id"], answer["method"], answer["verdict"])
            for case, answer in own_answers(measured) if answer["verdict"] != "pass"]


def label(method):
    return f"ours, {method['name']}" if method["owner"] == "ours" else method["name"]


def draw(measured):
    """A figure: the matrix in blocks, the rigid cases in three, and a bar a method below."""
    blocks = []
    for kind, columns in (("rigid", 3), ("articulated", 1)):
        cases = cases_of(measured, kind)
        length = max(-(-len(cases) // columns), 1)
        blocks += [(kind, cases[i:i + length]) for i in range(0, len(cases), length)]
    high = max(len(cases) for _, cases in blocks)
    figure = Figure(figsize=(15, 3.0 + 0.155 * high + 0.2 * len(measured["methods"])),
                    layout="constrained")
    widths = [len(methods_of(measured, kind)) + 2 for kind, _ in blocks]
    grid = figure.add_gridspec(2, len(blocks), width_ratios=widths,
                               height_ratios=[0.155 * high + 1.3, 0.2 * len(measured["methods"])])
    for column, (kind, cases) in enumerate(blocks):
        axes, methods = figure.add_subplot(grid[0, column]), methods_of(measured, kind)
        draw_cells(axes, [(x, y, answer["verdict"], None) for y, case in enumerate(cases)
                          for x, answer in enumerate(case["answers"])], LOOKS)
        axes.set_ylim(high - 0.4, -0.6)
        axes.set_yticks(range(len(cases)), [case["id"] for case in cases], size=7.5)
        axes.set_xticks(range(len(methods)), [label(m) for m in methods], rotation=60, ha="left",
                        rotation_mode="anchor", size=8)
        for words, method in zip(axes.get_xticklabels(), methods):
            words.set_fontweight("bold" if method["owner"] == "ours" else "normal")
    draw_sums(figure.add_subplot(grid[1, :]), measured)
    head(figure, f"{len(measured['cases'])} contact times with exact answers",
         "every case through every method; ids as in benchmarks/reference/catalogue/README.md; " +
         origin_of(measured))
    foot(figure, cell_samples(LOOKS, {v: f"{v}: {look[3]}" for v, look in LOOKS.items()}), 3)
    return figure


def draw_sums(axes, measured):
    """A bar a method: how many of its cases are what."""
    methods = {y + 0.6 * list(KINDS).index(m["kind"]): m for y, m in enumerate(measured["methods"])}
    for y, method in methods.items():
        sums, left = sums_of(measured, method), 0
        for verdict in ASKED:
            axes.barh(y, sums[verdict], left=left, height=0.8, color=LOOKS[verdict][1])
            left += sums[verdict]
        axes.text(left, y, f"  {sums['pass']} of {left} right", color=SOFT, va="center", size=8)
    axes.set(ylim=(max(methods) + 0.5, -0.5), xlim=(0, 1.5 * len(cases_of(measured, "rigid")) + 9))
    axes.set_yticks(list(methods), map(label, methods.values()), size=8)
    axes.set_xticks([])
    axes.grid(False)
    axes.spines[:].set_visible(False)


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


def filters_of(measured):
    def select(name, any_words, values):
        options = [tag("option", value, value=value) for value in values]
        return tag("select", tag("option", any_words, value=""), *options, class_=name)
    groups = {c["group"]: f"{c['group']} {c['groupTitle']}" for c in measured["cases"]}
    return page.join([
        page.chips("Groups", "group", dict(sorted(groups.items()))),
        tag("div", tag("span", "Cases"),
            tag("label", "that ", select("of-method", "any method",
                                         unique(m["name"] for m in measured["methods"])),
                " answers ", select("of-verdict", "in any way", LOOKS)),
            page.find("find in ids and set-ups", "cases"), class_="filters")])


def matrix_of(measured, kind):
    methods = methods_of(measured, kind)
    names = [tag("th", tag("div", label(m), class_="own" if m["owner"] == "ours" else None),
                 class_="upright") for m in methods]
    rows = [page.row(
        [tag("th", case["id"]), tag("td", case["title"], class_="set-up"),
         "none" if case["time"] is None else f"{case['time']:.9g}"] +
        [tag("td", sign(a["verdict"]), class_="answer", data_method=a["method"],
             data_verdict=a["verdict"], data_value=list(LOOKS).index(a["verdict"]),
             data_tip=facts_of(case, a, method)) for a, method in zip(case["answers"], methods)],
        data_group=case["group"]) for case in cases_of(measured, kind)]
    sums = tag("tfoot", tag(
        "tr", tag("th"), tag("td", "right, of those shown and asked"), tag("td"),
        *[tag("td", class_="sum", data_method=m["name"]) for m in methods]))
    return page.join([tag("h3", KINDS[kind]), page.table(
        ["id", "set-up, and what is hard", "exact time", *names], rows, "matrix", "wide field",
        [sums])])


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


def relation_cell(count):
    if not count or not count["asked"]:
        return tag("td", "–", class_="soft")
    share = count["kept"] / count["asked"]
    lost = "\n".join(f"{one['id']}, {one['variant']}: {one['verdict']}" for one in count["lost"])
    return tag("td", tag("div", f"{count['kept']} of {count['asked']}", class_="share",
                         style=f"--share:{100 * share:.1f}%"),
               data_value=share, data_tip=f"lost\n{lost}" if lost else None)


def relations_of(measured):
    names = measured["relations"]
    rows = [[tag("th", label(m)), tag("td", "rigid" if m["kind"] == "rigid" else "chains")] +
            [relation_cell(m["relations"].get(name)) for name in names]
            for m in measured["methods"]]
    return page.join([
        tag("h3", "What has to stay the same", id="relations"),
        tag("p", "Every case that a method gets right, asked again: in three other frames, the "
                 "bodies swapped, in units of 1e-3 and 1e3, the triangles in another order and "
                 "each as four, backwards, and in two queries. Counted is what stays right; point "
                 "at a number for what is lost. A method that gets little right is asked little."),
        page.table(["method", "", *names], rows, around="wide")])


def found_here(measured):
    rows = []
    for case in (c for c in measured["cases"] if c["group"] == "N"):
        mine = [a for a in case["answers"] if is_ours(measured, case, a)]
        others = [a for a in case["answers"] if a not in mine and a["verdict"] in ASKED]
        right = sum(a["verdict"] == "pass" for a in others)
        pairs = [a["pairs"] for a in mine]
        rows.append([tag("th", case["id"]), tag("td", case["title"], class_="set-up"),
                     page.join(sign(a["verdict"]) for a in mine), f"{right} of {len(others)}",
                     f"{min(pairs):,} to {max(pairs):,}" if pairs else "–"])
    return page.join([
        tag("h3", f"Found here: {len(rows)} cases of our own", id="found"),
        tag("p", "What once broke in this project, and what sampling and other codes get wrong "
                 "that the catalogue does not have; where each comes from is said in ",
            tag("code", "benchmarks/reference/catalogue/cases_found*.cpp"), "."),
        page.table(["id", "set-up, and what is hard", "ours", "others right",
                    "pairs that ours looked at"], rows, around="wide")])


def degrades(measured):
    """What is slow, coarse or lost with this library."""
    answers, failed = own_answers(measured), failures_of_ours(measured)
    slow = sorted(answers, key=lambda pair: -pair[1]["pairs"])
    limit = measured["defaultIterations"]
    beyond = [f"{c['id']} ({a['method']}, {a['pairs']:,})" for c, a in slow if a["pairs"] > limit]
    ours = [(m["name"], name, count) for m in measured["methods"] if m["owner"] == "ours"
            for name, count in m["relations"].items()]
    lost = [f"{one['id']} {name}, {method}: {one['verdict']}"
            for method, name, count in ours for one in count["lost"]]
    # A query in two parts or backwards has another time by nature.
    shift, *where = max([(count["largestShift"], method, name) for method, name, count in ours
                         if name not in ("reversed", "split")], default=(0.0,))
    coarse = [c["id"] for c in measured["cases"] if c["tolerance"] / 4096 < c["rounding"]]
    def listed(names):
        return ": " + "; ".join(names) if names else ""
    items = {
        "Wrong": f" in {len(failed)} of {len(answers)} answers" +
                 listed([f"{i} ({m}: {v})" for i, m, v in failed]),
        "Slow": f" where much is near for long: the median answer looks at "
                f"{slow[len(slow) // 2][1]['pairs'] if slow else 0:,} pairs, {len(beyond)} at more "
                f"than the default limit of {limit:,}, which the case raises" + listed(beyond),
        "Lost under a relation": f" are {len(lost)} variants" + listed(lost),
        "Times move": f" within the tolerance: at most by {shift:.2g} of the window that the "
                      f"tolerance allows ({', '.join(where)})",
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


def elsewhere_of(measured):
    rows = [[tag("th", r["id"]), tag("td", r["title"], class_="set-up"), tag("code", r["tested"])]
            for r in measured["elsewhere"]]
    return tag("details", tag("summary", f"{len(rows)} rows of the catalogue that are properties, "
                                         "tested elsewhere, or need bodies that deform"),
               page.table(["id", "what", "where"], rows, around="wide"))


def section_of(measured, folder, _=()):
    """HTML of the section; writes the picture into the folder, too."""
    save(draw(measured), folder, "catalogue")
    absent = [name for name in ("FCL", "Bullet")
              if not any(m["owner"] == name.lower() for m in measured["methods"])]
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
        *[tag("p", f"Built without {' and '.join(absent)}: its columns are missing.",
              class_="warning")] * bool(absent),
        sums_table(measured),
        tag("div", *[tag("span", sign(v), " ", tag("b", v), " ", look[3])
                     for v, look in LOOKS.items()], class_="legend"),
        filters_of(measured),
        *[matrix_of(measured, kind) for kind in KINDS if cases_of(measured, kind)],
        relations_of(measured), found_here(measured), degrades(measured), elsewhere_of(measured))
