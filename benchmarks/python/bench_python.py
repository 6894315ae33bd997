#!/usr/bin/python3
"""What Python costs: batches and single calls of the package against the program bullet-ccd, on recorded
queries of the bunny. Answers are compared first. All run in turn on one processor, in rounds of ten passes over
all queries; times are processor time of a pass, medians over the rounds (and in brackets the least).

    bench_python.py BULLET_CCD_PROGRAM DATA_FOLDER [ROUNDS]

The exit code is 1 if one answer differs.
"""
import csv
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import bullet_ccd as ccd

PROGRAM, DATA = Path(sys.argv[1]), Path(sys.argv[2])
ROUNDS = int(sys.argv[3]) if len(sys.argv) > 3 else 9
PASSES = 10
TOLERANCE = 1e-4  # [unit of the meshes]
SIZE = 100.0  # less than the bunny, whose motions are longer than itself
MESH = DATA / "motions" / "c2a_torusknot" / "bunny_noholes.ply"


def poses(rows, name):
    """n x 4 x 4 from quaternions and translations."""
    w, x, y, z, *place = (np.array([float(row[f"{name}_{key}"]) for row in rows])
                          for key in ("qw", "qx", "qy", "qz", "tx", "ty", "tz"))
    result = np.tile(np.eye(4), (len(rows), 1, 1))
    result[:, :3, :3] = np.moveaxis(np.array(
        [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]), 2, 0)
    result[:, :3, 3] = np.array(place).T
    return result


def program(queries, folder, passes):
    """Times of contact, and the microseconds of processor time that the program took."""
    before = os.times()
    subprocess.run([PROGRAM, "batch", MESH, MESH, queries, "-o", folder / "out.csv", "--tolerance",
                    str(TOLERANCE), "--jobs", "1", "--repeat", str(passes)], check=True, capture_output=True)
    micros = 1e6 * sum(os.times()[2:4]) - 1e6 * sum(before[2:4])
    with open(folder / "out.csv", encoding="utf-8") as file:
        return [float(row["toi"]) for row in csv.DictReader(file)], micros


def of_a_pass(work):
    """Microseconds of processor time."""
    begin = time.process_time()
    for _ in range(PASSES):
        work()
    return 1e6 * (time.process_time() - begin) / PASSES


def shown(ours, theirs):
    return f"{statistics.median(ours) / statistics.median(theirs):.3f} ({min(ours) / min(theirs):.3f})"


def main():
    os.sched_setaffinity(0, {0})
    mesh, good = ccd.Mesh.load(MESH), True
    for name in ("bunny_ident", "bunny_ani"):
        queries = DATA / "rigid_queries" / "poses" / f"{name}.csv"
        with open(queries, encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        a, b = (ccd.Motions.between(poses(rows, f"{body}0"), poses(rows, f"{body}1")) for body in "ab")
        pairs, c, batch, single = list(zip(a, b)), [], [], []
        for _ in range(ROUNDS):
            with tempfile.TemporaryDirectory() as folder:
                times, once = program(queries, Path(folder), 1)
                c.append((program(queries, Path(folder), 1 + PASSES)[1] - once) / PASSES)
            batch.append(of_a_pass(lambda: ccd.toi_batch(mesh, mesh, a, b, tolerance=TOLERANCE)))
            single.append(of_a_pass(lambda: [ccd.toi(mesh, mesh, x, y, tolerance=TOLERANCE) for x, y in pairs]))
        # Poses differ in their last bits, and with them what the tolerance leaves open.
        answers = ccd.toi_batch(mesh, mesh, a, b, tolerance=TOLERANCE)
        wrong = int((np.abs(answers["time"] - times) > TOLERANCE / SIZE).sum())
        good = good and wrong == 0
        print(f"{name}: {len(rows)} queries, {wrong} answers differ; program {statistics.median(c) / len(rows):.1f} "
              f"us per query, batch {shown(batch, c)} of it, single calls {shown(single, c)} of it", flush=True)
    far = ccd.Motion(np.block([[np.eye(3), np.full((3, 1), 1e6)], [np.zeros((1, 3)), np.ones((1, 1))]]))
    calls = []
    for _ in range(10_000):
        begin = time.perf_counter_ns()
        ccd.toi(mesh, mesh, far)
        calls.append(time.perf_counter_ns() - begin)
    print(f"a call that has nothing to search: {1e-3 * statistics.median(calls):.2f} us, median of 10,000")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
