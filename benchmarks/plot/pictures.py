"""What all pictures share: matplotlib's settings, colours, cells with letters, and
files: a PNG, and an SVG that may stand in a page, where what has a name has a tip."""
import io
import math
import re
import sys
from html import escape

try:
    import matplotlib
except ImportError:
    raise ImportError(f"charts need matplotlib, which {sys.executable} has not (Debian: apt-get "
                      "install python3-matplotlib)") from None
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle


INK, SOFT, GRID, FRAME, PAPER = "#1d232b", "#5d6773", "#e6e9ed", "#a8b0ba", "#ffffff"

# Whose a method is shows in its hue: blue ours, violet ours sampled, orange FCL, green Bullet.
HUES = {
    "ours": ["#1c64d9", "#0aa5c9", "#6d4fe0", "#138a72", "#8093ad", "#b9739f", "#3f8fb5"],
    "sampled": ["#a636b8", "#e0559d"],
    "fcl": ["#dd5a12", "#e5a50a"],
    "bullet": ["#2f9e44", "#7cae12", "#a1702c"],
}

matplotlib.rcParams.update({
    "svg.fonttype": "none", "text.parse_math": False, "font.size": 9, "text.color": INK,
    "axes.labelcolor": SOFT, "axes.edgecolor": FRAME, "axes.titlelocation": "left",
    "axes.titlesize": 10, "axes.titleweight": "bold", "axes.grid": True, "axes.axisbelow": True,
    "grid.color": GRID, "xtick.major.size": 0, "ytick.major.size": 0, "xtick.labelcolor": INK,
    "ytick.labelcolor": INK, "xtick.color": GRID, "ytick.color": GRID, "legend.frameon": False})


def svg(figure, name, tips=None):
    """Text of an SVG; its groups keep the names that they were given, with the tips for those."""
    def open_group(match):
        # Matplotlib's own names are the same in every picture of a page.
        group = f'<g id="{match[1]}">' if "-" in match[1] else "<g>"
        words = (tips or {}).get(match[1])
        return group + (f"<title>{escape(words)}</title>" if words else "")
    stream = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": name}):
        figure.savefig(stream, format="svg", bbox_inches="tight", pad_inches=0.12,
                       metadata=dict.fromkeys(["Creator", "Date", "Format", "Type"]))
    text = stream.getvalue()
    text = re.sub(r'<g id="([^"]*)">', open_group, text[text.index("<svg"):])
    return text.replace("<svg", f'<svg class="chart" role="img" aria-label="{escape(name)}"', 1)


def save(figure, folder, name, tips=None):
    """Writes NAME.svg and NAME.png; gives the SVG for the page."""
    text = svg(figure, name, tips)
    (folder / f"{name}.svg").write_text(text)
    figure.savefig(folder / f"{name}.png", dpi=144, bbox_inches="tight", pad_inches=0.12)
    return text


def head(figure, title, origin):
    """A title and what measured it, above the panels."""
    high = figure.get_figheight()
    figure.text(0.006, 1.0 + 0.12 / high, origin, size=9, color=SOFT, va="bottom")
    figure.text(0.006, 1.0 + 0.36 / high, title, size=15.5, weight="bold", va="bottom")


def foot(figure, handles, columns, left=0.0):
    """A legend below the panels."""
    figure.legend(handles=handles, ncols=columns, loc="upper left", bbox_to_anchor=(left, 0),
                  fontsize=9.5, columnspacing=2.5, labelspacing=0.55)


def sample(label, **looks):
    """What a line or a mark looks like, for a legend."""
    return Line2D([], [], label=label, **looks)


def decades(values):
    """Exponents of the powers of ten from below to above all values."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return range(low, max(high, low + 1) + 1)


def draw_cells(axes, cells, looks):
    """A cell with a letter for each (column, row, verdict, name or None); rows go down."""
    for column, row, verdict, name in cells:
        letter, fill, ink, *_ = looks[verdict]
        axes.add_patch(Rectangle((column - 0.46, row - 0.43), 0.92, 0.86, facecolor=fill, gid=name))
        axes.text(column, row, letter, size=7, color=ink, ha="center", va="center_baseline")
    columns, rows = [c for c, *_ in cells], [r for _, r, *_ in cells]
    axes.set(xlim=(min(columns) - 0.6, max(columns) + 0.6), ylim=(max(rows) + 0.6, min(rows) - 0.6))
    axes.xaxis.tick_top()
    axes.grid(False)
    axes.spines[:].set_visible(False)


def cell_samples(looks, words):
    """Cells for a legend; words {verdict: what it means}."""
    return [Patch(facecolor=looks[verdict][1], edgecolor=FRAME, linewidth=0.5,
                  label=f"{looks[verdict][0]}  {meaning}") for verdict, meaning in words.items()]
