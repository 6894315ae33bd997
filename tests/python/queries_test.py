"""Meshes, motions and queries, against closed forms."""
import copy
import pickle
import signal
import threading

import numpy as np
import pytest

import bullet_ccd as ccd
from shapes import at, box, box_arrays, turned


def test_a_box_meets_a_box_when_their_faces_do():
    hit = ccd.toi(box(), box(), ccd.Motion(at(3), velocity=(-4, 0, 0)))
    assert hit.status == ccd.Status.HIT
    assert hit.is_contact
    assert hit.time == pytest.approx(0.5, abs=ccd.DEFAULT_TOLERANCE)
    assert hit.time <= 0.5
    assert 0 < hit.gap <= ccd.DEFAULT_TOLERANCE
    np.testing.assert_allclose(hit.normal, [-1, 0, 0], atol=1e-9)
    assert hit.point_b[0] == pytest.approx(0.5)
    assert 0 <= hit.triangle_a < 12


def test_a_box_that_turns_meets_a_wall_with_its_edge():
    # The edge reaches x = -1 when half the diagonal of the face, turned, is as long.
    hit = ccd.toi(box(), box(), ccd.Motion(angular_velocity=(0, 0, np.pi / 4)), at(-1.15),
                  tolerance=1e-9)
    half = np.sqrt(0.5)
    assert hit.time == pytest.approx((np.pi / 4 - np.arccos(0.65 / half)) / (np.pi / 4), abs=1e-7)


@pytest.mark.parametrize("strategy", list(ccd.Strategy.__members__.values()))
def test_all_strategies_answer_the_same(strategy):
    motion = ccd.Motion.between(turned((1, 2, 3), 0.3, (4, 0.2, 0.1)), turned((3, 1, 0), 1.0, (-4, 0, 0)))
    hit = ccd.toi(box(), box(), motion, tolerance=1e-7, strategy=strategy)
    reference = ccd.toi(box(), box(), motion, tolerance=1e-7)
    assert hit.is_contact and hit.time == pytest.approx(reference.time, abs=1e-6)


def test_a_minimum_separation_is_kept():
    hit = ccd.toi(box(), box(), ccd.Motion(at(3), velocity=(-4, 0, 0)), minimum_separation=0.4)
    assert hit.time == pytest.approx(0.4, abs=ccd.DEFAULT_TOLERANCE)


def test_statuses():
    assert ccd.toi(box(), box(), at(3)).status == ccd.Status.SEPARATED
    assert ccd.toi(box(), box(), at(0.5)).status == ccd.Status.OVERLAPPING
    assert ccd.toi(box(), box(), at(1 + 1e-6)).status == ccd.Status.TOUCHING_LEAVING
    assert ccd.toi(box(), box(), ccd.Motion(at(3), velocity=(-4, 0, 0)),
                   max_iterations=1).status == ccd.Status.ITERATION_LIMIT
    stopped = ccd.toi(box(), box(), ccd.Motion(at(3), velocity=(-4, 0, 0)), time_limit=0.0)
    assert (stopped.status, stopped.time) == (ccd.Status.STOPPED, 0.0)


def test_motions_between_poses_end_there():
    start, end = turned((1, 0, 1), 0.4, (1, 2, 3)), turned((0, 1, 1), 1.4, (0, 1, 5))
    for motion in (ccd.Motion.between(start, end), ccd.Motion.screw(start, end)):
        np.testing.assert_allclose(motion.at(0), start, atol=1e-12)
        np.testing.assert_allclose(motion.at(1), end, atol=1e-12)
    np.testing.assert_allclose(ccd.Motion.between(start, end).at(0.5)[:3, 3], (0.5, 1.5, 4))


def random_motions(count, seed):
    random = np.random.default_rng(seed)
    starts = np.array([turned(random.normal(size=3), random.uniform(0, 3), 2 * random.normal(size=3))
                       for _ in range(count)])
    # They fly past the middle.
    velocities = -1.5 * starts[:, :3, 3] + random.normal(size=(count, 3))
    return starts, velocities, random.normal(size=(count, 3))


