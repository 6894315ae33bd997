"""Wrong arguments of every kind: a call answers or raises, and never ends the interpreter."""
import copy
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bullet_ccd as ccd
from bullet_ccd import grasp
from shapes import arm, at, box  # noqa: F401

FUZZ = r'''
import gc, inspect, os, random, sys, warnings
from pathlib import Path
import numpy as np
import bullet_ccd as ccd
from bullet_ccd import grasp
from shapes import box

warnings.simplefilter("ignore")
share = Path(os.environ["BULLET_CCD_SHARE"]) / "robots"
calls, seed = int(sys.argv[1]), int(sys.argv[2])
rng = random.Random(seed)
mesh = box(0.1)
robot = ccd.Robot.load(share / "parallel_gripper/parallel_gripper.urdf")
hand = grasp.Hand.load(share / "parallel_gripper/parallel_gripper.urdf")
cube = grasp.GraspObject(box(0.02))
grasps = grasp.plan(hand, cube, candidates=3, seed=3, volumes=0)
path = ccd.Trajectory.through(robot, [0, 1], np.zeros((2, len(robot.joint_names))))
good = [mesh, ccd.Motion(), ccd.Motions([ccd.Motion()]), robot, hand, cube, grasps[0], path, np.eye(4),
        ccd.DeformableSurface(mesh), ccd.ConvexShape.box((1, 1, 1)), ccd.Status.HIT, ccd.Strategy.C2A, ccd.Depth.EXACT, [(mesh, None)],
        [(mesh, ccd.Motion(velocity=(1, 0, 0)))], ccd.CollisionManager(), "six", "box", {}, {"box": np.eye(4)}]
bad = [None, True, "", "x" * 300, "\0", b"abc", -1, 0, 1, 3, 10**30, -2**63, 0.5, -0.0, float("nan"),
       float("inf"), 1e308, 5e-324, 1j, [], [1, 2], [[1, 2], [3]], (1, "a"), {1: 2}, {"a": None}, {1, 2},
       object(), int, len, lambda *a: 1, iter([1]), Ellipsis, range(3), np.zeros(0), np.zeros((3, 3)),
       np.full((4, 4), np.nan), np.zeros((4, 4)), -np.eye(4), np.eye(4, dtype=np.float32),
       np.eye(4, dtype=complex), np.array(["a"]), np.array([None]), np.zeros((2, 4, 3)), np.eye(4)[::-1],
       np.array(3), np.array([[0, 1, 2]]), np.array([[0, 1, 99]]), np.array([[2**40, 0, 1]]),
       np.zeros((0, 3)), np.ones((8, 3)), Path("nowhere"), [(None, None)], [(mesh, "a")], [(0, 0)],
       [(0, 10**9)], [(-1, 5)], [None], [mesh, mesh], memoryview(b"abcd"), np.ma.masked_array([1.0], [True])]

# What takes long for good reasons is kept short.
short = {"candidates": 2, "time_limit": 0.05, "max_iterations": 2000, "jobs": 2, "volumes": 0,
         "protocol": "x.yaml"}
targets = [(ccd, n) for n in ccd.__all__ if callable(getattr(ccd, n))]
targets += [(grasp, n) for n in grasp.__all__ if callable(getattr(grasp, n))]
targets += [(ccd._core, n) for n in dir(ccd._core) if not n.startswith("_") and callable(getattr(ccd._core, n))]
names = ["tolerance", "minimum_separation", "strategy", "max_iterations", "time_limit", "jobs", "start",
         "end", "pose", "velocity", "threshold", "candidates", "friction", "mass", "protocol", "accuracy",
         "kind", "root", "self_pairs", "load", "efforts", "nonsense", "seams", "depth", "first_only"]


# Calls that are right, in which one argument is then made wrong.
pose = np.eye(4)
moved = ccd.Motion(pose, velocity=(0, 0, -1))
joints = len(robot.joint_names)
poses = np.stack([pose] * 3)
right = [
    (ccd.toi, [mesh, mesh, moved, None], {"tolerance": 1e-4, "minimum_separation": 0.0, "max_iterations": 99}),
    (ccd.toi_batch, [mesh, mesh, poses, pose], {"tolerance": 1e-4, "time_limit": 1.0}),
    (ccd.toi_batch, [mesh, mesh, ccd.Motions.between(poses, pose), None], {}),
    (ccd.distance, [mesh, mesh, pose, None], {"upper_bound": 1.0}),
    (ccd.contacts, [mesh, mesh, pose, None], {"threshold": 0.1}),
    (ccd.convex_toi, [good[10], good[10], moved, None], {"tolerance": 1e-4, "minimum_separation": 0.0}),
    (ccd.ConvexShape.hull, [mesh.vertices], {}), (ccd.ConvexShape.half_space, [(0, 0, 1), 0.5], {}),
    (ccd.least_distance, [mesh, mesh, moved, None], {"tolerance": 1e-4, "enough": 1.0, "time_limit": 1.0}),
    (ccd.first_contact, [[(mesh, moved), (mesh, None)], [(0, 1)]], {"tolerance": 1e-4}),
    (ccd.articulated_toi, [robot, {}, None, [(mesh, pose)]], {"root_start": pose, "self_pairs": [], "max_iterations": 99}),
    (ccd.articulated_least_distance, [robot, {}, None, [(mesh, pose)]], {"enough": 0.5, "time_limit": 1.0}),
    (ccd.Trajectory.through, [robot, [0, 1], np.zeros((2, joints)), np.zeros((2, joints))], {"root": pose}),
    (ccd.Trajectory.spline, [robot, [0, 0, 1, 1], np.zeros((2, joints))], {"degree": 1}),
    (ccd.trajectory_toi, [path, [(mesh, pose)]], {"self_pairs": [], "jobs": 2, "time_limit": 1.0}),
    (ccd.trajectory_least_distance, [path, [(mesh, pose)]], {"enough": 0.5, "jobs": 1}),
    (path.at, [0.5], {}), (robot.link_poses, [{}], {"root": pose}), (moved.at, [0.5], {}),
    (ccd.Mesh, [mesh.vertices, mesh.triangles], {"name": "m"}),
    (ccd.Motion, [pose], {"velocity": (0, 0, 1), "angular_velocity": (0, 1, 0), "reference": (0, 0, 0)}),
    (ccd.Motions.twists, [poses], {"velocity": np.zeros((3, 3)), "angular_velocity": (0, 0, 1)}),
    (ccd.DeformableSurface, [mesh], {"self_collision": True, "weld_duplicates": False, "seams": [(0, 1)]}),
    (good[9].set_step, [mesh.vertices, mesh.vertices], {}), (good[9].set_motion, [mesh, moved], {}),
    (ccd.deformable_contacts, [[good[9], good[9]]], {"tolerance": 1e-4, "jobs": 1, "first_only": True}),
    (ccd.elementary_toi, [np.zeros((2, 4, 3)), np.ones((2, 4, 3))], {"edge_edge": True, "tolerance": 1e-4}),
    (ccd.reduce, [mesh, 1e-3], {"contains": True, "kind": "mesh"}),
    (ccd.surface_deviation, [mesh, mesh], {"enough": 0.1}),
    (ccd.as_mesh, [(mesh.vertices, mesh.triangles)], {}),
    (grasp.close, [hand, cube, pose, (0, 0, 0.01)], {"friction": 0.5, "tolerance": 1e-4, "cone_edges": 4}),
    (grasp.plan, [hand, cube], {"candidates": 1, "jobs": 1, "seed": 2, "friction": 0.5, "volumes": 0}),
    (grasp.squeeze, [hand, grasps[0]], {"mass": 0.1, "friction": 0.5, "firmness": 2.0, "efforts": {}}),
    (grasp.forces, [hand, cube, grasps[0], np.zeros(6)], {"friction": 0.5, "objective": "max"}),
]
for target, arguments, keywords in right:
    target(*arguments, **keywords)


def value():
    return rng.choice(good) if rng.random() < 0.5 else rng.choice(bad)


answered = 0
for k in range(calls):
    if rng.random() < 0.6:
        target, arguments, keywords = rng.choice(right)
        arguments, keywords, name = list(arguments), dict(keywords), target.__name__
        if rng.random() < 0.9:
            chosen = rng.choice([*range(len(arguments)), *keywords])
            (keywords if isinstance(chosen, str) else arguments)[chosen] = value()
    else:
        place, name = rng.choice(targets)
        target = getattr(place, name)
        if isinstance(target, type) and rng.random() < 0.6:
            owners = [o for o in good if isinstance(o, target)]
            special = ["__getitem__", "__len__", "__copy__", "__deepcopy__", "__setstate__", "__reduce__",
                       "__eq__", "__hash__", "__repr__", "__init__"] if owners else []
            member = rng.choice([m for m in dir(target) if not m.startswith("_")] + special or ["__name__"])
            owner = rng.choice(owners or [target])
            target, name = getattr(owner, member, len), name + "." + member
        arguments = [value() for _ in range(rng.randrange(5))]
        keywords = {n: value() for n in rng.sample(names, rng.randrange(3))}
    for n, limit in short.items():
        if n in keywords or (name == "plan" and n == "candidates"):
            keywords[n] = rng.choice([limit, limit, -1, "a", None, float("nan")])
    if name in ("plan", "close", "trial"):
        arguments = arguments[:3]
    print(k, name, flush=True) if "-v" in sys.argv else None
    try:
        answer = target(*arguments, **keywords)
        repr(answer)
        for member in [m for m in dir(answer) if not m.startswith("_")][:30]:
            getattr(answer, member)
        answered += 1
    except (Exception, KeyboardInterrupt):
        pass
    if k % 500 == 0:
        gc.collect()
print("answered", answered, "of", calls)
'''


