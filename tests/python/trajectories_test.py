"""Trajectories and least distances of robots, on an arm with closed forms."""
import numpy as np
import pytest

import bullet_ccd as ccd
from shapes import ARM, arm, at, box  # noqa: F401

WALL = [(box(2.0), at(0, 2.55))]  # its face is the plane y = 0.55
# The corner (1, 0.05) of the bar meets the plane where sin(q) + 0.05 cos(q) = 0.55.
ANGLE = np.arcsin(0.55 / np.hypot(1, 0.05)) - np.arctan2(0.05, 1)


def times_of_hits(trajectory):
    hit = ccd.trajectory_toi(trajectory, WALL, tolerance=1e-8)
    assert hit.status == ccd.Status.HIT and hit.is_contact
    assert hit.contacts[0].link == "bar" and hit.contacts[0].obstacle == 0
    return hit.time, hit.segment


def test_the_wall_is_met_when_the_joint_passes_the_angle(arm):
    linear = ccd.Trajectory.through(arm, [1, 2, 4], [[-1.0], [0.0], [1.5]])
    assert len(linear) == 2
    np.testing.assert_array_equal(linear.times, [1, 2, 4])
    assert times_of_hits(linear) == (pytest.approx(2 + 2 * ANGLE / 1.5, abs=1e-6), 1)
    # Cubic from rest to rest: q = 1.5 (3 s^2 - 2 s^3).
    roots = np.roots([-3.0, 4.5, 0, -ANGLE])
    s = [r.real for r in roots if abs(r.imag) < 1e-12 and 0 <= r.real <= 1][0]
    cubic = ccd.Trajectory.through(arm, [0, 2], [[0.0], [1.5]], [[0.0], [0.0]])
    assert times_of_hits(cubic) == (pytest.approx(2 * s, abs=1e-6), 0)
    assert cubic.at(2 * s)[0] == pytest.approx(ANGLE, abs=1e-12)
    # Quintic: q = 1.5 (10 s^3 - 15 s^4 + 6 s^5).
    quintic = ccd.Trajectory.through(arm, [0, 2], [[0.0], [1.5]], [[0.0], [0.0]], [[0.0], [0.0]])
    roots = np.roots([9.0, -22.5, 15.0, 0, 0, -ANGLE])
    s = [r.real for r in roots if abs(r.imag) < 1e-9 and 0 <= r.real <= 1][0]
    assert times_of_hits(quintic)[0] == pytest.approx(2 * s, abs=1e-6)
    spline = ccd.Trajectory.spline(arm, [0, 0, 2, 2], [[0.0], [1.5]], degree=1)
    assert times_of_hits(spline)[0] == pytest.approx(2 * ANGLE / 1.5, abs=1e-6)


def test_a_free_trajectory_is_certified_and_keeps_its_least_distance(arm):
    path = ccd.Trajectory.through(arm, [0, 1, 2], [[0.0], [0.3], [-0.5]])
    free = ccd.trajectory_toi(path, WALL)
    assert free.status == ccd.Status.SEPARATED and free.segment is None and not free.contacts
    truth = 0.55 - np.sin(0.3) - 0.05 * np.cos(0.3)
    least = ccd.trajectory_least_distance(path, WALL, tolerance=1e-6)
    assert least.status == ccd.Status.SEPARATED
    assert truth - 1.001e-6 <= least.distance <= truth <= least.found + 1e-9
    assert least.time == pytest.approx(1.0, abs=1e-3) and least.link == "bar" and least.obstacle == 0
    np.testing.assert_allclose(least.normal, [0, 1, 0], atol=1e-3)
    single = ccd.articulated_least_distance(arm, [0.0], [0.3], WALL, tolerance=1e-6)
    assert truth - 1.001e-6 <= single.distance <= truth
    assert single.time == pytest.approx(1.0, abs=1e-3)
    enough = ccd.articulated_least_distance(arm, [0.0], [0.3], WALL, enough=0.1)
    assert enough.distance <= 0.1 and enough.link is None


def test_the_answer_does_not_depend_on_threads(arm):
    rng = np.random.default_rng(5)
    path = ccd.Trajectory.through(arm, np.arange(40.0), rng.uniform(-1, 0.8, (40, 1)))
    answers = [ccd.trajectory_toi(path, WALL, jobs=jobs).time for jobs in (1, 2, 7)]
    assert answers[0] == answers[1] == answers[2]


def test_the_robot_may_go_before_its_trajectory(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text(ARM)
    path = ccd.Trajectory.through(ccd.Robot.load(file), [0, 2], [[0.0], [1.5]])
    assert ccd.trajectory_toi(path, WALL).is_contact


@pytest.mark.parametrize("make, message", [
    (lambda arm: ccd.Trajectory.through(arm, [0, 0], [[0.0], [1.0]]), "not after"),
    (lambda arm: ccd.Trajectory.through(arm, [0], [[0.0]]), "two"),
    (lambda arm: ccd.Trajectory.through(arm, [0, 1], [[0.0, 1.0], [1.0, 1.0]]), "positions"),
    (lambda arm: ccd.Trajectory.through(arm, [0, np.nan], [[0.0], [1.0]]), "finite|increas"),
    (lambda arm: ccd.Trajectory.through(arm, [0, 1], [[0.0], [np.inf]]), "finite"),
    (lambda arm: ccd.Trajectory.spline(arm, [0, 1], [[0.0], [1.0]]), "knots"),
    (lambda arm: ccd.Trajectory.spline(arm, [0, 0, 1, 1], [[0.0], [1.0]], degree=9), "degree"),
])
def test_trajectories_that_are_wrong(arm, make, message):
    with pytest.raises(ValueError, match=message):
        make(arm)


def test_obstacles_of_a_trajectory_rest(arm):
    path = ccd.Trajectory.through(arm, [0, 2], [[0.0], [1.5]])
    with pytest.raises(ValueError, match="mov|rest"):
        ccd.trajectory_toi(path, [(box(), ccd.Motion(velocity=(1, 0, 0)))])
    with pytest.raises(ValueError, match="jobs"):
        ccd.trajectory_toi(path, WALL, jobs=-1)