def test_a_batch_gives_the_bits_of_single_queries():
    starts, velocities, turns = random_motions(300, 1)
    motions = ccd.Motions.twists(starts, velocity=velocities, angular_velocity=turns)
    answers = ccd.toi_batch(box(), box(), motions, at(0.3))
    assert 20 < answers["is_contact"].sum() < 280
    for i, motion in enumerate(motions):
        single = ccd.toi(box(), box(), motion, at(0.3))
        assert answers["status"][i] == int(single.status)
        assert answers["time"][i] == single.time
        assert answers["gap"][i] == single.gap
        assert (answers["normal"][i] == single.normal).all()
        assert (answers["point_a"][i] == single.point_a).all()
        assert answers["triangle_b"][i] == single.triangle_b


def test_batches_between_poses_and_for_one_entry_and_for_none():
    starts, velocities, _ = random_motions(5, 2)
    ends = starts.copy()
    ends[:, :3, 3] += velocities
    answers = ccd.toi_batch(box(), box(), ccd.Motions.between(starts, ends))
    twists = ccd.toi_batch(box(), box(), ccd.Motions.twists(starts, velocity=velocities))
    np.testing.assert_allclose(answers["time"], twists["time"])
    assert ccd.toi_batch(box(), box(), at(3))["status"].tolist() == [0]
    none = ccd.toi_batch(box(), box(), ccd.Motions([]))
    assert none["time"].shape == (0,) and none["normal"].shape == (0, 3)


def test_batches_of_least_distances_are_single_queries():
    starts, velocities, turns = random_motions(100, 4)
    motions = ccd.Motions.twists(starts, velocity=velocities, angular_velocity=turns)
    least = ccd.least_distance_batch(box(), box(), motions, at(0.3), tolerance=1e-5, enough=0.4)
    assert (least["distance"] == 0.4).any() and 5 < (least["distance"] > 0).sum() < 95
    for i, motion in enumerate(motions):
        single = ccd.least_distance(box(), box(), motion, at(0.3), tolerance=1e-5, enough=0.4)
        for name in ("distance", "found", "time", "triangle_a", "triangle_b"):
            assert least[name][i] == getattr(single, name)
        assert least["status"][i] == int(single.status)
        assert (least["point_b"][i] == single.point_b).all()
        assert (least["normal"][i] == single.normal).all()
    assert ccd.least_distance_batch(box(), box(), ccd.Motions([]))["normal"].shape == (0, 3)
    stopped = ccd.least_distance_batch(box(), box(), motions, at(0.3), time_limit=0.0)
    assert set(stopped["status"]) == {int(ccd.Status.STOPPED)} and (stopped["distance"] == 0.0).all()


def test_contacts_are_no_later_than_dense_samples():
    starts, velocities, turns = random_motions(60, 3)
    a, b = box(), box(0.3)
    hits = 0
    for start, v, w in zip(starts, velocities, turns):
        motion = ccd.Motion(start, velocity=v, angular_velocity=w)
        answer = ccd.toi(a, b, motion)
        hits += answer.is_contact
        for time in np.linspace(0, 1, 101):
            near = ccd.distance(a, b, motion.at(time))
            assert near.distance > 0 or time >= answer.time
        if answer.is_contact:
            near = ccd.distance(a, b, motion.at(answer.time))
            assert near.distance <= 1.001 * ccd.DEFAULT_TOLERANCE
    assert 5 < hits < 55


def test_distance_of_boxes():
    near = ccd.distance(box(), box(), at(2, 0.2), at(0, 0, 1))
    assert near.distance == pytest.approx(1.0)
    assert near.point_a[0] == pytest.approx(1.5) and near.point_b[0] == pytest.approx(0.5)
    assert ccd.distance(box(), box(), at(2), upper_bound=0.5).triangle_a == -1
    assert ccd.distance(box(), box(), at(0.7)).distance == 0


