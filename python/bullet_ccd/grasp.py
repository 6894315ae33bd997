"""Grasp planning: hands, objects, plans, and grasps as records.

A record is a line of the file that the program `grasp plan` writes (grasps.jsonl), so grasps of
either can be read by the other.
"""
import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._core import GraspObject, Hand, Mesh, Robot

__all__ = ["Forces", "Grasp", "GraspContact", "GraspObject", "Hand", "Leg", "PickPlacePlan",
           "PlanInterrupted", "Pull", "Squeeze", "Trial", "close", "forces", "pick_place", "plan",
           "read_grasps", "squeeze", "trial", "write_grasps"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GraspContact:
    """A contact of a link on the object, in the frame of the object's mesh."""
    link: str
    point: Array  #: on the object [m]
    normal: Array  #: unit, into the object
    gap: float  #: distance of the two surfaces [m]


@dataclass(frozen=True, eq=False)
class Grasp:
    """One candidate. Poses are those of the hand's root link in the frame of the object's mesh."""
    rank: Optional[int]  #: 1 is best
    candidate: int  #: number in the sampling sequence
    reject: Optional[str]  #: None for a force closure, else the reason
    preshape: str
    epsilon: float  #: radius of the largest ball in the wrench space
    volume: Optional[float]  #: of the wrench space; None unless among the best
    force_closure: bool
    pose: Optional[Array]  #: None if the hand never closed
    joints: Dict[str, float]  #: final positions of all movable joints [rad or m]
    preshape_joints: Dict[str, float]  #: before closing
    start_pose: Optional[Array]
    approach: Optional[Array]  #: unit direction
    contacts: Tuple[GraspContact, ...]
    record: Dict[str, Any] = field(repr=False)  #: as it stands in the file

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Grasp) and self.record == other.record

    def __hash__(self) -> int:
        return hash((self.candidate, self.epsilon))


@dataclass(frozen=True, eq=False)
class Squeeze:
    """How hard each joint presses so that a grasp holds firmly. Dictionaries are by joint."""
    reason: Optional[str]  #: why there is none; None: there is one
    torques: Dict[str, float]  #: [N m or N]
    targets: Dict[str, float]  #: positions that make a controller press so [rad or m]
    stiffness: Dict[str, float]  #: of that controller [N m/rad or N/m]
    normal_force: float  #: sum over the contacts [N]
    assumed_efforts: List[str]  #: joints whose efforts the robot does not say, or not believably


@dataclass(frozen=True, eq=False)
class Pull:
    """One pull of the protocol `pull`."""
    wrench: Array  #: force, and moment over the object's radius; of length 1
    size: float  #: at which the object slipped, or the largest that was tried [N]
    share: float  #: size over the sum of the normal forces then
    slipped: bool


@dataclass(frozen=True, eq=False)
class Trial:
    """What a simulated trial of a grasp came to."""
    outcome: str  #: held, slipped, dropped, ejected, ..: see grasp/trial/README.md
    reason: Optional[str]
    slip: float  #: largest way of the centre of mass under load [m]
    turn: float  #: largest turn under load [rad]
    lost_at: Optional[float]  #: since the trial began [s]
    peak_force: float  #: largest normal force of a contact point [N]
    mean_force: float  #: of all normal forces together, over the time under load [N]
    peak_energy: float  #: kinetic, of the object under load [J]
    peak_torques: Dict[str, float]  #: by joint [N m or N]
    mean_torques: Dict[str, float]  #: of their sizes, over the time under load, same
    pulls: Tuple[Pull, ...]
    intersecting_triangles: int  #: the worst that the independent check found
    penetration: float  #: [m]
    simulated_time: float  #: [s]

    @property
    def held(self) -> bool:
        return self.outcome == "held"


@dataclass(frozen=True, eq=False)
class Forces:
    """Contact forces that balance a load."""
    status: str  #: balanced, infeasible, unbounded or undecided
    reason: Optional[str]
    value: float  #: of the objective [N]
    bound: float  #: no forces have a better value [N]
    contact_forces: Array  #: n x 3, on the object, in its frame [N]; in the order of the contacts
    joint_torques: Dict[str, float]  #: that the contacts need [N m or N]

    @property
    def balanced(self) -> bool:
        return self.status == "balanced"


