#!/usr/bin/python3
"""Runs situations of PyBullet's examples in a real PyBullet, with and without the plugin.

A row is a situation: what it is counted by, that number in stock PyBullet and with the plugin, and
what a step takes: the median over the runs of the mean of its steps, stock and plugin in turn. Needs
the package of the preset python on PYTHONPATH. PyBullet is that of $BULLET_CCD_PYBULLET (default:
../shared/peers/pybullet beside the checkout) or an installed one; meshes and robots come from
$BULLET_CCD_TEST_DATA (default: ../shared/data), and situations whose files are absent are left out.

The exit code is 1 if with the plugin anything was counted that must not happen.

Example:
  PYTHONPATH=build/python/python benchmarks/bullet/pybullet_table.py --runs 3
"""
import argparse
import statistics
import sys
import tempfile
from pathlib import Path

import bullet_ccd.pybullet

sys.path.append(str(Path(__file__).resolve().parents[1] / "reference/bullet"))
import pybullet_scenes as scenes  # noqa: E402
from pybullet_situations import DATA, SITUATIONS, play, silence  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=3, help="of each situation (default: 3)")
    parser.add_argument("--only", default="", metavar="TEXT", help="situations with this in their name")
    options = parser.parse_args()
    if options.runs < 1:
        parser.error("--runs must be at least 1")
    if not any(options.only in title for title in SITUATIONS):
        parser.error(f"--only {options.only}: no such situation; there are {', '.join(SITUATIONS)}")

    failed = False
    with tempfile.TemporaryDirectory() as name:
        try:
            p = scenes.find(Path(name))
        except ImportError as error:
            parser.error(str(error))
        print(f"{'situation':22}{'stock':>6}{'plugin':>8}{'stock ms':>10}{'plugin ms':>11}{'ratio':>7}"
              f"{'impacts':>9}")
        for title, (situation, files, must_be_zero) in SITUATIONS.items():
            if options.only not in title:
                continue
            if files is not None and not (DATA / files).is_dir():
                print(f"{title:22}  left out: {DATA / files} is not there")
                continue
            stock, plugin = [], []
            for _ in range(options.runs):
                with silence():
                    stock.append(play(p, None, situation, Path(name)))
                    plugin.append(play(p, bullet_ccd.pybullet.enable, situation, Path(name)))
            times = [statistics.median(run[1] for run in runs) for runs in (stock, plugin)]
            failed = failed or (must_be_zero and plugin[0][0] != 0)
            print(f"{title:22}{stock[0][0]:6}{plugin[0][0]:8}{times[0]:10.3f}{times[1]:11.3f}"
                  f"{times[1] / times[0]:7.2f}{plugin[0][2]:9}", flush=True)
        print("\nWhat the numbers count:")
        told = set()
        for title, (situation, _, _) in SITUATIONS.items():
            if situation.__doc__ not in told:
                print(f"  {title}: {' '.join(situation.__doc__.split())}")
            told.add(situation.__doc__)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
