"""The catalogue of contact times: cases x methods, what they add up to, what has to stay the same,
and where this library degrades. A letter for each verdict, colours that the colour-blind can tell."""
from plot import page
from plot.page import tag
from plot.pictures import Figure, SOFT, cell_samples, draw_cells, foot, head
from plot.words import duration, origin_of, power, unique

# Verdict: letter, colour of the cell, colour of the letter.
LOOKS = {
    "pass": ("✓", "#cfe8da", "#1b5e3b"), "inaccurate": ("E", "#f3dd6d", "#3d3400"),
    "late": ("L", "#f0a63c", "#3a2100"), "missed": ("M", "#c8451b", "#ffffff"),
    "false contact": ("F", "#a04c93", "#ffffff"), "gave up": ("G", "#4c86c6", "#ffffff"),
    "crashed": ("C", "#101418", "#ffffff"), "timed out": ("T", "#5f6770", "#ffffff"),
    "not applicable": ("–", "none", "#8a939e"),
}
MEANINGS = {
    "pass": "right", "inaccurate": "earlier than the tolerance explains",
    "late": "after the contact: bodies overlap", "missed": "no contact found",
    "false contact": "a contact that is not there", "gave up": "says that it has no answer",
    "crashed": "ended its process", "timed out": "no answer within the limit",
    "not applicable": "cannot be asked: not convex, or turns",
}
ASKED = [verdict for verdict in LOOKS if verdict != "not applicable"]
KINDS = {"rigid": "Two rigid bodies", "articulated": "A chain of joints among obstacles"}
RELATIONS = {
    "moved": "the whole scene in three other frames",
    "swapped": "A is B",
    "rescaled": "lengths and tolerance in units of 1e-3 and 1e3",
    "permuted": "triangles in another order, from another corner",
    "subdivided": "every triangle as four",
    "reversed": "backwards: from the end, or from just before the contact, to the start",
    "split": "two queries, at several times, one just before the contact",
}


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
    verdicts = [a["verdict"] for a in answers_of(measured, kind, method)]
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
    foot(figure, cell_samples(LOOKS, {v: f"{v}: {m}" for v, m in MEANINGS.items()}), 3)
    return figure


def draw_sums(axes, measured):
    """A bar a method: how many of its cases are what."""
    methods = {y + 0.6 * k: m for k, kind in enumerate(KINDS) for y, m in enumerate(measured["methods"])
               if m["kind"] == kind}
    for y, method in methods.items():
        sums, left = sums_of(measured, method["kind"], method["name"]), 0
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
    letter, colour, ink = LOOKS[verdict]
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
    for kind in KINDS:
        for method in methods_of(measured, kind):
            sums = sums_of(measured, kind, method["name"])
            bar = [tag("i", style=f"flex:{sums[v]};background:{LOOKS[v][1]}",
                       title=f"{sums[v]} {v}") for v in ASKED if sums[v]]
            seconds = sum(a["seconds"] for a in answers_of(measured, kind, method["name"])
                          if a["verdict"] in ASKED)
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
    meaning = "; ".join(f"{name}: {RELATIONS.get(name, '')}" for name in names)
    return page.join([
        tag("h3", "What has to stay the same", id="relations"),
        tag("p", f"Every case that a method gets right, asked again: {meaning}. Counted is what "
                 "stays right; point at a number for what is lost. A method that gets little right "
                 "is asked little."),
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
        tag("p", "What once broke in this project, and what sampling and other codes get wrong that "
                 "the catalogue does not have; where each comes from is said in ",
            tag("code", "benchmarks/reference/catalogue/cases_found*.cpp"), "."),
        page.table(["id", "set-up, and what is hard", "ours", "others right",
                    "pairs that ours looked at"], rows, around="wide")])


