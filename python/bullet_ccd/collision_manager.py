"""A world of named objects, with the method names of trimesh's CollisionManager."""
from dataclasses import dataclass
from typing import Any, Dict, FrozenSet, Iterable, Iterator, List, Mapping, Optional, Set, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arguments import as_mesh

Pose = NDArray[np.float64]
#: Closer than this counts as intersecting: it is what rounding leaves of a distance 0 [m].
_TOUCHING = 1e-12
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


@dataclass(frozen=True)
class _Body:
    """A mesh at a pose, with a box around it in the world."""
    name: str
    mesh: _core.Mesh
    pose: Pose
    low: NDArray[np.float64]
    high: NDArray[np.float64]


class CollisionManager:
    """Objects at poses. Distances and intersections are those of surfaces: a small object that floats
    inside a large one does not intersect it. first_contact() also says when moving objects meet.

    Hierarchies are built when an object is added; give a bullet_ccd.Mesh to share one among objects.
    """

    def __init__(self) -> None:
        self._bodies: Dict[str, _Body] = {}

    def __contains__(self, name: object) -> bool:
        return name in self._bodies

    def __len__(self) -> int:
        return len(self._bodies)

    @property
    def names(self) -> List[str]:
        """In the order in which they were added."""
        return list(self._bodies)

    def add_object(self, name: str, mesh: Any, transform: Optional[Pose] = None) -> None:
        """Adds an object, or replaces the one of that name."""
        self._bodies[name] = _body(name, as_mesh(mesh, name=name), _pose(transform, name))

    def remove_object(self, name: str) -> None:
        """Raises KeyError if there is none of that name."""
        self._known(name)
        del self._bodies[name]

    def set_transform(self, name: str, transform: Optional[Pose]) -> None:
        """Raises KeyError if there is none of that name, ValueError for what is no pose."""
        self._bodies[name] = _body(name, self._known(name).mesh, _pose(transform, name))

    def transform(self, name: str) -> Pose:
        """The pose of an object in the world (a copy)."""
        return self._known(name).pose.copy()

    def _known(self, name: str) -> _Body:
        if name not in self._bodies:
            raise KeyError(f"the world has no object named '{name}'")
        return self._bodies[name]

    def _all(self) -> List[_Body]:
        return list(self._bodies.values())

    # Intersections

    def in_collision_single(self, mesh: Any, transform: Optional[Pose] = None,
                            return_names: bool = False, return_data: bool = False) -> Any:
        """Whether a mesh at a pose intersects one of the objects.

        With return_names also the set of the objects that it intersects, with return_data also a list
        of ContactData.
        """
        other = _body(_EXTERNAL, as_mesh(mesh), _pose(transform))
        return _collisions(_pairs(self._all(), [other]), return_names, return_data, single=True)

    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """Whether two of the objects intersect; the names are pairs."""
        return _collisions(_pairs(self._all()), return_names, return_data)

    def in_collision_other(self, other: "CollisionManager", return_names: bool = False,
                           return_data: bool = False) -> Any:
        """Whether an object of this world intersects one of another; the names are pairs."""
        return _collisions(_pairs(self._all(), other._all()), return_names, return_data)

    # Distances

    def min_distance_single(self, mesh: Any, transform: Optional[Pose] = None,
                            return_name: bool = False, return_data: bool = False) -> Any:
        """The smallest distance of a mesh at a pose from the objects [m]; infinite without objects.

        With return_name also the name of the nearest one, with return_data also a DistanceData.
        """
        other = _body(_EXTERNAL, as_mesh(mesh), _pose(transform))
        return _least(_pairs(self._all(), [other]), return_name, return_data, single=True)

    def min_distance_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """The smallest distance of two objects [m]; infinite if there are fewer."""
        return _least(_pairs(self._all()), return_names, return_data)

    def min_distance_other(self, other: "CollisionManager", return_names: bool = False,
                           return_data: bool = False) -> Any:
        """The smallest distance of an object of this world from one of another [m]."""
        return _least(_pairs(self._all(), other._all()), return_names, return_data)

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
        bodies: List[Tuple[_core.Mesh, Any]] = []
        for name in motions:
            self._known(name)
        names = list(self._bodies)
        for name in names:
            body, motion = self._bodies[name], motions.get(name)
            if motion is None:
                bodies.append((body.mesh, body.pose))
            elif isinstance(motion, _core.Motion):
                bodies.append((body.mesh, motion))
            else:
                bodies.append((body.mesh, _core.Motion.between(body.pose, motion)))
        pairs = [(i, j) for i in range(len(names)) for j in range(i + 1, len(names))
                 if names[i] in motions or names[j] in motions]
        found = _core.first_contact(bodies, pairs, tolerance=tolerance,
                                    minimum_separation=minimum_separation)
        touching = (names[found.body_a], names[found.body_b]) if found.body_a >= 0 else None
        return found, touching


