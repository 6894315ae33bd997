"""A page that needs no other file: elements of HTML, tables, a filter, and what is around them."""
import re
from html import escape
from pathlib import Path

from plot.words import origin_of

NUMBER = re.compile(r"(none|[–≤ ]*[-\d.,]*(e-?\d+)?( ?(%|s|ms|µs|ns))?)$")


class Html(str):
    """Text that is HTML already."""


def join(parts):
    return Html("".join(part if isinstance(part, Html) else escape(str(part)) for part in parts))


def tag(name, *children, **attributes):
    """An element; class_ is class, data_kind is data-kind, and None is left out."""
    words = "".join(f' {key.rstrip("_").replace("_", "-")}="{escape(str(value))}"'
                    for key, value in attributes.items() if value is not None)
    return Html(f"<{name}{words}>{join(children)}</{name}>")


def cell(value):
    """A cell of a table; a pair is what is read and what is sorted by."""
    if isinstance(value, Html) and value.startswith(("<td", "<th")):
        return value
    words, key = value if isinstance(value, tuple) else (value, None)
    kind = "number" if not isinstance(words, Html) and NUMBER.match(str(words)) else None
    return tag("td", words, class_=kind, data_value=key)


def row(cells, **attributes):
    return tag("tr", *map(cell, cells), **attributes)


def table(head, rows, kind="", around="wide tall", foot=()):
    """Headings, and rows as lists of cells or as elements."""
    heads = [h if isinstance(h, Html) else tag("th", h) for h in head]
    body = [r if isinstance(r, Html) else row(r) for r in rows]
    return tag("div", tag("table", tag("thead", tag("tr", *heads)), tag("tbody", *body), *foot,
                          class_=kind), class_=around)


def find(placeholder, what):
    """A field for words that rows of tables have to contain, and how many WHAT are shown."""
    return join([tag("input", type="search", class_="find", placeholder=placeholder),
                 tag("span", class_="count", data_what=what)])


def section(measured, *parts):
    return tag("section", tag("h2", measured["title"]), *parts,
               tag("p", origin_of(measured), class_="soft origin"), id=measured["family"])


def missing(family, why):
    return tag("section", tag("h2", family.capitalize()),
               tag("p", f"Not on this page: {why}.", class_="soft"), id=family)


def make_page(title, sections):
    """Text of the page of sections {id: HTML}; their headings with an id are in its head, too."""
    style, script = (Path(__file__).with_name(f"page.{kind}").read_text() for kind in ("css", "js"))
    links = [tag("a", name, href=f"#{name}") for name in sections] + [
        tag("a", name, href=f"#{name}", class_="sub")
        for html in sections.values() for name in re.findall('<h3 id="([^"]*)"', html)]
    return "<!DOCTYPE html>\n" + tag(
        "html",
        tag("head", Html('<meta charset="utf-8"><meta name="viewport" content="width=device-width, '
                         'initial-scale=1"><meta name="color-scheme" content="light dark">'
                         '<link rel="icon" href="data:,">'), tag("title", title),
            tag("style", Html(style))),
        tag("body", tag("header", tag("h1", title), *links), tag("main", *sections.values()),
            tag("div", id="tip", class_="off", role="status"), tag("script", Html(script))),
        lang="en") + "\n"
