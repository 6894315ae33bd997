"""Does a grasp hold: forces, squeezes and trials of a parallel gripper on a cube."""
import os
from pathlib import Path

import numpy as np
import pytest

from bullet_ccd import grasp
from shapes import box

GRIPPER = (Path(os.environ["BULLET_CCD_SHARE"]) /
           "robots/parallel_gripper/parallel_gripper.urdf")
GRAVITY = 9.80665


@pytest.fixture(scope="module")
def held():
    hand = grasp.Hand.load(GRIPPER)
    cube = grasp.GraspObject(box(0.02), name="cube")
    return hand, cube, grasp.plan(hand, cube, candidates=12, seed=3)


def test_forces_balance_the_load(held):
    hand, cube, grasps = held
    weight = 0.2 * GRAVITY
    answer = grasp.forces(hand, cube, grasps[0], [0, 0, -weight, 0, 0, 0])
    assert answer.balanced and answer.reason is None
    np.testing.assert_allclose(answer.contact_forces.sum(axis=0), [0, 0, weight], atol=1e-6)
    normals = np.array([contact.normal for contact in grasps[0].contacts])
    pressed = (answer.contact_forces * normals).sum(axis=1)
    assert (pressed >= -1e-9).all()
    assert answer.value == pytest.approx(pressed.sum(), abs=1e-6)
    # No forces can hold 1000 t within the efforts of the jaws.
    far = grasp.forces(hand, cube, grasps[0], [0, 0, -1e7, 0, 0, 0])
    assert not far.balanced and far.reason and len(far.contact_forces) == 0


def test_a_squeeze_presses_as_firmly_as_it_is_told(held):
    hand, _, grasps = held
    answer = grasp.squeeze(hand, grasps[0], mass=0.1, friction=0.5, firmness=4)
    assert answer.reason is None and answer.torques.keys() == answer.targets.keys()
    assert answer.normal_force >= 4 * 0.1 * GRAVITY / 0.5 * (1 - 1e-6)
    firmer = grasp.squeeze(hand, grasps[0], mass=0.1, friction=0.5, firmness=8)
    assert firmer.normal_force == pytest.approx(2 * answer.normal_force, rel=1e-3)
    weak = grasp.squeeze(hand, grasps[0], mass=0.1,
                         efforts=dict.fromkeys(answer.torques, 1e-4))
    assert weak.reason is not None and not weak.torques
    with pytest.raises(KeyError, match="no joint 'thumb'"):
        grasp.squeeze(hand, grasps[0], efforts={"thumb": 1.0})


def test_the_mass_is_that_of_the_plan_and_follows_from_the_volume(held):
    hand, cube, grasps = held
    plan = grasps[0].record["plan"]
    assert plan["mass_from"] == cube.usual_mass_from == "volume"
    assert plan["mass_kg"] == cube.usual_mass
    same = grasp.squeeze(hand, grasps[0], mass=cube.usual_mass)
    assert grasp.squeeze(hand, grasps[0]).targets == same.targets
    given = grasp.plan(hand, cube, candidates=1, mass=0.2)[0].record["plan"]
    assert (given["mass_kg"], given["mass_from"]) == (0.2, "given")


def test_a_trial_holds_with_friction_and_not_without(held, tmp_path):
    hand, cube, grasps = held
    file = tmp_path / "weight.yaml"
    file.write_text("phases:\n  - load: {direction: [0, 0, -1], seconds: 1}\n")
    first = grasp.trial(hand, cube, grasps[0], str(file), mass=0.1)
    again = grasp.trial(hand, cube, grasps[0], str(file), mass=0.1)
    assert first.held and first.slip < 1e-3 and first.intersecting_triangles == 0
    assert (first.slip, first.peak_force) == (again.slip, again.peak_force)
    smooth = grasp.trial(hand, cube, grasps[0], str(file), mass=0.1, surface_friction=0.0)
    assert not smooth.held


def test_a_protocol_of_ones_own_pulls_until_it_slips(held, tmp_path):
    hand, cube, grasps = held
    file = tmp_path / "away.yaml"
    file.write_text("phases:\n  - pull: {force: [0, 0, 1], moment: [0, 0, 0]}\n")
    pulled = grasp.trial(hand, cube, grasps[0], str(file), mass=0.1)
    assert len(pulled.pulls) == 1
    np.testing.assert_allclose(pulled.pulls[0].wrench, [0, 0, 1, 0, 0, 0])
    assert 0 < pulled.pulls[0].share <= 1 and pulled.pulls[0].size > 0


def test_what_is_wrong_is_said(held):
    hand, cube, grasps = held
    with pytest.raises(RuntimeError, match="nosuch"):
        grasp.trial(hand, cube, grasps[0], "nosuch")
    with pytest.raises(ValueError, match="mass"):
        grasp.squeeze(hand, grasps[0], mass=-1)
    with pytest.raises(ValueError, match="objective"):
        grasp.forces(hand, cube, grasps[0], np.zeros(6), objective="best")
    with pytest.raises(ValueError, match="load"):
        grasp.forces(hand, cube, grasps[0], np.zeros(5))
    open_grasp = [g for g in grasps if g.pose is None]
    if open_grasp:
        with pytest.raises(ValueError, match="never closed"):
            grasp.squeeze(hand, open_grasp[0])