def _body(name: str, mesh: _core.Mesh, pose: Pose) -> _Body:
    low, high = mesh.bounds
    center = pose[:3, :3] @ (0.5 * (low + high)) + pose[:3, 3]
    half = np.abs(pose[:3, :3]) @ (0.5 * (high - low))
    half += 1e-9 * (half + np.abs(center))  # more than is rounded
    return _Body(name, mesh, pose, center - half, center + half)


def _pairs(first: List[_Body], second: Optional[List[_Body]] = None
           ) -> Iterator[Tuple[float, _Body, _Body]]:
    """All pairs, or those of two lists, with a lower bound of their distance; nearest boxes first."""
    others = first if second is None else second
    if not first or not others:
        return
    i, j = np.indices((len(first), len(others))).reshape(2, -1)
    if second is None:
        i, j = np.triu_indices(len(first), 1)
    low, high = np.array([body.low for body in first]), np.array([body.high for body in first])
    lows, highs = np.array([body.low for body in others]), np.array([body.high for body in others])
    gaps = np.maximum(low[i] - highs[j], lows[j] - high[i])
    bounds = np.linalg.norm(np.maximum(gaps, 0.0), axis=1)
    for k in np.argsort(bounds, kind="stable"):
        yield float(bounds[k]), first[i[k]], others[j[k]]


def _nearest(a: _Body, b: _Body, bound: float) -> _core.Distance:
    return _core.distance(a.mesh, b.mesh, a.pose, b.pose, upper_bound=bound)


def _collisions(pairs: Iterable[Tuple[float, _Body, _Body]], return_names: bool, return_data: bool,
                single: bool = False) -> Any:
    names: Set[Any] = set()
    data: List[ContactData] = []
    collides = False
    for bound, a, b in pairs:
        if bound > _TOUCHING:
            break
        near = _nearest(a, b, _TOUCHING)
        if near.triangle_a < 0:
            continue
        collides = True
        if not (return_names or return_data):
            break
        names.add(a.name if single else (a.name, b.name))
        if return_data:
            data.append(_contact(a, b, near))
    return _answer(collides, names if return_names else None, data if return_data else None)


def _contact(a: _Body, b: _Body, near: _core.Distance) -> ContactData:
    first, second = sorted((a, b), key=lambda body: body.name)
    found = _core.contacts(first.mesh, second.mesh, first.pose, second.pose, threshold=_TOUCHING)
    normal = found[0].normal if found else np.zeros(3)
    return ContactData(names=frozenset((a.name, b.name)),
                       point=0.5 * (near.point_a + near.point_b), normal=normal, depth=0.0)


def _least(pairs: Iterable[Tuple[float, _Body, _Body]], return_names: bool, return_data: bool,
           single: bool = False) -> Any:
    least = np.inf
    best: Optional[DistanceData] = None
    names: Any = None
    for bound, a, b in pairs:
        if bound >= least:
            break
        near = _nearest(a, b, least)
        if near.triangle_a < 0:
            continue
        least = near.distance
        names = a.name if single else (a.name, b.name)
        best = DistanceData(names=frozenset((a.name, b.name)), distance=least,
                            points={a.name: near.point_a, b.name: near.point_b})
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


def _answer(collides: bool, names: Any, data: Any) -> Any:
    answer = [collides] + [part for part in (names, data) if part is not None]
    return tuple(answer) if len(answer) > 1 else answer[0]
