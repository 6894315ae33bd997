"""The names of python-fcl, for programs that were written for it: `import bullet_ccd.fcl as fcl`.

What is there are meshes (BVHModel), the bounded shapes, objects, the broad-phase manager with its callbacks, and
collide(), distance() and continuousCollide(). Round shapes have facets that are outside of them by at most a
thousandth of their size; bullet_ccd.convex_toi() has them exactly. Where python-fcl samples or gives up, the answers are those of bullet_ccd: an
object in motion stops before the first contact, certified, however many iterations are allowed. Meshes are
surfaces, shapes as well, so what floats inside another does not collide with it, and penetration depths are 0:
requests for depths and costs raise NotImplementedError. The choice of a solver makes no difference.
"""
from dataclasses import dataclass, field
from typing import Any, List, Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .collision_manager import _TOUCHING, _Body, _body, _pairs

__all__ = ["BVHModel", "Box", "CCDMotionType", "CCDSolverType", "Capsule", "CollisionData",
           "CollisionObject", "CollisionRequest", "CollisionResult", "Cone", "Contact",
           "ContinuousCollisionRequest", "ContinuousCollisionResult", "Cylinder", "DistanceData",
           "DistanceRequest", "DistanceResult", "DynamicAABBTreeCollisionManager", "Ellipsoid",
           "GJKSolverType", "Sphere", "Transform", "collide", "continuousCollide",
           "defaultCollisionCallback", "defaultDistanceCallback", "distance"]

_Array = NDArray[np.float64]