def test_least_distance_of_a_box_that_flies_past_a_box():
    least = ccd.least_distance(box(), box(), ccd.Motion(at(-3, 1.3), velocity=(6, 0, 0)), tolerance=1e-6)
    assert 0.3 - 1.1e-6 <= least.distance <= 0.3
    assert least.found == pytest.approx(0.3) and 1 / 3 - 1e-6 <= least.time <= 2 / 3 + 1e-6
    enough = ccd.least_distance(box(), box(), ccd.Motion(at(-3, 1.3), velocity=(6, 0, 0)), enough=0.1)
    assert enough.distance == 0.1 and enough.triangle_a == -1


def test_contacts_of_boxes_span_the_face():
    found = ccd.contacts(box(), box(), at(1 + 1e-5, 0.2), threshold=1e-4)
    assert len(found) == 4
    corners = {(round(c.point_b[1], 3), round(c.point_b[2], 3)) for c in found}
    assert corners == {(-0.3, -0.5), (-0.3, 0.5), (0.5, -0.5), (0.5, 0.5)}


def test_first_contact_among_many_names_the_bodies():
    first = ccd.first_contact([(box(), at(0)), (box(), ccd.Motion(at(5), velocity=(-8, 0, 0))),
                               (box(), ccd.Motion(at(0, 4), velocity=(0, -8, 0)))])
    assert {first.body_a, first.body_b} == {0, 2}
    assert first.time == pytest.approx(3 / 8, abs=1e-4)
    only = ccd.first_contact([(box(), at(0)), (box(), ccd.Motion(at(5), velocity=(-8, 0, 0))),
                              (box(), ccd.Motion(at(0, 4), velocity=(0, -8, 0)))], [(0, 1)])
    assert only.time == pytest.approx(0.5, abs=1e-4)


def test_meshes_keep_their_arrays_and_give_read_only_views():
    vertices, triangles = box_arrays()
    mesh = ccd.Mesh(vertices, triangles)
    view = mesh.vertices
    np.testing.assert_array_equal(view, vertices)
    np.testing.assert_array_equal(mesh.triangles, triangles)
    with pytest.raises(ValueError):
        view[0, 0] = 7
    del mesh  # the view keeps it alive
    np.testing.assert_array_equal(view, vertices)


def test_mass_and_bounds_of_a_box():
    mass = box(0.5).mass_properties()
    assert mass["volume"] == pytest.approx(1)
    np.testing.assert_allclose(mass["inertia"], np.eye(3) / 6, atol=1e-12)
    assert box().is_watertight
    assert box().bounds[1].tolist() == [0.5, 0.5, 0.5]
    assert not ccd.Mesh(box_arrays()[0], box_arrays()[1][:5]).is_watertight


def test_meshes_and_motions_are_copied_and_pickled():
    mesh = pickle.loads(pickle.dumps(box()))
    np.testing.assert_array_equal(mesh.vertices, box().vertices)
    motion = pickle.loads(pickle.dumps(ccd.Motion(at(3), velocity=(-4, 0, 0))))
    again = copy.deepcopy(mesh)
    assert ccd.toi(again, mesh, motion).time == ccd.toi(box(), box(), motion).time


def test_meshes_of_others():
    class Trimesh:
        vertices, faces = box_arrays()

    class Open3D:
        vertices, triangles = [list(v) for v in box_arrays()]

    for mesh in (Trimesh(), Open3D(), box_arrays(), box()):
        assert ccd.as_mesh(mesh).triangles.shape == (12, 3)
    with pytest.raises(TypeError, match="mug: expected a Mesh"):
        ccd.as_mesh(7, name="mug")


def test_files(tmp_path):
    path = tmp_path / "box.obj"
    vertices, triangles = box_arrays()
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in vertices) +
                    "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in triangles))
    assert ccd.Mesh.load(path, scale=0.001).bounds[1].tolist() == [0.0005] * 3
    ascii_stl = tmp_path / "box.stl"
    ascii_stl.write_text("solid s\n" + "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % tuple(vertices[k]) for k in t) +
        "endloop\nendfacet\n" for t in triangles) + "endsolid s\n")
    assert ccd.Mesh.load(str(ascii_stl)).is_watertight
    with pytest.raises(RuntimeError, match="missing.obj"):
        ccd.Mesh.load(tmp_path / "missing.obj")


