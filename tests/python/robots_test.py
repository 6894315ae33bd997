"""Robots and grasps, on what ships with the project."""
import os
import signal
import threading
from pathlib import Path

import numpy as np
import pytest

import bullet_ccd as ccd
from bullet_ccd import grasp
from shapes import arm, at, box, turned  # noqa: F401

SHARE = Path(os.environ["BULLET_CCD_SHARE"])
HAND = SHARE / "robots/anthropomorphic_hand/anthropomorphic_hand.urdf"
GRIPPER = SHARE / "robots/parallel_gripper/parallel_gripper.urdf"


def test_an_arm_meets_a_wall_at_the_angle_of_the_closed_form(arm):
    # The face y = 0.05 of the bar, which turns about z, meets the plane y = 0.55 with its corner
    # (1, 0.05): sin(q) + 0.05 cos(q) = 0.55.
    angle = np.arcsin(0.55 / np.hypot(1, 0.05)) - np.arctan2(0.05, 1)
    hit = ccd.articulated_toi(arm, {"turn": 0.0}, {"turn": 1.5}, [(box(2.0), at(0, 2.55))], tolerance=1e-8)
    assert hit.status == ccd.Status.HIT
    assert hit.time == pytest.approx(angle / 1.5, abs=1e-6)
    assert hit.contacts[0].link == "bar" and hit.contacts[0].obstacle == 0
    assert hit.contacts[0].other_link is None
    np.testing.assert_allclose(hit.contacts[0].normal, [0, 1, 0], atol=1e-3)


def test_positions_are_dictionaries_or_arrays(arm):
    assert arm.joint_names == ["turn"] and arm.joint_limits == [(-3.0, 3.0)]
    np.testing.assert_allclose(arm.link_poses({"turn": 0.5})["bar"], turned((0, 0, 1), 0.5), atol=1e-12)
    np.testing.assert_allclose(arm.link_poses([0.5], root=at(1))["bar"], turned((0, 0, 1), 0.5, (1, 0, 0)),
                               atol=1e-12)
    with pytest.raises(KeyError, match="no joint 'elbow'"):
        arm.link_poses({"elbow": 1})
    with pytest.raises(ValueError, match="positions"):
        arm.link_poses([1, 2])


def test_a_root_that_moves(arm):
    hit = ccd.articulated_toi(arm, None, None, [(box(), at(0, 3))], root_start=at(0), root_end=at(0, 4))
    assert hit.time == pytest.approx((2.5 - 0.05) / 4, abs=1e-4)


def test_links_meet_each_other():
    hand = ccd.Robot.load(HAND)
    closed = {name: high for name, (_, high) in zip(hand.joint_names, hand.joint_limits)}
    pairs = hand.self_pairs()
    assert all(a != b for a, b in pairs)
    hit = ccd.articulated_toi(hand, {}, closed, [], self_pairs=pairs)
    assert hit.is_contact and hit.contacts[0].other_link is not None
    with pytest.raises(KeyError, match="no link 'nose'"):
        ccd.articulated_toi(hand, {}, closed, [], self_pairs=[("nose", "palm")])


def test_files_that_are_wrong(tmp_path):
    with pytest.raises(RuntimeError, match="none.urdf"):
        ccd.Robot.load(tmp_path / "none.urdf")
    with pytest.raises(RuntimeError, match="none.urdf"):
        grasp.Hand.load(tmp_path / "none.urdf")


@pytest.fixture(scope="module")
def gripper():
    return grasp.Hand.load(GRIPPER)


@pytest.fixture(scope="module")
def cube():
    return grasp.GraspObject(box(0.02), name="cube")


def test_a_plan_does_not_depend_on_threads(gripper, cube, tmp_path):
    counts = []
    grasps = grasp.plan(gripper, cube, candidates=12, seed=3, progress=counts.append)
    assert sorted(counts) == list(range(1, 13))
    alone = grasp.plan(gripper, cube, candidates=12, seed=3, jobs=1)
    assert [g.record for g in alone] == [g.record for g in grasps]
    assert [g.rank for g in grasps] == list(range(1, 13))
    path = tmp_path / "grasps.jsonl"
    grasp.write_grasps(path, grasps)
    assert grasp.read_grasps(path) == grasps
    best = grasps[0]
    assert best.reject is None and best.force_closure and best.epsilon >= 0.005
    assert {contact.link for contact in best.contacts} <= set(ccd.Robot.load(GRIPPER).link_names)
    # Contacts are on the surface of the cube, and normals point into it.
    for contact in best.contacts:
        assert np.abs(contact.point).max() == pytest.approx(0.02, abs=1e-9)
        assert contact.normal @ contact.point < 0
        assert 0 <= contact.gap <= 1.1e-4


def test_closing_at_the_pose_of_a_grasp_finds_it_again(gripper, cube):
    best = grasp.plan(gripper, cube, candidates=12, seed=3)[0]
    again = grasp.close(gripper, cube, best.pose, preshape=best.preshape)
    assert again.reject is None
    assert again.joints == pytest.approx(best.joints, abs=1e-3)
    with pytest.raises(KeyError, match="preshape 'fist'"):
        grasp.close(gripper, cube, best.pose, preshape="fist")


def test_ctrl_c_ends_a_plan_and_loses_nothing(gripper, cube):
    sent = []

    def interrupt(count):  # of several candidates at once, if they are quick
        if count >= 5 and not sent:
            sent.append(count)
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt) as caught:
        grasp.plan(gripper, cube, candidates=100000, progress=interrupt)
    assert isinstance(caught.value, grasp.PlanInterrupted)
    assert 5 <= len(caught.value.grasps) < 100000


def test_errors_of_callbacks_and_options_come_through(gripper, cube):
    def complain(count):
        raise LookupError("no more")

    with pytest.raises(LookupError, match="no more"):
        grasp.plan(gripper, cube, candidates=50, progress=complain)
    with pytest.raises(ValueError):
        grasp.plan(gripper, cube, candidates=-1)
    with pytest.raises(ValueError):
        grasp.plan(gripper, cube, friction=-1)


def test_hands_say_what_they_are(gripper):
    assert len(gripper.finger_names) == 2
    assert gripper.preshapes and gripper.grasp_frame.shape == (4, 4)


def test_records_that_are_wrong(tmp_path):
    path = tmp_path / "bad.jsonl"
    path.write_text('{"schema": 1}\n')
    with pytest.raises(RuntimeError, match="bad.jsonl:1"):
        grasp.read_grasps(path)
