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
from ._core import GraspObject, Hand

__all__ = ["Grasp", "GraspContact", "GraspObject", "Hand", "PlanInterrupted", "close", "plan",
           "read_grasps", "write_grasps"]

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


class PlanInterrupted(KeyboardInterrupt):
    """Ctrl-C ended a plan. What had been found is not lost."""

    def __init__(self, grasps: List[Grasp]) -> None:
        super().__init__(f"the plan was interrupted after {len(grasps)} candidates")
        self.grasps = grasps  #: the candidates that were complete, best first


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
         time_limit: float = 0.0, friction: float = 0.5, cone_edges: int = 8,
         tolerance: float = _core.DEFAULT_TOLERANCE, force_closure_threshold: float = 0.005,
         volumes: int = 3, progress: Optional[Callable[[int], None]] = None) -> List[Grasp]:
    """Samples candidates, closes the hand, and ranks what it holds, best first.

    jobs is the number of threads (0: one per core); the result does not depend on it. After
    time_limit seconds (0: none) no candidate is begun. progress is called with the number of
    candidates that are complete. Ctrl-C raises PlanInterrupted, which holds the complete ones.
    """
    lines, complete = _core.plan(
        hand, object, candidates=candidates, seed=seed, jobs=jobs, time_limit=time_limit,
        friction=friction, cone_edges=cone_edges, tolerance=tolerance,
        force_closure_threshold=force_closure_threshold, volumes=volumes, progress=progress)
    grasps = _grasps(lines.split("\n"))
    if not complete:
        raise PlanInterrupted(grasps)
    return grasps


def close(hand: Hand, object: GraspObject, pose: Array,
          shift: Union[Sequence[float], Array] = (0.0, 0.0, 0.0), *,
          preshape: Optional[str] = None, friction: float = 0.5, cone_edges: int = 8,
          tolerance: float = _core.DEFAULT_TOLERANCE,
          force_closure_threshold: float = 0.005) -> Grasp:
    """Moves the open hand from a pose of its root link along a shift until its first contact, closes
    it there once, and says what it holds."""
    line = _core.close_at(hand, object, pose, shift, preshape=preshape, friction=friction,
                          cone_edges=cone_edges, tolerance=tolerance,
                          force_closure_threshold=force_closure_threshold)
    return _grasps([line])[0]


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
