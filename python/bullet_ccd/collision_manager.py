"""A world of named objects, with the method names of trimesh's CollisionManager."""
from dataclasses import dataclass
from typing import Any, Dict, FrozenSet, Iterable, List, Mapping, Optional, Set, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arguments import as_mesh

Pose = NDArray[np.float64]
_EXTERNAL = "__external"  # the name that trimesh gives to a mesh that is not in the world


@dataclass(frozen=True)
class ContactData:
    """A contact of two objects that intersect."""
    names: FrozenSet[str]
    point: NDArray[np.float64]  #: in the middle of the two witnesses [m]
    normal: NDArray[np.float64]  #: unit, from the first name (in alphabetical order) to the second
    depth: float  #: 0 where only surfaces are known to intersect


@dataclass(frozen=True)
class DistanceData:
    """The closest points of two objects."""
    names: FrozenSet[str]
    distance: float  #: [m]
    points: Mapping[str, NDArray[np.float64]]  #: by name, in the world [m]

    def point(self, name: str) -> NDArray[np.float64]:
        """The closest point on that object [m]."""
        return self.points[name]


class CollisionManager:
    """Objects at poses. Distances and intersections are those of surfaces: a small object that floats
    inside a large one does not intersect it. first_contact() also says when moving objects meet.

    Hierarchies are built when an object is added; give a bullet_ccd.Mesh to share one among objects.
    """

    def __init__(self) -> None:
        self._meshes: Dict[str, _core.Mesh] = {}
        self._poses: Dict[str, Pose] = {}

    def __contains__(self, name: object) -> bool:
        return name in self._meshes

    def __len__(self) -> int:
        return len(self._meshes)

    @property
    def names(self) -> List[str]:
        """In the order in which they were added."""
        return list(self._meshes)

    def add_object(self, name: str, mesh: Any, transform: Optional[Pose] = None) -> None:
        """Adds an object, or replaces the one of that name."""
        converted = as_mesh(mesh, name=name)
        self._poses[name] = _pose(transform, name)
        self._meshes[name] = converted

    def remove_object(self, name: str) -> None:
        """Raises KeyError if there is none of that name."""
        self._known(name)
        del self._meshes[name], self._poses[name]

    def set_transform(self, name: str, transform: Optional[Pose]) -> None:
        """Raises KeyError if there is none of that name, ValueError for what is no pose."""
        self._known(name)
        self._poses[name] = _pose(transform, name)

    def transform(self, name: str) -> Pose:
        """The pose of an object in the world (a copy)."""
        self._known(name)
        return self._poses[name].copy()

    def _known(self, name: str) -> None:
        if name not in self._meshes:
            raise KeyError(f"the world has no object named '{name}'")

    # Intersections

    def in_collision_single(self, mesh: Any, transform: Optional[Pose] = None,
                            return_names: bool = False, return_data: bool = False) -> Any:
        """Whether a mesh at a pose intersects one of the objects.

        With return_names also the set of the objects that it intersects, with return_data also a list
        of ContactData.
        """
        other = {_EXTERNAL: (as_mesh(mesh), _pose(transform))}
        pairs = [(name, _EXTERNAL) for name in self._meshes]
        return self._collisions(pairs, other, return_names, return_data, single=True)

    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """Whether two of the objects intersect; the names are pairs."""
        return self._collisions(self._own_pairs(), {}, return_names, return_data)

    def in_collision_other(self, other: "CollisionManager", return_names: bool = False,
                           return_data: bool = False) -> Any:
        """Whether an object of this world intersects one of another; the names are pairs."""
        pairs, bodies = self._pairs_with(other)
        return self._collisions(pairs, bodies, return_names, return_data)

    # Distances

    def min_distance_single(self, mesh: Any, transform: Optional[Pose] = None,
                            return_name: bool = False, return_data: bool = False) -> Any:
        """The smallest distance of a mesh at a pose from the objects [m]; infinite without objects.

        With return_name also the name of the nearest one, with return_data also a DistanceData.
        """
        other = {_EXTERNAL: (as_mesh(mesh), _pose(transform))}
        pairs = [(name, _EXTERNAL) for name in self._meshes]
        return self._least(pairs, other, return_name, return_data, single=True)

    def min_distance_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """The smallest distance of two objects [m]; infinite if there are fewer."""
        return self._least(self._own_pairs(), {}, return_names, return_data)

    def min_distance_other(self, other: "CollisionManager", return_names: bool = False,
                           return_data: bool = False) -> Any:
        """The smallest distance of an object of this world from one of another [m]."""
        pairs, bodies = self._pairs_with(other)
        return self._least(pairs, bodies, return_names, return_data)

    # Motions

    def first_contact(self, motions: Mapping[str, Union[_core.Motion, Pose]], *,
                      tolerance: float = _core.DEFAULT_TOLERANCE,
                      minimum_separation: float = 0.0
                      ) -> Tuple[_core.FirstContact, Optional[Tuple[str, str]]]:
        """When one of the objects that move first meets another object of the world, and their names.

        A motion is a Motion, or the pose at the end of the step: then the object moves there from where
        it is, by bullet_ccd.Motion.between(). Objects without a motion rest. No contact happens
        before the time of the result. Nothing is moved; call set_transform() for that.
        """
        names = list(self._meshes)
        bodies: List[Tuple[_core.Mesh, Any]] = []
        for name in motions:
            self._known(name)
        for name in names:
            motion: Any = motions.get(name)
            if motion is None:
                motion = self._poses[name]
            elif not isinstance(motion, _core.Motion):
                motion = _core.Motion.between(self._poses[name], motion)
            bodies.append((self._meshes[name], motion))
        pairs = [(i, j) for i in range(len(names)) for j in range(i + 1, len(names))
                 if names[i] in motions or names[j] in motions]
        found = _core.first_contact(bodies, pairs, tolerance=tolerance,
                                    minimum_separation=minimum_separation)
        touching = (names[found.body_a], names[found.body_b]) if found.body_a >= 0 else None
        return found, touching

    # What is behind them

    def _own_pairs(self) -> List[Tuple[str, str]]:
        names = list(self._meshes)
        return [(a, b) for i, a in enumerate(names) for b in names[i + 1:]]

    def _pairs_with(self, other: "CollisionManager"
                    ) -> Tuple[List[Tuple[str, str]], Dict[str, Tuple[_core.Mesh, Pose]]]:
        # Both worlds may have an object of the same name, so the others' get a prefix inside.
        bodies = {"\0" + name: (other._meshes[name], other._poses[name]) for name in other._meshes}
        return [(a, b) for a in self._meshes for b in bodies], bodies

    def _body(self, name: str, others: Mapping[str, Tuple[_core.Mesh, Pose]]
              ) -> Tuple[_core.Mesh, Pose]:
        return others[name] if name in others else (self._meshes[name], self._poses[name])

    def _nearest(self, a: str, b: str, others: Mapping[str, Tuple[_core.Mesh, Pose]],
                 bound: float) -> _core.Distance:
        (mesh_a, pose_a), (mesh_b, pose_b) = self._body(a, others), self._body(b, others)
        return _core.distance(mesh_a, mesh_b, pose_a, pose_b, upper_bound=bound)

    def _collisions(self, pairs: Iterable[Tuple[str, str]],
                    others: Mapping[str, Tuple[_core.Mesh, Pose]], return_names: bool,
                    return_data: bool, single: bool = False) -> Any:
        names: Set[Any] = set()
        data: List[ContactData] = []
        collides = False
        for a, b in pairs:
            # Closer than this counts as intersecting: it is what rounding leaves of a distance 0.
            near = self._nearest(a, b, others, 1e-12)
            if near.triangle_a < 0:
                continue
            collides = True
            if not (return_names or return_data):
                break
            names.add(_outer(a) if single else (_outer(a), _outer(b)))
            if return_data:
                data.append(self._contact(a, b, others, near))
        return _answer(collides, names if return_names else None, data if return_data else None)

    def _contact(self, a: str, b: str, others: Mapping[str, Tuple[_core.Mesh, Pose]],
                 near: _core.Distance) -> ContactData:
        first, second = sorted((a, b), key=_outer)
        (mesh_a, pose_a), (mesh_b, pose_b) = self._body(first, others), self._body(second, others)
        found = _core.contacts(mesh_a, mesh_b, pose_a, pose_b, threshold=1e-12)
        normal = found[0].normal if found else np.zeros(3)
        return ContactData(names=frozenset((_outer(a), _outer(b))),
                           point=0.5 * (near.point_a + near.point_b), normal=normal, depth=0.0)

    def _least(self, pairs: Iterable[Tuple[str, str]],
               others: Mapping[str, Tuple[_core.Mesh, Pose]], return_names: bool,
               return_data: bool, single: bool = False) -> Any:
        least = np.inf
        best: Optional[DistanceData] = None
        names: Any = None
        for a, b in pairs:
            near = self._nearest(a, b, others, least)
            if near.triangle_a < 0:
                continue
            least = near.distance
            names = _outer(a) if single else (_outer(a), _outer(b))
            best = DistanceData(names=frozenset((_outer(a), _outer(b))), distance=least,
                                points={_outer(a): near.point_a, _outer(b): near.point_b})
        answer: List[Any] = [float(least)]
        if return_names:
            answer.append(names)
        if return_data:
            answer.append(best)
        return tuple(answer) if len(answer) > 1 else answer[0]


def _pose(transform: Optional[Pose], name: str = "transform") -> Pose:
    pose: Pose = np.eye(4) if transform is None else np.array(transform, dtype=np.float64)
    if pose.shape != (4, 4) or not (np.isfinite(pose).all() and (pose[3] == (0, 0, 0, 1)).all()):
        raise ValueError(f"{name}: expected a 4 x 4 pose of finite numbers whose last row is 0, 0, 0, 1, "
                         f"but got {pose.tolist()}")
    return pose


def _outer(name: str) -> str:
    return name[1:] if name.startswith("\0") else name


def _answer(collides: bool, names: Any, data: Any) -> Any:
    answer = [collides] + [part for part in (names, data) if part is not None]
    return tuple(answer) if len(answer) > 1 else answer[0]