WRONG = [
    (lambda: ccd.Mesh([[0, 0]], [[0, 0, 0]]), ValueError, "vertices: expected an array of shape"),
    (lambda: ccd.Mesh("box", [[0, 1, 2]]), TypeError, "vertices: expected an array of real numbers"),
    (lambda: ccd.Mesh(np.eye(3) * 1j, [[0, 1, 2]]), TypeError, "complex"),
    (lambda: ccd.Mesh(np.eye(3), [[0.0, 1, 2]]), TypeError, "triangles: expected an array of integers"),
    (lambda: ccd.Mesh(np.eye(3), [[0, 1, 3]]), ValueError, "mesh: "),
    (lambda: ccd.Mesh(np.eye(3), [[0, 1, 2 ** 40]]), ValueError, "mesh: "),
    (lambda: ccd.Mesh(np.eye(3), [[0, 1, -1]]), ValueError, "mesh: "),
    (lambda: ccd.Mesh(np.eye(3) * np.nan, [[0, 1, 2]], name="cup"), ValueError, "cup: "),
    (lambda: ccd.Mesh([], []), (ValueError, TypeError), "vertices"),
    (lambda: ccd.Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), ValueError, "mesh: "),
    (lambda: ccd.toi(None, box()), TypeError, ""),
    (lambda: ccd.toi(box(), 7), TypeError, ""),
    (lambda: ccd.toi(box(), box(), np.eye(3)), ValueError, r"motion_a: .*\(4, 4\), but got \(3, 3\)"),
    (lambda: ccd.toi(box(), box(), 2 * np.eye(4)), ValueError, "last row"),
    (lambda: ccd.toi(box(), box(), np.diag([2.0, 2, 2, 1])), ValueError, ""),
    (lambda: ccd.toi(box(), box(), ccd.Motion(velocity=(np.nan, 0, 0))), ValueError, ""),
    (lambda: ccd.toi(box(), box(), tolerance=0), ValueError, "tolerance"),
    (lambda: ccd.toi(box(), box(), tolerance="fine"), TypeError, ""),
    (lambda: ccd.Motion(velocity=(1, 2)), ValueError, "velocity"),
    (lambda: ccd.Motions.twists(np.stack([np.eye(4)] * 3), velocity=np.zeros((2, 3))), ValueError,
     "velocity: 2 entries, but pose has 3"),
    (lambda: ccd.toi_batch(box(), box(), ccd.Motions([ccd.Motion()] * 3),
                           ccd.Motions([ccd.Motion()] * 2)), ValueError, "motions_b: 2 entries"),
    (lambda: ccd.toi_batch(box(), box(), np.diag([2.0, 2, 2, 1])), ValueError, ""),
    (lambda: ccd.Motions([None]), TypeError, ""),
    (lambda: ccd.Motions([ccd.Motion()])[1], IndexError, ""),
    (lambda: ccd.first_contact([(box(), None)], [(0, 1)]), ValueError, "pairs"),
    (lambda: ccd.first_contact([(None, None)]), TypeError, "bodies"),
    (lambda: ccd.distance(box(), box(), np.full((4, 4), np.nan)), ValueError, "pose_a"),
    (lambda: ccd.contacts(box(), box(), threshold=-1), ValueError, ""),
    (lambda: ccd.Motion(velocity=np.array(1.0)), ValueError, r"but got \(\)$"),
    (lambda: ccd.ConvexShape.sphere(-1), ValueError, ""),
    (lambda: ccd.ConvexShape.box((1, np.nan, 1)), ValueError, ""),
    (lambda: ccd.ConvexShape.hull(np.zeros((0, 3))), ValueError, ""),
    (lambda: ccd.convex_toi(ccd.ConvexShape.half_space((0, 0, 1)), ccd.ConvexShape.half_space((0, 0, -1))),
     ValueError, ""),
]


