"""Statistics, numbers as text, and tables for the stability charts."""
import math
from html import escape


def quantile(values, share):
    """The value that this share of all is not above; None for none."""
    if not values:
        return None
    ordered = sorted(values)
    return ordered[math.ceil(share * (len(ordered) - 1) - 1e-9)]


def number(value, digits=2):
    """With so many digits that count: 110, 0.018, 2e-5."""
    if value is None:
        return "–"
    if 0 < abs(value) < 1e-3:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return f"{float(mantissa):g}e{int(exponent)}"
    return f"{float(f'{value:.{digits}g}'):g}".replace("e+0", "e")


def percent(part, whole):
    return "–" if not whole else f"{100 * part / whole:.0f} %"


def table(head, rows):
    cells = "".join(f"<th>{escape(h)}</th>" for h in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(str(c))}</td>" for c in row) + "</tr>"
                   for row in rows)
    return (f'<div class="wide tall"><table><thead><tr>{cells}</tr></thead>'
            f'<tbody>{body}</tbody></table></div>')
