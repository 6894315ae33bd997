"""Stability where methods fail: pictures and one page of what is in a folder."""
import json
import sys

from plot import catalogue, grasps, page, simulation
from plot.pictures import save

FAMILIES = ["catalogue", "grasps", "simulation"]


def read(file):
    try:
        return json.loads(file.read_text()) if file.exists() else None
    except (OSError, ValueError) as error:
        sys.exit(f"stability: {file}: {error!r}: measure again without --draw")


def section_of(measured, family, folder):
    """HTML of a family, or that it is missing; writes its pictures into the folder."""
    if measured is None:
        return page.missing(family, f"not measured: benchmarks/run stability {family}")
    print(f"== drawing {family}", flush=True)
    if family == "catalogue":
        save(catalogue.draw(measured), folder, family)
        catalogue.print_sums(measured)
        return catalogue.section_of(measured)
    return {"grasps": grasps, "simulation": simulation}[family].section_of(measured, folder)


def make_page(sections):
    return page.make_page("Stability where methods fail", sections,
                          [name for name in ("relations", "found", "degrades")
                           if f'id="{name}"' in sections["catalogue"]])


def draw_folder(folder):
    """Pictures and the page of what is in the folder; gives the cases that this library fails."""
    measured = {family: read(folder / f"{family}.json") for family in FAMILIES}
    if not any(measured.values()):
        sys.exit(f"stability: {folder}: no measurements: name a family, or none for all")
    (folder / "index.html").write_text(make_page(
        {family: section_of(values, family, folder) for family, values in measured.items()}))
    print(f"\nwrote {folder / 'index.html'}")
    return [] if measured["catalogue"] is None else [
        f"{i} ({method}: {verdict})"
        for i, method, verdict in catalogue.failures_of_ours(measured["catalogue"])]
