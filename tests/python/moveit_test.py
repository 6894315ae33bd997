"""MoveIt configurations, of a robot that the test writes."""
import pytest

import bullet_ccd as ccd
from bullet_ccd import moveit

LINKS = ["base", "upper", "lower", "palm", "left", "right"]
URDF = "<robot name='arm'>" + "".join(
    f"<link name='{link}'><collision><origin xyz='0 0 0.1'/><geometry><box size='.05 .05 .15'/></geometry>"
    "</collision></link>" for link in LINKS) + "".join(
    f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>"
    f"<origin xyz='{place} 0 0.2'/><axis xyz='1 0 0'/><limit lower='-3' upper='3' effort='1' velocity='1'/></joint>"
    for name, kind, parent, child, place in [
        ("shoulder", "revolute", "base", "upper", 0), ("elbow", "revolute", "upper", "lower", 0),
        ("wrist", "fixed", "lower", "palm", 0), ("thumb", "revolute", "palm", "left", -0.1),
        ("finger", "revolute", "palm", "right", 0.1)]) + "</robot>"
SRDF = """<robot name="arm">
<group name="arm"><chain base_link="base" tip_link="palm"/></group>
<group name="hand"><link name="left"/><joint name="finger"/></group>
<group name="all"><group name="arm"/><group name="hand"/></group>
<group_state name="home" group="arm"><joint name="shoulder" value="0"/><joint name="elbow" value="1.5"/></group_state>
<end_effector name="gripper" parent_link="palm" group="hand"/>
<disable_collisions link1="upper" link2="palm" reason="Never"/>
</robot>"""


@pytest.fixture
def files(tmp_path):
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "arm.srdf").write_text(SRDF)
    return tmp_path / "arm.urdf", tmp_path / "arm.srdf"


def test_groups_states_end_effectors_and_pairs(files):
    arm = moveit.load(*files)
    assert arm.robot.joint_names == ["shoulder", "elbow", "finger", "thumb"]
    assert arm.groups == {"arm": ("shoulder", "elbow"), "hand": ("finger", "thumb"),
                          "all": ("shoulder", "elbow", "finger", "thumb")}
    assert arm.states[("arm", "home")] == {"shoulder": 0.0, "elbow": 1.5}
    assert arm.end_effectors["gripper"] == moveit.EndEffector("gripper", "hand", "palm", None)
    everything = {frozenset(pair) for pair in arm.robot.self_pairs()}
    assert everything - {frozenset(pair) for pair in arm.self_pairs()} == {frozenset(("upper", "palm"))}
    # A state is a posture, and the pairs are those of a query.
    hit = ccd.articulated_toi(arm.robot, arm.states[("arm", "home")], {"elbow": 3.0}, [],
                              self_pairs=arm.self_pairs())
    assert hit.is_contact


def test_a_folder_of_the_setup_assistant(tmp_path):
    folder, package = tmp_path / "arm_moveit_config", tmp_path / "arm_description" / "urdf"
    (folder / "config").mkdir(parents=True)
    package.mkdir(parents=True)
    (package / "arm.urdf").write_text(URDF)
    (folder / "config" / "arm.srdf").write_text(SRDF)
    (folder / ".setup_assistant").write_text(
        "moveit_setup_assistant_config:\n  URDF:\n    package: arm_description\n    relative_path: urdf/arm.urdf\n"
        "    xacro_args: \"\"\n  SRDF:\n    relative_path: config/arm.srdf\n  CONFIG:\n    author_name: x\n")
    assert moveit.load(folder).groups["arm"] == ("shoulder", "elbow")
    (package / "arm.urdf").unlink()
    with pytest.raises(RuntimeError, match="arm_description/urdf/arm.urdf, which is not"):
        moveit.load(folder)


@pytest.mark.parametrize("old, new, message", [
    ('link1="upper"', 'link1="uper"', "no.*'uper'|'uper', which the robot does not have"),
    ('<joint name="finger"/>', '<joint name="fingr"/>', "no joint 'fingr'"),
    ('tip_link="palm"', 'tip_link="nose"', "no chain from 'base' to 'nose'"),
    ('<group name="hand"/>', '<group name="all"/>', "contains itself"),
    ('<group name="hand"/>', '<group name="hands"/>', "'hands' does not exist"),
    ('value="1.5"', 'value="bent"', "'bent' is no position"),
    ('group="arm"', 'group="leg"', "'leg', which does not exist"),
    ('parent_link="palm"', '', "no attribute 'parent_link'"),
    ("</robot>", "", "cannot be read as XML"),
])
def test_what_is_wrong_is_named(files, old, new, message):
    files[1].write_text(SRDF.replace(old, new))
    with pytest.raises(RuntimeError, match="arm.srdf: .*(" + message + ")"):
        moveit.load(*files)


def test_an_srdf_must_be_given(files):
    with pytest.raises(RuntimeError, match="no SRDF"):
        moveit.load(files[0])
    with pytest.raises(RuntimeError, match=".setup_assistant"):
        moveit.load(files[0].parent)
