"""The pages that a folder of measurements becomes."""
import json
import sys

from plot import catalogue, chart, page, simulation

# Title, and what draws a family.
PAGES = {"chart": ("Time against accuracy", dict.fromkeys(
             ("rigid", "articulated", "closing", "budget", "step", "deformable"), chart.section_of)),
         "stability": ("Stability where methods fail", {
             "catalogue": catalogue.section_of, "simulation": simulation.section_of})}


def read(file):
    try:
        return json.loads(file.read_text())
    except (OSError, ValueError) as error:
        sys.exit(f"benchmarks/run: {file}: {error}: measure again without --draw")


def draw(verb, folder, scenes=()):
    """Pictures, of these scenes if any, and the page of what is in the folder; gives the cases that
    this library fails."""
    title, families = PAGES[verb]
    files = {family: folder / f"{family}.json" for family in families}
    measured = {family: read(file) for family, file in files.items() if file.exists()}
    known = {p["scene"] for values in measured.values() for p in values.get("points", [])}
    if not measured:
        sys.exit(f"benchmarks/run: {folder}: no measurements: name a family, or none for all")
    if unknown := [name for name in scenes if name not in known]:
        sys.exit(f"benchmarks/run: {folder}: no scene {', '.join(unknown)}: take of "
                 f"{', '.join(sorted(known))}")
    sections = {}
    for family, section_of in families.items():
        if family not in measured:
            sections[family] = page.missing(family, f"not measured: benchmarks/run {verb} {family}")
            continue
        print(f"== drawing {family}", flush=True)
        try:
            sections[family] = section_of(measured[family], folder, scenes)
        except (ArithmeticError, LookupError, TypeError, ValueError) as error:
            sys.exit(f"benchmarks/run: {files[family]} cannot be drawn ({error!r}): measure again "
                     "without --draw")
    (folder / "index.html").write_text(page.make_page(title, sections))
    print(f"\nwrote {folder / 'index.html'} and the pictures of {', '.join(measured)}")
    return [f"{i} ({method}: {verdict})" for i, method, verdict in
            catalogue.failures_of_ours(measured.get("catalogue", {"cases": [], "methods": []}))]