@dataclass(frozen=True, eq=False)
class Leg:
    """One motion of a task. The joints rest at every waypoint and move linearly between two, by the
    polynomial of fifth degree whose velocities and accelerations are zero at both ends."""
    name: str  #: transit, approach, close, lift, carry, place, open, retreat or return
    carries: bool  #: the object moves with the hand
    clearance: float  #: certified: nothing comes nearer [m]
    times: Array  #: n, of the whole task [s]
    positions: Array  #: n x joints [rad or m]


@dataclass(frozen=True, eq=False)
class PickPlacePlan:
    """How an arm takes an object and puts it down elsewhere, or why it does not."""
    solved: bool
    failure: Optional[str]  #: why there is no plan
    attempts: Tuple[Tuple[int, Optional[str], Optional[str]], ...]  #: candidate, failed leg, reason
    joints: Tuple[str, ...]  #: in the order of all positions
    legs: Tuple[Leg, ...]
    duration: float  #: [s]; 0 if there is no plan
    object_start: Optional[Array]  #: pose in the world
    object_end: Optional[Array]
    hand_pose_in_object: Optional[Array]
    yaml: str = field(repr=False)  #: as trajectory_msgs/JointTrajectory; empty without a plan
    record: Dict[str, Any] = field(repr=False)  #: as plan.json has it: see grasp/task/README.md


class PlanInterrupted(KeyboardInterrupt):
    """Ctrl-C ended a plan. What had been found is not lost."""

    def __init__(self, grasps: List[Grasp]) -> None:
        super().__init__(f"the plan was interrupted after {len(grasps)} candidates")
        self.grasps = grasps  #: the candidates that were complete, best first

    def __reduce__(self) -> Tuple[Any, ...]:
        return PlanInterrupted, (self.grasps,)


