"""An arm with a gripper takes a cube and puts it down elsewhere."""
import os
from pathlib import Path

import numpy as np
import pytest

import bullet_ccd
from bullet_ccd import grasp
from shapes import at, box

ROBOTS = Path(os.environ["BULLET_CCD_SHARE"]) / "robots"
HALF = 0.02


@pytest.fixture(scope="module")
def scene():
    arm = bullet_ccd.Robot.load(ROBOTS / "arms/seven_joint_arm.urdf")
    hand = grasp.Hand.load(ROBOTS / "parallel_gripper/parallel_gripper.urdf")
    table = box(0.4)
    return arm, hand, grasp.GraspObject(box(HALF), name="cube"), table


def planned(scene, target, **options):
    arm, hand, cube, table = scene
    return grasp.pick_place(arm, hand, cube, at(0.45, 0, HALF), target, (0.1, 0.1),
                            obstacles=[("table", table, at(0.6, 0, -0.4))], **options)


def test_a_cube_is_put_down_where_it_is_told(scene):
    try:
        plan = planned(scene, (0.45, 0.2, 0.0))
    except RuntimeError as error:
        pytest.skip(str(error))
    assert plan.solved and plan.failure is None, plan.failure
    assert [leg.name for leg in plan.legs] == ["transit", "approach", "close", "lift", "carry",
                                               "place", "open", "retreat", "return"]
    assert (np.abs(plan.object_end[:3, 3] - (0.45, 0.2, HALF)) <= (0.05, 0.05, 1e-3)).all()
    last = -1.0
    for leg in plan.legs:
        assert leg.times[0] >= last and (np.diff(leg.times) > 0).all()
        assert leg.positions.shape == (len(leg.times), len(plan.joints))
        last = leg.times[-1]
    # Each motion begins where the one before it ended, and the last where the first began.
    for before, after in zip(plan.legs, plan.legs[1:] + plan.legs[:1]):
        np.testing.assert_array_equal(before.positions[-1], after.positions[0])
    assert plan.duration == last and "joint_names" in plan.yaml


def test_what_cannot_be_reached_says_so(scene):
    try:
        plan = planned(scene, (5.0, 0.2, 0.0))
    except RuntimeError as error:
        pytest.skip(str(error))
    assert not plan.solved and plan.failure and not plan.legs and plan.duration == 0.0
    assert all(reason for _, _, reason in plan.attempts)


def test_bad_input_is_named(scene):
    try:
        with pytest.raises(ValueError, match="no joint elbow above its hand"):
            planned(scene, (0.45, 0.2, 0.0), start={"elbow": 1.0})
    except RuntimeError as error:
        pytest.skip(str(error))
    arm, hand, cube, table = scene
    with pytest.raises(ValueError, match="table"):
        grasp.pick_place(arm, hand, cube, at(0.45, 0, 0), (0.45, 0.2, 0), (0.1, 0.1),
                         obstacles=[("table", table, at(0.6, 0, -0.4))])
    with pytest.raises(ValueError, match="target"):
        grasp.pick_place(arm, hand, cube, at(0.45, 0, 1), (0.45, np.nan, 0), (0.1, 0.1))