def degrades(measured):
    """What is slow, coarse or lost with this library, from the data."""
    answers, failed = own_answers(measured), failures_of_ours(measured)
    slow = sorted(answers, key=lambda pair: -pair[1]["pairs"])[:10]
    items = [("Wrong", f" in {len(failed)} of {len(answers)} answers" +
              (": " + ", ".join(f"{i} ({m}: {v})" for i, m, v in failed) if failed else "") + ".")]
    if slow:
        median = sorted(a["pairs"] for _, a in answers)[len(answers) // 2]
        limit = measured["defaultIterations"]
        beyond = ", ".join(f"{c['id']} ({a['method']}, {a['pairs']:,})" for c, a in answers
                           if a["pairs"] > limit)
        items.append((
            "Slow", f" where much is near for long: the median answer looks at {median:,} pairs, the "
            f"dearest at {slow[0][1]['pairs']:,}. " +
            (f"Beyond the default limit of {limit:,} pairs, which the case raises: {beyond}. "
             if beyond else "") +
            "A face that turns over an edge at a small gap (N21) costs steps in proportion to the "
            "gap: no direction at rest in space separates the two for longer."))
    ours = [(m, name, count) for m in measured["methods"] if m["owner"] == "ours"
            for name, count in m["relations"].items()]
    lost = [(one["verdict"], f"{one['id']} {name}, {m['name']}: {one['verdict']}")
            for m, name, count in ours for one in count["lost"]]
    is_said = all(verdict in ("gave up", "timed out") for verdict, _ in lost)
    items.append(("Lost under a relation", ": " + (
        f"{len(lost)} variants{', none of them wrong without saying so' if is_said else ''}: " +
        "; ".join(words for _, words in lost[:14]) + (" …" if len(lost) > 14 else "")
        if lost else "none") + "."))
    shifts = [(count["largestShift"], m["name"], name) for m, name, count in ours
              if name not in ("reversed", "split")]
    if shifts:
        shift, *where = max(shifts)
        items.append(("Times move", f" within the tolerance: at most by {shift:.2g} of the window "
                      f"that the tolerance allows ({', '.join(where)}). Only the order of triangles "
                      "leaves the last digits as they are."))
    coarse = [c["id"] for c in measured["cases"] if c["tolerance"] / 4096 < c["rounding"]]
    items += [
        ("No room left", ": a reported time leaves a 4096th of the tolerance as gap. In "
         f"{', '.join(coarse) or 'no case'} that is less than the rounding of the scene, and a "
         "query that goes on from there may start overlapping; ToiOptions::aim = 1/2 leaves room."),
        ("Touching exactly", " (E02, E03, E11) is “overlapping” at time 0 however the bodies move "
         "on; within the tolerance (their forms b) leaving, sliding and spinning are free. Which of "
         "the two a distance of 0 is, rounding decides once a frame has moved: these cases have no "
         "such relations."),
        ("Deformable bodies", " are not supported: group H is not run.")]
    rows = [[tag("th", c["id"]), a["method"], (f"{a['pairs']:,}", a["pairs"]),
             (duration(1e6 * a["seconds"]), a["seconds"]), tag("td", c["title"], class_="set-up")]
            for c, a in slow]
    return page.join([
        tag("h3", "Where this library degrades", id="degrades"),
        tag("ul", *[tag("li", tag("b", what), words) for what, words in items]),
        page.table(["id", "strategy", "pairs", "time", "the ten dearest answers"], rows,
                   around="wide")])


def elsewhere_of(measured):
    rows = [[tag("th", r["id"]), tag("td", r["title"], class_="set-up"), tag("code", r["tested"])]
            for r in measured["elsewhere"]]
    return tag("details", tag("summary", f"{len(rows)} rows of the catalogue that are properties, "
                                         "tested elsewhere, or need bodies that deform"),
               page.table(["id", "what", "where"], rows, around="wide"))


def section_of(measured):
    absent = [name for name in ("FCL", "Bullet")
              if not any(m["owner"] == name.lower() for m in measured["methods"])]
    return page.section(
        measured,
        tag("p", f"{len(measured['cases'])} scenes whose first contact time is a closed form, or of "
                 "which it is proved that there is none. An answer is right if it is not late, not "
                 "earlier than the tolerance takes at the closing speed of the case (methods that "
                 "are asked for a time: 1e-4 of the motion if that is more), and if no contact is "
                 "invented. Sampling is late by nature: its letter says that bodies overlap when it "
                 "reports. Steps of sampling are prime numbers, as many of the exact times are round "
                 "ones. Every answer is from a child process, with "
                 f"{measured['limit']:g} s of processor time to give it. Point at a cell for the "
                 "answer, click on a row for all of them."),
        *[tag("p", f"Built without {' and '.join(absent)}: its columns are missing.",
              class_="warning")] * bool(absent),
        sums_table(measured),
        tag("div", *[tag("span", sign(v), " ", tag("b", v), f" {meaning}")
                     for v, meaning in MEANINGS.items()], class_="legend"),
        filters_of(measured),
        *[matrix_of(measured, kind) for kind in KINDS if cases_of(measured, kind)],
        relations_of(measured), found_here(measured), degrades(measured), elsewhere_of(measured))


def print_sums(measured):
    for kind, words in KINDS.items():
        print(f"\n{words}:")
        for method in methods_of(measured, kind):
            sums = sums_of(measured, kind, method["name"])
            lost = sum(len(count["lost"]) for count in method["relations"].values())
            asked = sum(count["asked"] for count in method["relations"].values())
            print(f"  {label(method):<22} {', '.join(f'{n} {v}' for v, n in sums.items() if n)}; "
                  f"relations kept {asked - lost} of {asked}")