def test_copies_and_pickles_of_what_has_none_are_refused():
    for thing in (ccd.DeformableSurface(box()), ccd.ConvexShape.sphere(1.0)):
        for ask in (pickle.dumps, lambda x: pickle.dumps(x, 0), lambda x: x.__reduce__()):
            with pytest.raises(TypeError, match="neither be copied"):
                ask(thing)
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        for thing in (ccd.Motion(velocity=(1, 2, 3)), box()):
            assert type(pickle.loads(pickle.dumps(thing, protocol))) is type(thing)
        assert pickle.loads(pickle.dumps(ccd.Status.HIT, protocol)) == ccd.Status.HIT
    with pytest.raises(TypeError, match="neither be copied"):
        copy.copy(ccd.DeformableSurface(box()))


def shown(thing):
    """All that users see of a result, for comparisons."""
    if isinstance(thing, (list, tuple)):
        return [shown(part) for part in thing]
    if isinstance(thing, np.ndarray) or not type(thing).__module__.startswith("bullet_ccd") \
            or isinstance(thing, ccd.Status):
        return repr(thing)
    return {name: shown(getattr(thing, name)) for name in dir(type(thing))
            if isinstance(getattr(type(thing), name), property)}


def test_results_are_copied_and_pickled_whole(arm):
    fall = ccd.Motion(at(0, 0, 3), velocity=(0.1, 0.2, -4))
    obstacle = [(box(), at(0.5, 1))]
    path = ccd.Trajectory.through(arm, [0, 2], [[0.0], [1.5]])
    results = [ccd.toi(box(), box(), fall), ccd.distance(box(), box(), at(3, 0.1)),
               ccd.contacts(box(), box(), at(1 + 1e-5), threshold=1e-4),
               ccd.least_distance(box(), box(), ccd.Motion(at(-3, 1.3), velocity=(6, 0, 0))),
               ccd.first_contact([(box(), at(0)), (box(), fall)]),
               ccd.articulated_toi(arm, [0.0], [1.5], obstacle),
               ccd.articulated_least_distance(arm, [0.0], [0.1], obstacle),
               ccd.trajectory_toi(path, obstacle), ccd.trajectory_least_distance(path, obstacle)]
    for result in results:
        assert len(str(shown(result))) > 60
        for again in (copy.deepcopy(result), pickle.loads(pickle.dumps(result)),
                      pickle.loads(pickle.dumps(result, 0))):
            assert type(again) is type(result) and shown(again) == shown(result)
    motions = pickle.loads(pickle.dumps(ccd.Motions([fall, ccd.Motion()])))
    assert len(motions) == 2 and shown(motions[0]) == shown(fall)