@pytest.mark.parametrize("make", [ccd.Mesh, ccd.Motion, ccd.Motions, ccd.Robot, ccd.ToiResult,
                                  ccd.ConvexShape, ccd.DeformableSurface, ccd.Trajectory])
def test_objects_that_were_never_made_are_refused(make):
    raw = make.__new__(make)
    for name, member in vars(make).items():
        if isinstance(member, property):
            with pytest.raises(TypeError, match="never made"):
                getattr(raw, name)
    for call in (lambda: ccd.toi(raw, raw), lambda: ccd.toi(box(), box(), raw), lambda: len(raw),
                 lambda: ccd.convex_toi(raw, raw), lambda: ccd.deformable_contacts([raw])):
        with pytest.raises((TypeError, RuntimeError)):
            call()


def sphere_arrays(n):
    """2 n^2 or so triangles, of a sphere of radius 1."""
    polar, around = np.meshgrid(np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, 2 * n), indexing="ij")
    vertices = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], 2)
    i = np.arange(n * 2 * n).reshape(n, 2 * n)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel()
    return vertices.reshape(-1, 3), np.vstack([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])


def test_any_gap_within_the_tolerance_ends_a_query():
    vertices, triangles = sphere_arrays(30)
    ball = ccd.Mesh(vertices, triangles)
    fall = ccd.Motion(at(0.2, 0.1, 4), velocity=(0, 0, -3))
    late = ccd.toi(ball, ball, fall, tolerance=0.01)
    early = ccd.toi(ball, ball, fall, tolerance=0.01, any_within=True)
    assert 0 < early.gap <= 0.01 and late.time - 0.01 / 3 * 1.1 <= early.time <= late.time
    assert early.node_pairs < late.node_pairs
    batch = ccd.toi_batch(ball, ball, ccd.Motions([fall] * 2), tolerance=0.01, any_within=True)
    assert list(batch["time"]) == [early.time] * 2


def test_ctrl_c_ends_long_queries():
    # One sphere turns inside another, nearly as large: what is near is everywhere. A smaller one never meets it.
    vertices, triangles = sphere_arrays(90)
    outer, inner = ccd.Mesh(vertices, triangles), ccd.Mesh(0.9999 * vertices, triangles)
    clear = ccd.Mesh(0.999 * vertices, triangles)
    turn = ccd.Motion(angular_velocity=(0, 0.3, 6))
    fine = {"minimum_separation": 9e-5, "tolerance": 1e-12}
    count = 0

    def third_time(number, frame):
        nonlocal count
        count += 1
        if count == 3:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, third_time)
    try:
        for call in (lambda: ccd.toi(outer, inner, turn, **fine),
                     lambda: ccd.toi_batch(outer, inner, ccd.Motions([turn] * 3), **fine),
                     lambda: ccd.first_contact([(outer, turn), (inner, None)], **fine),
                     lambda: ccd.least_distance(outer, clear, turn, tolerance=1e-12),
                     lambda: ccd.least_distance_batch(outer, clear, turn, tolerance=1e-12),
                     lambda: ccd.distance(outer, inner),
                     lambda: ccd.contacts(outer, inner, threshold=2e-4),
                     lambda: ccd.surface_deviation(inner, outer),
                     lambda: ccd.reduce(outer, 1e-6, kind="mesh")):
            count = 0
            # Python's handlers run once after a call that does not let them run while it works.
            signal.setitimer(signal.ITIMER_REAL, 0.001, 0.001)
            with pytest.raises(KeyboardInterrupt):
                try:
                    call()
                finally:
                    signal.setitimer(signal.ITIMER_REAL, 0)
    finally:
        signal.signal(signal.SIGALRM, before)
    # What takes longer than a moment is answered as ever.
    assert 0 < ccd.distance(outer, inner).distance <= 1e-4


