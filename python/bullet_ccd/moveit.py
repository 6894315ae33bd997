"""MoveIt configurations: a robot, its planning groups and states, its end effectors, and the pairs of
links that may touch, from a URDF and an SRDF or from the folder that MoveIt's setup assistant writes.
"""
import os
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, FrozenSet, List, Mapping, Optional, Tuple, Union

from ._core import Hand, Robot

__all__ = ["Configuration", "EndEffector", "load"]

_Path = Union[str, "os.PathLike[str]"]


@dataclass(frozen=True)
class EndEffector:
    """A hand of a robot."""
    name: str
    group: str  #: of its own links
    parent_link: str  #: of the robot, to which it is fixed
    parent_group: Optional[str]


@dataclass(frozen=True)
class Configuration:
    """What an SRDF says about a robot."""
    robot: Robot
    urdf: Path
    srdf: Path
    groups: Mapping[str, Tuple[str, ...]]  #: joints that move by themselves, by group, base first
    states: Mapping[Tuple[str, str], Mapping[str, float]]  #: positions by (group, state)
    end_effectors: Mapping[str, EndEffector]
    disabled_pairs: FrozenSet[FrozenSet[str]]  #: links that are never tested against each other

    def self_pairs(self) -> List[Tuple[str, str]]:
        """The pairs of links to test: for articulated_toi() and trajectory_toi()."""
        return [pair for pair in self.robot.self_pairs()
                if frozenset(pair) not in self.disabled_pairs]

    def hand(self) -> Hand:
        """The robot as a hand to plan grasps with, where the whole robot is one."""
        return Hand.load(self.urdf, srdf=self.srdf)


def load(path: _Path, srdf: Optional[_Path] = None) -> Configuration:
    """Loads a URDF with its SRDF, or the folder of a MoveIt configuration.

    A folder has a file .setup_assistant, which names both files; the package of the URDF is looked for
    beside the folder and above it. Raises RuntimeError "<file>: <what>: <remedy>".
    """
    urdf = Path(path)
    if urdf.is_dir():
        found, named = _files_of(urdf)
        urdf, srdf = found, srdf or named
    if srdf is None:
        raise RuntimeError(f"{urdf}: no SRDF: give srdf=, or the folder of a MoveIt configuration")
    robot, file = Robot.load(urdf), Path(srdf)
    root = _root_of(file)
    groups = {element.get("name", ""): element for element in root.findall("group")}
    known = set(robot.link_names)
    pairs = set()
    for element in root.findall("disable_collisions"):
        names = frozenset((_name(element, "link1", file), _name(element, "link2", file)))
        for name in names - known:
            raise _error(file, f"<disable_collisions> names link '{name}', which the robot does not "
                         "have", "give the SRDF of this robot")
        pairs.add(names)
    return Configuration(
        robot=robot, urdf=urdf, srdf=file,
        groups={name: _joints_of(robot, groups, name, file, ()) for name in groups},
        states=_states_of(robot, root, groups, file),
        end_effectors={_name(element, "name", file): EndEffector(
            _name(element, "name", file), _name(element, "group", file),
            _name(element, "parent_link", file), element.get("parent_group"))
            for element in root.findall("end_effector")},
        disabled_pairs=frozenset(pairs))


def _error(file: Path, what: str, remedy: str) -> RuntimeError:
    return RuntimeError(f"{file}: {what}: {remedy}")


def _root_of(file: Path) -> ElementTree.Element:
    try:
        return ElementTree.parse(file).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise _error(file, f"cannot be read as XML ({error})", "give an SRDF") from error


def _name(element: ElementTree.Element, key: str, file: Path) -> str:
    value = element.get(key)
    if not value:
        raise _error(file, f"<{element.tag}> has no attribute '{key}'", "add it")
    return value


def _files_of(folder: Path) -> Tuple[Path, Path]:
    """URDF and SRDF that a configuration names."""
    assistant = folder / ".setup_assistant"
    try:
        text = assistant.read_text(encoding="utf-8")
    except OSError as error:
        raise _error(assistant, f"cannot be read ({error})",
                     "give the URDF, and the SRDF by srdf=") from error
    named = {}
    for kind in ("URDF", "SRDF"):
        block = re.search(rf"^( *){kind}: *\n((?:\1 +\w+:.*\n?)+)", text, flags=re.M)
        named[kind] = dict(re.findall(r"(\w+):[ \t]*['\"]?([^'\"\n]*)", block[2])) if block else {}
        if not named[kind].get("relative_path"):
            raise _error(assistant, f"names no relative_path of the {kind}",
                         "give the URDF, and the SRDF by srdf=")
    package, relative = named["URDF"].get("package", ""), named["URDF"]["relative_path"]
    places = [folder / relative] if not package else [
        place / package / relative for place in (folder.parent, *folder.parent.parents)]
    for place in places:
        if place.is_file():
            return place, folder / named["SRDF"]["relative_path"]
    raise _error(assistant, f"names {package}/{relative}, which is not beside the folder or above it",
                 "give the URDF, and the SRDF by srdf=")


def _joints_of(robot: Robot, groups: Dict[str, ElementTree.Element], name: str, file: Path,
               outer: Tuple[str, ...]) -> Tuple[str, ...]:
    """The joints of a group that move by themselves, in the order of the robot."""
    if name not in groups or name in outer:
        what = "contains itself" if name in outer else "does not exist"
        raise _error(file, f"group '{name}' {what}", "correct <group>")
    joints = set()
    parents, joint_of = robot.link_parents, robot.link_joints
    for element in groups[name]:
        key = element.get("name", "")
        if element.tag == "joint":
            joints.add(key)
            if key not in joint_of.values():
                raise _error(file, f"group '{name}': the robot has no joint '{key}'",
                             "give the SRDF of this robot")
        elif element.tag == "link":
            if key not in parents:
                raise _error(file, f"group '{name}': the robot has no link '{key}'",
                             "give the SRDF of this robot")
            joints.add(joint_of.get(key, ""))
        elif element.tag == "group":
            joints.update(_joints_of(robot, groups, key, file, (*outer, name)))
        elif element.tag == "chain":
            base, link = _name(element, "base_link", file), _name(element, "tip_link", file)
            while link != base:
                above = parents.get(link)
                if above is None:
                    raise _error(file, f"group '{name}': no chain from '{base}' to "
                                 f"'{element.get('tip_link')}'", "correct <chain>")
                joints.add(joint_of[link])
                link = above
    return tuple(joint for joint in robot.joint_names if joint in joints)


def _states_of(robot: Robot, root: ElementTree.Element, groups: Dict[str, ElementTree.Element],
               file: Path) -> Dict[Tuple[str, str], Mapping[str, float]]:
    states: Dict[Tuple[str, str], Mapping[str, float]] = {}
    for state in root.findall("group_state"):
        key = (_name(state, "group", file), _name(state, "name", file))
        if key[0] not in groups:
            raise _error(file, f"state '{key[1]}' is of group '{key[0]}', which does not exist",
                         "correct <group_state>")
        positions = {}
        for joint in state.findall("joint"):
            name, value = _name(joint, "name", file), _name(joint, "value", file)
            if name not in robot.joint_names:
                continue  # joints that are fixed or follow others
            try:
                positions[name] = float(value.split()[0])
            except ValueError as error:
                raise _error(file, f"state '{key[1]}': '{value}' is no position of joint '{name}'",
                             "give a number") from error
        states[key] = positions
    return states
