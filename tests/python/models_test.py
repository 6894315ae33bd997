"""Reduced models and deviations, by closed forms."""
import numpy as np
import pytest

import bullet_ccd as ccd
from shapes import box, box_arrays


def ball(radius, n=24):
    """Points of a sphere on a grid of latitudes and longitudes."""
    polar = np.linspace(0, np.pi, n)
    around = np.linspace(0, 2 * np.pi, 2 * n, endpoint=False)
    points = [[0, 0, radius]] + [[radius * np.sin(p) * np.cos(a), radius * np.sin(p) * np.sin(a),
                                  radius * np.cos(p)] for p in polar[1:-1] for a in around]
    points.append([0, 0, -radius])
    m, last = 2 * n, len(points) - 1
    faces = [[0, 1 + j, 1 + (j + 1) % m] for j in range(m)]
    for i in range(n - 3):
        a, b = 1 + i * m, 1 + (i + 1) * m
        for j in range(m):
            k = (j + 1) % m
            faces += [[a + j, b + j, b + k], [a + j, b + k, a + k]]
    faces += [[last, last - m + (j + 1) % m, last - m + j] for j in range(m)]
    return ccd.Mesh(points, faces)


def test_deviation_of_a_shifted_box_is_its_shift():
    vertices, faces = box_arrays()
    shifted = ccd.Mesh(vertices + [0.1, 0, 0], faces)
    deviation = ccd.surface_deviation(shifted, box())
    assert deviation.lower <= 0.1 + 1e-12 and deviation.upper >= 0.1 - 1e-12
    assert deviation.upper - deviation.lower <= 0.01 * deviation.lower + 1e-12
    assert deviation.point[0] == pytest.approx(0.6)


def test_a_ball_becomes_a_sphere_and_a_box_a_box():
    sphere = ccd.reduce(ball(0.1), 1e-3)
    assert sphere is not None and sphere.kind == "sphere"
    assert sphere.radius == pytest.approx(0.1, abs=1e-3) and 0 < sphere.deviation <= 1e-3
    cube = ccd.reduce(box(0.2), 1e-4)
    assert cube is not None and cube.kind == "box"
    np.testing.assert_allclose(cube.half_extents, 0.2, atol=1e-4)
    assert len(cube.mesh.triangles) == 12 and cube.deviation <= 1e-4


def test_a_mesh_of_fewer_triangles_keeps_the_accuracy():
    full = ball(0.1, 40)
    model = ccd.reduce(full, 5e-4, kind="mesh")
    assert model is not None and model.kind == "mesh"
    assert len(model.mesh.triangles) < 0.7 * len(full.triangles)
    assert ccd.surface_deviation(full, model.mesh).upper <= 5e-4 * 1.0001
    assert ccd.surface_deviation(model.mesh, full).upper <= 5e-4 * 1.0001
    around = ccd.reduce(full, 5e-3, contains=True)
    assert around is not None and np.linalg.norm(around.mesh.vertices, axis=1).min() >= 0.1 - 1e-9


def test_what_does_not_keep_the_accuracy_is_none():
    assert ccd.reduce(box(0.2), 1e-3, kind="sphere") is None


def test_advice_keeps_its_promise():
    rows = ccd.advise(ball(0.05, 16), box(0.04))
    assert rows[0].accuracy == 0 and rows[0].triangles_b == 12
    assert [row.accuracy for row in rows[1:]] == sorted(row.accuracy for row in rows[1:])
    assert len(rows) > 4 and rows[-1].triangles_a < rows[0].triangles_a
    for row in rows:
        assert row.broken == 0 and row.contacts > 10 and row.microseconds > 0
        assert row.largest_gap <= (row.accuracy or row.tolerance)
    assert len(ccd.advise(ball(0.05, 16), box(0.04), time_limit=0.0)) == 1


def test_time_limits_end_long_calls():
    outer, inner = ball(0.1, 60), ball(0.09999, 60)
    for call in (lambda limit: ccd.surface_deviation(inner, outer, time_limit=limit),
                 lambda limit: ccd.reduce(outer, 1e-5, time_limit=limit),
                 lambda limit: ccd.distance(inner, outer, time_limit=limit),
                 lambda limit: ccd.contacts(inner, outer, threshold=1e-4, time_limit=limit)):
        for limit in (0.0, 1e-3):
            with pytest.raises(TimeoutError, match="time limit"):
                call(limit)
        assert call(1e3)
        with pytest.raises(ValueError, match="NaN"):
            call(np.nan)


def test_what_is_wrong_is_said():
    with pytest.raises(ValueError, match="kind: 'ball'"):
        ccd.reduce(box(), 1e-3, kind="ball")
    for accuracy in (0.0, -1.0, np.nan, 1e-15):
        with pytest.raises(ValueError, match="accuracy"):
            ccd.reduce(box(), accuracy)
    with pytest.raises(ValueError):
        ccd.reduce(ccd.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), 1e-3, contains=True)