def test_exact_convex_shapes_by_closed_forms():
    fall = ccd.Motion(at(0, 0, 3), velocity=(0, 0, -4))
    ground = ccd.ConvexShape.half_space((0, 0, 2), 0.0)
    lowest = {ccd.ConvexShape.sphere(0.5): 0.5, ccd.ConvexShape.capsule(0.25, 0.5): 0.75,
              ccd.ConvexShape.box((0.1, 0.2, 0.5)): 0.5, ccd.ConvexShape.cylinder(1.0, 0.25): 0.25,
              ccd.ConvexShape.cone(0.5, 1.0): 1.0, ccd.ConvexShape.hull(box_arrays()[0]): 0.5,
              ccd.ConvexShape.box((1, 1, 1)).rounded(0.5): 1.5}
    for shape, below in lowest.items():
        hit = ccd.convex_toi(shape, ground, fall, tolerance=1e-9)
        assert hit.status == ccd.Status.HIT and hit.time == pytest.approx((3 - below) / 4, abs=1e-8)
        np.testing.assert_allclose(hit.normal, (0, 0, -1), atol=1e-9)
        assert hit.triangle_a == -1
    # Solid, as meshes are not.
    small, large = ccd.ConvexShape.sphere(0.1), ccd.ConvexShape.box((1, 1, 1))
    assert ccd.convex_toi(small, large).status == ccd.Status.OVERLAPPING
    assert copy.deepcopy(small) is small and (small.kind, small.radius) == ("point", 0.1)
    # A hull of a box's corners is that box, as a mesh, too.
    for start, v, w in zip(*random_motions(40, 9)):
        motion = ccd.Motion(start, velocity=v, angular_velocity=w)
        exact = ccd.convex_toi(ccd.ConvexShape.hull(box_arrays()[0]), ccd.ConvexShape.box((0.5, 0.5, 0.5)),
                               motion, tolerance=1e-6)
        mesh = ccd.toi(box(), box(), motion, tolerance=1e-6)
        assert exact.is_contact == mesh.is_contact
        assert ccd.distance(box(), box(), motion.at(exact.time)).distance <= 1.1e-6 or not exact.is_contact


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_wrong_arguments_raise(number):
    call, error, message = WRONG[number]
    with pytest.raises(error, match=message):
        call()


def test_threads_share_meshes():
    starts, velocities, turns = random_motions(200, 4)
    a = box()
    motions = [ccd.Motion(s, velocity=v, angular_velocity=w)
               for s, v, w in zip(starts, velocities, turns)]
    expected = [ccd.toi(a, a, motion).time for motion in motions]
    found = {}

    def ask(number):
        found[number] = [ccd.toi(a, a, motion).time for motion in motions]

    threads = [threading.Thread(target=ask, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(found[k] == expected for k in range(4))


def test_random_arguments_never_crash():
    random = np.random.default_rng(5)
    mesh = box()
    pool = [None, 0, -1, 1.5, "x", b"", [], {}, np.nan, np.eye(4), np.eye(3), np.zeros((0, 3)), mesh,
            ccd.Motion(), ccd.Motions([]), np.array([[1, 2, 3]]), np.full((2, 4, 4), np.inf), (mesh, None),
            [(mesh, None)], ccd.Strategy.C2A, object(), np.array(["a"]), np.eye(4, dtype=object), 10 ** 30]
    calls = [ccd.Mesh, ccd.Motion, ccd.Motion.between, ccd.Motions, ccd.Motions.between,
             ccd.Motions.twists, ccd.toi, ccd.toi_batch, ccd.distance, ccd.first_contact, ccd.as_mesh,
             ccd.articulated_toi, ccd.Robot.load, ccd.grasp.GraspObject, ccd.grasp.plan]
    answered = 0
    for _ in range(3000):
        call = calls[random.integers(len(calls))]
        arguments = [pool[random.integers(len(pool))] for _ in range(random.integers(0, 5))]
        try:
            call(*arguments)
            answered += 1
        except (TypeError, ValueError, KeyError, RuntimeError, OverflowError, IndexError):
            pass
    assert answered > 50