def test_an_interrupted_plan_is_pickled_with_its_grasps():
    error = grasp.PlanInterrupted([None] * 6)
    again = pickle.loads(pickle.dumps(error))
    assert again.grasps == [None] * 6 and str(again) == str(error)


def test_robots_and_hands_are_pickled_by_their_files(arm):
    assert shown(pickle.loads(pickle.dumps(arm))) == shown(arm)
    urdf = Path(os.environ["BULLET_CCD_SHARE"]) / "robots/parallel_gripper/parallel_gripper.urdf"
    hand = ccd.grasp.Hand.load(urdf)
    assert shown(pickle.loads(pickle.dumps(hand))) == shown(hand)
    cube = ccd.grasp.GraspObject(box(0.02), name="cube")
    again = pickle.loads(pickle.dumps(cube))
    assert shown(again) == shown(cube)
    plans = [ccd.grasp.plan(hand, thing, candidates=2, volumes=0) for thing in (cube, again)]
    assert [g.record for g in plans[0]] == [g.record for g in plans[1]]
    Path(arm_file(arm)).unlink()
    with pytest.raises(RuntimeError, match="arm.urdf"):
        copy.copy(arm)


def arm_file(robot):
    return robot.__getstate__()[0]


def test_nothing_ends_the_interpreter(tmp_path):
    calls = "10000" if os.environ.get("BULLET_CCD_LONG_TESTS") else "2000"
    here = Path(__file__).parent
    script = tmp_path / "fuzz.py"
    script.write_text(FUZZ)
    run = subprocess.run([sys.executable, "-X", "faulthandler", script, calls, "1"], cwd=tmp_path,
                         env={**os.environ, "PYTHONPATH": f"{os.environ.get('PYTHONPATH', '')}:{here}"},
                         check=False, capture_output=True, text=True, timeout=1200)
    assert run.returncode == 0, run.stdout[-500:] + run.stderr[-4000:]
    answered = int(run.stdout.split()[-3])
    # Not everything is refused: enough calls get as far as an answer.
    assert answered > int(calls) // 20