class Transform:
    """A rotation (3 x 3, or a quaternion w, x, y, z) and a translation [m]; another Transform is copied."""

    def __init__(self, *parts: Any) -> None:
        self._pose: _Array = np.eye(4)
        for part in parts:
            if isinstance(part, Transform):
                self._pose = part._pose.copy()
                continue
            array = np.asarray(part, dtype=np.float64)
            if array.shape == (3, 3):
                self.setRotation(array)
            elif array.shape == (4,):
                self.setQuatRotation(array)
            elif array.shape == (3,):
                self.setTranslation(array)
            else:
                raise ValueError(f"Transform: expected a rotation and a translation, but got an array of "
                                 f"shape {array.shape}")

    def getRotation(self) -> _Array:
        return self._pose[:3, :3].copy()

    def getTranslation(self) -> _Array:
        return self._pose[:3, 3].copy()

    def setRotation(self, rotation: ArrayLike) -> None:
        self._pose[:3, :3] = rotation

    def setTranslation(self, translation: ArrayLike) -> None:
        self._pose[:3, 3] = translation

    def setQuatRotation(self, quaternion: ArrayLike) -> None:
        w, x, y, z = np.asarray(quaternion, dtype=np.float64) / np.linalg.norm(quaternion)
        self._pose[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                              [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                              [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


class BVHModel:
    """A mesh. Between beginModel() and endModel() vertices and triangles are added."""

    def __init__(self) -> None:
        self._vertices: List[_Array] = []
        self._triangles: List[NDArray[np.int64]] = []
        self._mesh: Optional[_core.Mesh] = None

    @property
    def mesh(self) -> _core.Mesh:
        """With its hierarchy, which is built at the first use."""
        if self._mesh is None:
            if not self._triangles:
                raise ValueError("BVHModel: it has no triangles; call addSubModel()")
            self._mesh = _core.Mesh(np.concatenate(self._vertices), np.concatenate(self._triangles),
                                    name="BVHModel")
        return self._mesh

    def beginModel(self, num_tris_: int = 0, num_vertices_: int = 0) -> None:
        self.__init__()  # type: ignore[misc]

    def addSubModel(self, verts: ArrayLike, triangles: ArrayLike) -> None:
        before = sum(len(vertices) for vertices in self._vertices)
        self._vertices.append(np.array(verts, dtype=np.float64).reshape(-1, 3))
        self._triangles.append(np.array(triangles, dtype=np.int64).reshape(-1, 3) + before)
        self._mesh = None

    def endModel(self) -> None:
        self.mesh  # errors come here


class Box(BVHModel):
    """Of three side lengths, centred at its origin."""

    def __init__(self, x: float, y: float, z: float) -> None:
        super().__init__()
        corners = np.array([[i, j, k] for i in (-.5, .5) for j in (-.5, .5) for k in (-.5, .5)])
        self.addSubModel(corners * [x, y, z],
                         [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                          [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])


_AROUND = 96  # facets of a full turn


class _Round(BVHModel):
    """A profile of points (radius, z) turned about z, from the top, where the radius is 0, to the bottom."""

    def __init__(self, profile: ArrayLike, scale: ArrayLike = (1.0, 1.0, 1.0)) -> None:
        super().__init__()
        radius, z = np.asarray(profile, dtype=np.float64).T
        if not (np.isfinite(radius).all() and np.isfinite(z).all() and radius.max() > 0 and z[0] > z[-1]
                and np.isfinite(scale).all() and np.min(scale) > 0):
            raise ValueError(f"{type(self).__name__}: sizes must be positive numbers [m]")
        turn = np.arange(_AROUND) * 2 * np.pi / _AROUND
        outside = radius[1:-1, None] / np.cos(np.pi / _AROUND)  # where facets are nearest to the axis
        rings = np.stack([outside * np.cos(turn), outside * np.sin(turn),
                          np.broadcast_to(z[1:-1, None], (len(z) - 2, _AROUND))], axis=2)
        vertices = np.vstack([[0, 0, z[0]], rings.reshape(-1, 3), [0, 0, z[-1]]])
        i = np.arange(_AROUND)
        k = (i + 1) % _AROUND
        last = len(vertices) - 1
        triangles = [np.stack([0 * i, 1 + i, 1 + k], axis=1)]
        for ring in range(1, last - _AROUND, _AROUND):
            a, b = ring + i, ring + k
            triangles += [np.stack([a, a + _AROUND, b + _AROUND], axis=1), np.stack([a, b + _AROUND, b], axis=1)]
        triangles.append(np.stack([last + 0 * i, last - _AROUND + k, last - _AROUND + i], axis=1))
        self.addSubModel(vertices * np.asarray(scale, dtype=np.float64), np.concatenate(triangles))


def _round_ends(radius: float, lz: float) -> _Array:
    """Profile of a capsule whose ends have their centres `lz` apart; of a sphere if that is 0. Its corners are on
    tangents of the circles, so that its edges are outside of them."""
    count = _AROUND // 4
    turn = 0.5 * np.pi * (np.arange(count) + 0.5) / count
    outside = radius / np.cos(0.25 * np.pi / count)
    top = np.stack([outside * np.sin(turn), outside * np.cos(turn)], axis=1)
    top = np.vstack([[0, top[0, 1]], top]) + [0, 0.5 * lz]
    return np.vstack([top, top[::-1] * [1, -1]])


class Sphere(_Round):
    """Of a radius, centred at its origin."""

    def __init__(self, radius: float) -> None:
        self.radius = radius
        super().__init__(_round_ends(radius, 0.0))


class Ellipsoid(_Round):
    """Of the half lengths of its three axes."""

    def __init__(self, a: float, b: float, c: float) -> None:
        self.a, self.b, self.c = a, b, c
        super().__init__(_round_ends(1.0, 0.0), (a, b, c))


class Capsule(_Round):
    """Of a radius and the distance of the centres of its ends, along z."""

    def __init__(self, radius: float, lz: float) -> None:
        self.radius, self.lz = radius, lz
        super().__init__(_round_ends(radius, lz))


class Cylinder(_Round):
    """Of a radius and a length along z, centred at its origin."""

    def __init__(self, radius: float, lz: float) -> None:
        self.radius, self.lz = radius, lz
        z = 0.5 * lz
        super().__init__([[0, z], [radius, z], [radius, -z], [0, -z]])


class Cone(_Round):
    """Of the radius of its base and a length along z, its tip up, the origin half way."""

    def __init__(self, radius: float, lz: float) -> None:
        self.radius, self.lz = radius, lz
        super().__init__([[0, 0.5 * lz], [radius, -0.5 * lz], [0, -0.5 * lz]])


class GJKSolverType:
    """Makes no difference."""
    GST_LIBCCD, GST_INDEP = range(2)


class CCDMotionType:
    """Makes no difference: motions are steady translation and rotation."""
    CCDM_TRANS, CCDM_LINEAR, CCDM_SCREW, CCDM_SPLINE = range(4)


class CCDSolverType:
    """Makes no difference."""
    CCDC_NAIVE, CCDC_CONSERVATIVE_ADVANCEMENT, CCDC_RAY_SHOOTING, CCDC_POLYNOMIAL_SOLVER = range(4)


def _refuse(is_asked: bool, what: str) -> None:
    if is_asked:
        raise NotImplementedError(f"{what}: not known to meshes, which are surfaces; leave it out")


class CollisionObject:
    """A geometry at a pose."""

    def __init__(self, geom: BVHModel, tf: Optional[Transform] = None) -> None:
        if not isinstance(geom, BVHModel):
            raise TypeError(f"CollisionObject: expected a BVHModel or a shape, but got {type(geom).__name__}")
        self.geom = geom
        self._transform = Transform() if tf is None else Transform(tf)

    def getTransform(self) -> Transform:
        return Transform(self._transform)

    def setTransform(self, tf: Transform) -> None:
        self._transform = Transform(tf)

    def getRotation(self) -> _Array:
        return self._transform.getRotation()

    def getTranslation(self) -> _Array:
        return self._transform.getTranslation()

    def setRotation(self, rotation: ArrayLike) -> None:
        self._transform.setRotation(rotation)

    def setTranslation(self, translation: ArrayLike) -> None:
        self._transform.setTranslation(translation)

    def setQuatRotation(self, quaternion: ArrayLike) -> None:
        self._transform.setQuatRotation(quaternion)

    def _as_body(self, name: str) -> _Body:
        return _body(name, self.geom.mesh, self._transform._pose)


@dataclass
class CollisionRequest:
    num_max_contacts: int = 1
    enable_contact: bool = False
    num_max_cost_sources: int = 1
    enable_cost: bool = False
    use_approximate_cost: bool = True
    gjk_solver_type: int = GJKSolverType.GST_LIBCCD

    def __post_init__(self) -> None:
        _refuse(self.enable_cost, "enable_cost")


@dataclass
class Contact:
    """Of the geometries o1 and o2 in their triangles b1 and b2."""
    o1: BVHModel
    o2: BVHModel
    b1: int
    b2: int
    normal: _Array  #: unit, from o1 to o2
    pos: _Array  #: [m]
    penetration_depth: float = 0.0


@dataclass
class CollisionResult:
    is_collision: bool = False
    contacts: List[Contact] = field(default_factory=list)


@dataclass
class DistanceRequest:
    enable_nearest_points: bool = False
    gjk_solver_type: int = GJKSolverType.GST_LIBCCD
    enable_signed_distance: bool = False

    def __post_init__(self) -> None:
        _refuse(self.enable_signed_distance, "enable_signed_distance")


@dataclass
class DistanceResult:
    min_distance: float = np.inf
    nearest_points: List[_Array] = field(default_factory=list)
    o1: Optional[BVHModel] = None
    o2: Optional[BVHModel] = None
    b1: int = -1
    b2: int = -1


@dataclass
class ContinuousCollisionRequest:
    """toc_err is the distance at which meshes count as touching [m]."""
    num_max_iterations: int = 10
    toc_err: float = 1e-4
    ccd_motion_type: int = CCDMotionType.CCDM_TRANS
    gjk_solver_type: int = GJKSolverType.GST_LIBCCD
    ccd_solver_type: int = CCDSolverType.CCDC_NAIVE


@dataclass
class ContinuousCollisionResult:
    is_collide: bool = False
    time_of_contact: float = 1.0


@dataclass
class CollisionData:
    request: CollisionRequest = field(default_factory=CollisionRequest)
    result: CollisionResult = field(default_factory=CollisionResult)
    done: bool = False


@dataclass
class DistanceData:
    request: DistanceRequest = field(default_factory=DistanceRequest)
    result: DistanceResult = field(default_factory=DistanceResult)
    done: bool = False


def collide(o1: CollisionObject, o2: CollisionObject, request: Optional[CollisionRequest] = None,
            result: Optional[CollisionResult] = None) -> int:
    """The number of contacts; 0 if the surfaces do not intersect."""
    request, result = request or CollisionRequest(), result or CollisionResult()
    a, b = o1._as_body("a"), o2._as_body("b")
    near = _core.distance(a.mesh, b.mesh, a.pose, b.pose, upper_bound=_TOUCHING)
    if near.triangle_a < 0:
        return 0
    result.is_collision = True
    if not request.enable_contact:
        return 1
    found = _core.contacts(a.mesh, b.mesh, a.pose, b.pose, threshold=_TOUCHING)
    contacts = [Contact(o1.geom, o2.geom, c.triangle_a, c.triangle_b, c.normal, 0.5 * (c.point_a + c.point_b))
                for c in found]
    free = max(0, request.num_max_contacts - len(result.contacts))
    result.contacts.extend(contacts[:free])
    return min(len(contacts), free)


def distance(o1: CollisionObject, o2: CollisionObject, request: Optional[DistanceRequest] = None,
             result: Optional[DistanceResult] = None) -> float:
    """[m]; a result keeps the smallest that was put into it. -1 where surfaces intersect."""
    result = result if result is not None else DistanceResult()
    a, b = o1._as_body("a"), o2._as_body("b")
    near = _core.distance(a.mesh, b.mesh, a.pose, b.pose)
    least = near.distance if near.distance > _TOUCHING else -1.0
    if least < result.min_distance:
        result.min_distance, result.o1, result.o2 = least, o1.geom, o2.geom
        result.b1, result.b2 = near.triangle_a, near.triangle_b
        result.nearest_points = [near.point_a, near.point_b]
    return least


def continuousCollide(o1: CollisionObject, tf1_end: Transform, o2: CollisionObject, tf2_end: Transform,
                      request: Optional[ContinuousCollisionRequest] = None,
                      result: Optional[ContinuousCollisionResult] = None) -> float:
    """The time of the first contact in [0, 1], certified, on the way from the objects' poses to the ends; 1
    without one."""
    request, result = request or ContinuousCollisionRequest(), result or ContinuousCollisionResult()
    hit = _core.toi(o1.geom.mesh, o2.geom.mesh,
                    _core.Motion.between(o1._transform._pose, tf1_end._pose),
                    _core.Motion.between(o2._transform._pose, tf2_end._pose), tolerance=request.toc_err)
    result.is_collide = hit.is_contact or hit.status == _core.Status.OVERLAPPING
    result.time_of_contact = hit.time if result.is_collide else 1.0
    return result.time_of_contact


def defaultCollisionCallback(o1: CollisionObject, o2: CollisionObject, cdata: CollisionData) -> bool:
    """Collects contacts up to the number that the request allows."""
    if not cdata.done:
        collide(o1, o2, cdata.request, cdata.result)
        cdata.done = cdata.result.is_collision and (
            not cdata.request.enable_contact
            or len(cdata.result.contacts) >= cdata.request.num_max_contacts)
    return cdata.done


def defaultDistanceCallback(o1: CollisionObject, o2: CollisionObject,
                            cdata: DistanceData) -> Tuple[bool, float]:
    """Keeps the smallest distance."""
    if not cdata.done:
        distance(o1, o2, cdata.request, cdata.result)
        cdata.done = cdata.result.min_distance <= 0.0
    return cdata.done, cdata.result.min_distance


class DynamicAABBTreeCollisionManager:
    """Objects that are tested against each other, against one more, or against those of another manager."""

    def __init__(self) -> None:
        self._objects: List[CollisionObject] = []

    def registerObject(self, obj: CollisionObject) -> None:
        self._objects.append(obj)

    def registerObjects(self, objs: List[CollisionObject]) -> None:
        self._objects.extend(objs)

    def unregisterObject(self, obj: CollisionObject) -> None:
        """Nothing happens if it is not registered."""
        self._objects = [known for known in self._objects if known is not obj]

    def setup(self) -> None:
        """Nothing is to be set up: poses are those of the objects when they are asked about."""

    def update(self, arg: Any = None) -> None:
        """As setup()."""

    def clear(self) -> None:
        self._objects = []

    def empty(self) -> bool:
        return not self._objects

    def size(self) -> int:
        return len(self._objects)

    def getObjects(self) -> List[CollisionObject]:
        return list(self._objects)

    def collide(self, *args: Any) -> None:
        """collide([object or manager,] data, callback): calls callback(o1, o2, data) for every pair whose
        boxes meet, until it returns True."""
        for bound, o1, o2, data, callback in self._candidates(args):
            if bound > _TOUCHING or callback(o1, o2, data):
                return

    def distance(self, *args: Any) -> None:
        """distance([object or manager,] data, callback): calls callback(o1, o2, data), which returns whether
        all is done and the smallest distance so far, for every pair that may be nearer, nearest boxes first."""
        least = np.inf
        for bound, o1, o2, data, callback in self._candidates(args):
            if bound >= least:
                return
            done, least = callback(o1, o2, data)
            if done:
                return

    def _candidates(self, args: Tuple[Any, ...]) -> Any:
        if len(args) not in (2, 3):
            raise TypeError("expected ([object or manager,] data, callback)")
        first = list(self._objects)
        second = None
        if len(args) == 3:
            second = [args[0]] if isinstance(args[0], CollisionObject) else args[0].getObjects()
        data, callback = args[-2:]
        bodies = [obj._as_body(str(i)) for i, obj in enumerate(first)]
        others = None if second is None else [obj._as_body(str(i)) for i, obj in enumerate(second)]
        for bound, a, b in _pairs(bodies, others):
            yield bound, first[int(a.name)], (second or first)[int(b.name)], data, callback
