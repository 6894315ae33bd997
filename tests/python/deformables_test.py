"""Surfaces that deform, by closed forms."""
import threading

import numpy as np
import pytest

import bullet_ccd as ccd
from shapes import at, box

FLOOR = np.array([[-5.0, -5, 0], [5, -5, 0], [0, 7, 0]])
SHEET = np.array([[-0.3, -0.3, 1], [0.3, -0.3, 1], [0, 0.4, 1.2]])


def surface(vertices, **options):
    return ccd.DeformableSurface(ccd.Mesh(vertices, [[0, 1, 2]]), **options)


def test_a_sheet_meets_the_floor_when_its_lowest_vertex_does():
    sheet, floor = surface(SHEET), surface(FLOOR)
    sheet.set_step(SHEET, SHEET - [0, 0, 2])
    status, time, contacts = ccd.deformable_contacts([sheet, floor], tolerance=1e-9)
    assert status == ccd.Status.HIT
    assert time == pytest.approx(0.5, abs=1e-9) and time <= 0.5
    # Two vertices arrive at z = 0 at t = 1 / 2, the third at 1.2 / 2.
    faces = ~contacts["is_edge_edge"] & (contacts["body_a"] == 0)
    np.testing.assert_allclose(contacts["time"][faces], [0.5, 0.5, 0.6], atol=1e-9)
    np.testing.assert_array_equal(contacts["vertices"][faces][:, 0], [0, 1, 2])
    np.testing.assert_allclose(contacts["normal"][faces], [[0, 0, -1]] * 3, atol=1e-9)
    np.testing.assert_allclose(contacts["weights"][faces].sum(axis=1), 0, atol=1e-12)
    _, first, some = ccd.deformable_contacts([sheet, floor], tolerance=1e-9, first_only=True)
    assert first == time and len(some["time"]) <= len(contacts["time"])


def test_a_surface_meets_itself_unless_it_shall_not():
    both = np.vstack([SHEET, FLOOR])
    mesh = ccd.Mesh(both, [[0, 1, 2], [3, 4, 5]])
    end = both.copy()
    end[:3, 2] -= 2
    for own, expected in ((True, ccd.Status.HIT), (False, ccd.Status.SEPARATED)):
        one = ccd.DeformableSurface(mesh, self_collision=own)
        one.set_step(both, end)
        assert ccd.deformable_contacts([one])[0] == expected


def test_a_rigid_body_is_an_obstacle_at_its_closed_form():
    mesh = box(0.5)
    body, floor = ccd.DeformableSurface(mesh), surface(FLOOR)
    body.set_motion(mesh, ccd.Motion(at(0, 0, 1.5), velocity=(0, 0, -2)))
    assert ccd.deformable_contacts([body, floor], tolerance=1e-9)[1] == pytest.approx(0.5, abs=1e-8)


def test_elementary_queries_in_batches():
    rng = np.random.default_rng(3)
    count = 500
    start = np.zeros((count, 4, 3))
    end = np.zeros((count, 4, 3))
    start[:, 1:] = end[:, 1:] = FLOOR
    start[:, 0, 2] = rng.uniform(0.1, 2, count)
    end[:, 0, 2] = rng.uniform(-2, 0.09, count)
    start[:, 0, :2] = rng.uniform(-1, 1, (count, 2))
    end[:, 0, :2] = rng.uniform(-1, 1, (count, 2))
    truth = start[:, 0, 2] / (start[:, 0, 2] - end[:, 0, 2])
    for depth in (ccd.Depth.TOLERANCE, ccd.Depth.DECIDE, ccd.Depth.EXACT):
        answers = ccd.elementary_toi(start, end, tolerance=1e-9, depth=depth)
        np.testing.assert_array_equal(answers["is_contact"], end[:, 0, 2] <= 1e-9)
        hit = answers["is_contact"]
        np.testing.assert_allclose(answers["time"][hit], truth[hit], atol=1e-7)
        assert (answers["time"][hit] <= truth[hit] + 1e-12).all()
    # Two crossing edges, one of which comes down by 2 from 1 above.
    a = [[-1.0, 0, 1], [1, 0, 1], [0, -1, 0], [0, 1, 0]]
    b = [[-1.0, 0, -1], [1, 0, -1], [0, -1, 0], [0, 1, 0]]
    assert ccd.elementary_toi([a], [b], edge_edge=True, tolerance=1e-9)["time"][0] == \
        pytest.approx(0.5, abs=1e-9)
    assert len(ccd.elementary_toi(np.zeros((0, 4, 3)), np.zeros((0, 4, 3)))["time"]) == 0


def test_threads_share_a_surface():
    mesh = ccd.Mesh(*_grid(30))
    cloth, floor = ccd.DeformableSurface(mesh), surface(FLOOR)
    high, low = mesh.vertices + [0, 0, 1], mesh.vertices - [0, 0, 1]
    cloth.set_step(high, low)
    problems = []

    def work(moves):
        for _ in range(30):
            if moves:
                cloth.set_step(high, low)
            elif ccd.deformable_contacts([floor, cloth, floor])[0] != ccd.Status.HIT:
                problems.append("missed")

    threads = [threading.Thread(target=work, args=(k % 2 == 0,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not problems


def _grid(n):
    xs = np.linspace(-0.5, 0.5, n)
    vertices = np.array([[x, y, 0] for x in xs for y in xs])
    faces = [[i * n + j, i * n + j + 1, (i + 1) * n + j] for i in range(n - 1) for j in range(n - 1)]
    return vertices, faces


def test_what_is_wrong_is_said():
    sheet = surface(SHEET)
    with pytest.raises(ValueError):
        sheet.set_step(SHEET[:2], SHEET[:2])
    with pytest.raises(ValueError, match="finite"):
        sheet.set_step(SHEET, np.full((3, 3), np.nan))
    with pytest.raises(ValueError, match="same place|duplicate|weld"):
        ccd.DeformableSurface(ccd.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [1, 0, 1], [0, 1, 1]],
                                       [[0, 1, 2], [3, 4, 5]]))
    with pytest.raises(TypeError, match="surfaces"):
        ccd.deformable_contacts([None])
    with pytest.raises(ValueError, match="jobs"):
        ccd.deformable_contacts([sheet], jobs=-2)
    with pytest.raises(ValueError, match="start"):
        ccd.elementary_toi(np.zeros((2, 4)), np.zeros((2, 4)))
