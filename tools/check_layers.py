#!/usr/bin/env python3
"""Checks that includes point one way: a room includes only itself and rooms before it. Also checks
that no folder has more than 25 source files.

Prints file:line for every include that points the wrong way, or names no known room, and the folders
that are too full. The exit code is 1 if there is one, and 2 if ROOT is no source tree of this
project.
"""
import argparse
import collections
import pathlib
import re
import sys

ORDER = [
    "bullet_ccd",  # export.h: what every public header includes
    "bullet_ccd/math",
    "bullet_ccd/mesh",
    "bullet_ccd/hierarchy",
    "bullet_ccd/distance",
    "bullet_ccd/motion",
    "bullet_ccd/toi/*.h",  # the headers of toi/: what the rooms below it implement
    "bullet_ccd/toi/kernels",
    "bullet_ccd/toi/search",
    "bullet_ccd/toi/articulated",
    "bullet_ccd/toi",
    "bullet_ccd/convex",
    "bullet_ccd/trajectory",
    "bullet_ccd/contact",
    "bullet_ccd/deformable/kernels",
    "bullet_ccd/deformable",
    "bullet_ccd/bullet_ccd.h",  # umbrellas, each above the rooms that it includes
    "bullet_ccd/ompl",
    "bullet_ccd/ompl/examples",
    "bullet_ccd/reduce",
    "bullet_ccd/io",
    "bullet_ccd/io.h",
    "bullet_ccd/bullet/*.h",  # what a user includes
    "bullet_ccd/bullet/shapes",
    "bullet_ccd/bullet/motion",
    "bullet_ccd/bullet/kernels",
    "bullet_ccd/bullet/step",
    "bullet_ccd/bullet/soft",
    "bullet_ccd/bullet",
    "bullet_ccd/bullet.h",
    "bullet_ccd/examples",
    "grasp/hand",
    "grasp",  # grasp_types.h: the value types of the pipeline
    "grasp/approach",
    "grasp/closing",
    "grasp/force",
    "grasp/squeeze",
    "grasp/quality",
    "grasp/check",
    "grasp/planner",
    "grasp/formats",
    "grasp/grasp.h",
    "grasp/report",
    "grasp/task",
    "grasp/sim",
    "grasp/trial",
    "grasp/examples",
    "python/src",
    "python/pybullet",
    "robots/shapes",
    "tools/support",
    "tools/support/obstacles",
    "robots",
    # What tests, benchmarks, tools and examples share.
    "benchmarks/reference/scenes",
    "benchmarks/reference/oracles",
    "benchmarks/reference/queries",
    "benchmarks/reference/catalogue",
    "benchmarks/reference/audit",
    "benchmarks/reference/bullet",
    "tools/ccd_cli/files",
    "tools/ccd_cli/run",
    "tools/ccd_cli/text",
    "tools/ccd_cli/commands",
    "tools/ccd_cli",
    "tools/grasp_cli/inputs",
    "tools/grasp_cli/options",
    "tools/grasp_cli/plan",
    "tools/grasp_cli/answers",
    "tools/grasp_cli/commands",
    "tools/grasp_cli",
    "benchmarks/support",
    "benchmarks/peers",
    "benchmarks/rigid",
    "benchmarks/articulated",
    "benchmarks/closing",
    "benchmarks/deformable",
    "benchmarks/grasp",
    "benchmarks/bullet",
    "benchmarks/stability",
    "benchmarks/soak",
    "benchmarks/planning",
    "tests",  # one room: its folders mirror all of the above, and nobody includes it
]
ROOTS = tuple(sorted({room.split("/")[0] for room in ORDER}))
ADAPTER = {room for room in ORDER if re.match(r"bullet_ccd/bullet\b", room)}
BULLET_ROOMS = ADAPTER | {
    "bullet_ccd/examples",
    "grasp/examples",
    "grasp/sim",
    "grasp/trial",
    "python/pybullet",
    "benchmarks/reference/audit",
    "benchmarks/reference/bullet",
    "benchmarks/peers",
    "benchmarks/bullet",
    "benchmarks/stability",
    "benchmarks/soak",
}
COMMAND_LINES = {
    room
    for room in ORDER
    if re.match(r"robots$|tools/support|tools/.*/(options|commands)|benchmarks", room)
}
CCD_CLI = {room for room in ORDER if room.startswith("tools/ccd_cli")}
MOST_FILES = 25  # in a folder; what has more wants rooms
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]')
# Headers of other libraries, and of the one command line, which the other does not see: the rooms that
# may see them besides the tests.
FOREIGN = [
    (re.compile(r"^(Bullet|LinearMath/|bt[A-Z])"), BULLET_ROOMS),
    (re.compile(r"^(assimp/|urdf_|urdf/|console_bridge/)"), {"bullet_ccd/io"}),
    (re.compile(r"^tinyxml2"), {"bullet_ccd/io", "grasp/hand", "grasp/formats"}),
    (re.compile(r"^libqhull"), {"bullet_ccd/reduce"}),
    (re.compile(r"^(Clp|Coin)"), {"grasp/force"}),
    (re.compile(r"^kdl/"), {"grasp/task"}),
    (
        re.compile(r"^ompl/"),
        {"bullet_ccd/ompl", "bullet_ccd/ompl/examples", "grasp/task", "benchmarks/planning"},
    ),
    (re.compile(r"^fcl/"), {"benchmarks/peers"}),
    (re.compile(r"^CLI/"), COMMAND_LINES),
    (re.compile(r"^tools/ccd_cli/"), CCD_CLI | {"benchmarks/deformable"}),
    (re.compile(r"^(gtest|gmock)/"), set()),
]


def room_of(path):
    """The room of a file: itself, its folder, or the nearest folder above it that is a room."""
    folder = path.parent
    if str(path) in ORDER:
        return str(path)
    if f"{folder}/*{path.suffix}" in ORDER:
        return f"{folder}/*{path.suffix}"
    while str(folder) not in ORDER and folder.parent != folder:
        folder = folder.parent
    return str(folder)


def check(root):
    """Returns one message for every include that points the wrong way, and every folder too full."""
    problems = []
    paths = sorted(path for folder in ROOTS for path in (root / folder).rglob("*")
                   if path.suffix in (".h", ".cpp"))
    for folder, count in collections.Counter(path.parent for path in paths).items():
        if count > MOST_FILES:
            problems.append(f"{folder.relative_to(root)}: {count} files: divide it into rooms of at "
                            f"most {MOST_FILES}")
    for path in paths:
        room = room_of(path.relative_to(root))
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            included = match.group(1)
            where = f"{path.relative_to(root)}:{number}"
            for pattern, rooms in FOREIGN:
                if pattern.match(included) and room not in rooms and room != "tests":
                    problems.append(f"{where}: {room} must not include {included}")
            if not included.startswith(tuple(f"{folder}/" for folder in ROOTS)):
                continue
            target = room_of(pathlib.PurePosixPath(included))
            if room not in ORDER or target not in ORDER:
                problems.append(f"{where}: {room} or {target} is not a known room")
            elif ORDER.index(target) > ORDER.index(room):
                problems.append(f"{where}: {room} must not include {target}")
            elif target in ADAPTER and room not in BULLET_ROOMS | {"tests"}:
                problems.append(f"{where}: {room} must not see the Bullet adapter")
    return problems


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", metavar="ROOT", nargs="?", type=pathlib.Path, default=".",
                        help="the source tree (default: this folder)")
    root = parser.parse_args().root.resolve()
    if not (root / "bullet_ccd").is_dir():
        parser.error(f"{root}: has no folder bullet_ccd: give the root of the source tree")
    problems = check(root)
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