def _pose(value: Optional[Dict[str, Any]]) -> Optional[Array]:
    if value is None:
        return None
    w, x, y, z = value["quaternion_wxyz"]
    pose: Array = np.eye(4)
    pose[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    pose[:3, 3] = value["position_m"]
    return pose


def _grasp(record: Dict[str, Any]) -> Grasp:
    approach = record.get("approach") or {}
    direction = approach.get("direction")
    quality = record["quality"]
    return Grasp(
        rank=record.get("rank"), candidate=record["candidate"], reject=record["reject"],
        preshape=record["preshape"], epsilon=quality["epsilon"], volume=quality["volume"],
        force_closure=quality["force_closure"], pose=_pose(record["hand_pose_in_object"]),
        joints=dict(record["joints"] or {}),
        preshape_joints=dict(record.get("preshape_joints") or {}),
        start_pose=_pose(approach.get("start_pose_in_object")),
        approach=None if direction is None else np.array(direction),
        contacts=tuple(GraspContact(contact["link"], np.array(contact["point_m"]),
                                    np.array(contact["normal_into_object"]), contact["gap_m"])
                       for contact in record["contacts"]),
        record=record)


def _grasps(lines: Iterable[str]) -> List[Grasp]:
    return [_grasp(json.loads(line)) for line in lines if line.strip()]


def plan(hand: Hand, object: GraspObject, *, candidates: int = 20, seed: int = 1, jobs: int = 0,
         time_limit: float = 0.0, friction: float = 0.5, cone_edges: int = 0,
         tolerance: float = _core.DEFAULT_TOLERANCE, force_closure_threshold: float = 0.005,
         volumes: int = 3, mass: Optional[float] = None,
         progress: Optional[Callable[[int], None]] = None) -> List[Grasp]:
    """Samples candidates, closes the hand, and ranks what it holds, best first.

    jobs is the number of threads (0: one per core); the result does not depend on it. After
    time_limit seconds (0: none) no candidate is begun. progress is called with the number of
    candidates that are complete. Ctrl-C raises PlanInterrupted, which holds the complete ones.
    Records say which mass [kg] a grasp holds; that of the object is mass, or object.usual_mass.
    """
    lines, complete = _core.plan(
        hand, object, candidates=candidates, seed=seed, jobs=jobs, time_limit=time_limit,
        friction=friction, cone_edges=cone_edges, tolerance=tolerance,
        force_closure_threshold=force_closure_threshold, volumes=volumes, mass=mass,
        progress=progress)
    grasps = _grasps(lines.split("\n"))
    if not complete:
        raise PlanInterrupted(grasps)
    return grasps


def close(hand: Hand, object: GraspObject, pose: Array,
          shift: Union[Sequence[float], Array] = (0.0, 0.0, 0.0), *,
          preshape: Optional[str] = None, friction: float = 0.5, cone_edges: int = 0,
          tolerance: float = _core.DEFAULT_TOLERANCE,
          force_closure_threshold: float = 0.005, mass: Optional[float] = None) -> Grasp:
    """Moves the open hand from a pose of its root link along a shift until its first contact, closes
    it there once, and says what it holds."""
    line = _core.close_at(hand, object, pose, shift, preshape=preshape, friction=friction,
                          cone_edges=cone_edges, tolerance=tolerance,
                          force_closure_threshold=force_closure_threshold, mass=mass)
    return _grasps([line])[0]


def _mass(grasp: Grasp, mass: Optional[float]) -> float:
    recorded = grasp.record["plan"].get("mass_kg") if mass is None else mass
    if recorded is None:
        raise ValueError("mass: the record of the grasp says none: give one, such as "
                         "GraspObject.usual_mass")
    return float(recorded)


def squeeze(hand: Hand, grasp: Grasp, *, mass: Optional[float] = None, friction: float = 0.5,
            firmness: float = 12.0, efforts: Optional[Dict[str, float]] = None) -> Squeeze:
    """The torques, within the joints' efforts, that press a grasp's contacts together so that half
    of firmness times the weight may pull in any direction before a contact slips, and the normal
    forces add up to firmness times weight / friction at least. efforts [N m or N] by joint count in
    place of those of the robot. Without a mass [kg] of the object, that of the plan counts."""
    answer = _core.squeeze(hand, json.dumps(grasp.record), mass=_mass(grasp, mass),
                           center_of_mass=grasp.record["object"]["center_of_mass_m"], friction=friction, firmness=firmness, efforts=efforts or {})
    return Squeeze(**answer)


def trial(hand: Hand, object: GraspObject, grasp: Grasp, protocol: str = "six", *,
          mass: Optional[float] = None, friction: float = 0.5, firmness: float = 12.0,
          efforts: Optional[Dict[str, float]] = None, surface_friction: Optional[float] = None,
          rate: float = 120.0, up: Union[Sequence[float], Array] = (0.0, 0.0, 1.0),
          seed: int = 1) -> Trial:
    """Simulates whether a grasp holds: the hand squeezes, and the protocol loads the object.

    protocol is six, hover, shake, lift, pull or disturb, or the path of a YAML file. The same
    arguments give the same answer. up is the direction that is up for the object; rate is the
    number of steps per second; surface_friction is that of the surfaces, where it is not what the
    squeeze counts on. Without a mass [kg] of the object, that of the plan counts. Ctrl-C raises
    KeyboardInterrupt.
    """
    answer = _core.trial(hand, object, json.dumps(grasp.record), protocol, mass=_mass(grasp, mass),
                         friction=friction, firmness=firmness, efforts=efforts or {},
                         surface_friction=surface_friction, rate=rate, up=up, seed=seed)
    answer["pulls"] = tuple(Pull(*pull) for pull in answer["pulls"])
    return Trial(**answer)


def forces(hand: Hand, object: GraspObject, grasp: Grasp,
           load: Union[Sequence[float], Array], *, friction: float = 0.5,
           objective: str = "total", efforts: Optional[Dict[str, float]] = None) -> Forces:
    """The contact forces that balance a load (force [N] and moment about the object's centre of mass
    [N m], in the object's frame), within friction and the joints' efforts.

    objective is total (least sum of the normal forces), max (least largest one) or firm (largest
    margin to slip).
    """
    return Forces(**_core.forces(hand, object, json.dumps(grasp.record), load, friction=friction,
                                 objective=objective, efforts=efforts or {}))


def pick_place(arm: Robot, hand: Hand, object: GraspObject, object_pose: Array,
               target: Union[Sequence[float], Array], target_size: Union[Sequence[float], Array], *,
               obstacles: Sequence[Tuple[str, Mesh, Optional[Array]]] = (),
               start: Optional[Dict[str, float]] = None, root_pose: Optional[Array] = None,
               flange: str = "", mount: Optional[Array] = None, candidates: int = 80,
               tries: int = 20, approach: float = 0.1, lift: float = 0.1, acceleration: float = 5.0,
               mass: Optional[float] = None, seed: int = 1,
               time_limit: float = 0.0) -> PickPlacePlan:
    """Plans how an arm with a hand takes an object and puts it down in a level rectangle. Every motion
    on the way is certified as a whole, as it is timed: nothing touches, between samples neither.

    Poses are those of the world, whose z is up. The middle of the object ends within target_size [m]
    around target. obstacles are names, meshes and poses. start has positions of joints of the arm (0
    where it has none, or the limit next to it). The hand is mounted on the link `flange` (empty: the
    arm's end) with the pose `mount` in it. candidates grasps are planned, and the best `tries` force
    closures are tried, of those that hold twice the mass [kg] of the object (mass, or
    object.usual_mass). approach and lift are straight ways [m]; acceleration is that of any joint at
    most. After time_limit seconds (0: none) the search ends without a plan; Ctrl-C raises
    KeyboardInterrupt. Raises ValueError if the object intersects an obstacle where it starts, or the
    arm does, and RuntimeError in a build without OMPL.
    """
    text, yaml = _core.pick_place(
        arm, hand, object, object_pose, target, target_size, obstacles=list(obstacles),
        start=start or {}, root_pose=root_pose, flange=flange, mount=mount, candidates=candidates,
        tries=tries, approach=approach, lift=lift, acceleration=acceleration, mass=mass, seed=seed,
        time_limit=time_limit)
    record = json.loads(text)
    legs = tuple(Leg(leg["leg"], leg["carries"], leg["certified_clearance_m"],
                     np.array([point["time_s"] for point in leg["waypoints"]]),
                     np.array([point["positions"] for point in leg["waypoints"]]))
                 for leg in record.get("legs", ()))
    taken = record.get("grasp") or {}
    return PickPlacePlan(
        solved=record["solved"], failure=record["failure"],
        attempts=tuple((attempt["candidate"], attempt["failed_leg"], attempt["reason"])
                       for attempt in record["attempts"]),
        joints=tuple(record.get("joints", ())), legs=legs, duration=record.get("duration_s", 0.0),
        object_start=_pose(record["object_start"]), object_end=_pose(record.get("object_end")),
        hand_pose_in_object=_pose(taken.get("hand_pose_in_object")), yaml=yaml, record=record)


def read_grasps(path: Union[str, "os.PathLike[str]"]) -> List[Grasp]:
    """Reads a file of records. Raises RuntimeError "<file>:<line>: <what>" if it holds others."""
    grasps = []
    for number, line in enumerate(Path(path).read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip():
            continue
        try:
            grasps.append(_grasp(json.loads(line)))
        except (ValueError, KeyError, TypeError) as error:
            raise RuntimeError(f"{path}:{number}: not a record of a grasp ({error}): give a file "
                               "that grasp plan or write_grasps() wrote") from error
    return grasps


def write_grasps(path: Union[str, "os.PathLike[str]"], grasps: Iterable[Grasp]) -> None:
    """Writes records, in the order given."""
    Path(path).write_text("".join(json.dumps(grasp.record) + "\n" for grasp in grasps),
                          encoding="utf-8")
