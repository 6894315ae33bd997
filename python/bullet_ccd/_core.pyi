"""What the compiled half of bullet_ccd takes and returns.

Lengths are in metres, angles in radians. Arrays are NumPy's; whatever np.asarray() makes an array of
real numbers is taken. Pose stands for a 4 x 4 homogeneous matrix; None is the identity.
"""
import os
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
DEFAULT_TOLERANCE: float

Pose = Optional[ArrayLike]
Path = Union[str, "os.PathLike[str]"]
_Array = NDArray[np.float64]

class _Enumeration:
    __members__: Mapping[str, Any]
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...
    def __int__(self) -> int: ...

class Status(_Enumeration):
    """What a query promises; d(t) is the distance, s the minimum separation, e the tolerance."""

    SEPARATED: "Status"  #: d > s all the time
    HIT: "Status"  #: d > s up to time, d <= s + e there
    OVERLAPPING: "Status"  #: d <= s at the start
    TOUCHING_LEAVING: "Status"  #: within the tolerance at the start, and never nearer
    TOUCHING_PRESSING: "Status"  #: within the tolerance at the start, and coming nearer: like HIT
    ITERATION_LIMIT: "Status"  #: gave up; d > s up to time
    STOPPED: "Status"  #: the time limit passed; d > s up to time

class Strategy(_Enumeration):
    """How a query searches space and time. All strategies give the same guarantees."""

    BEST_FIRST: "Strategy"
    INTERVAL: "Strategy"
    C2A: "Strategy"

class Mesh:
    """A mesh with its hierarchy of bounding volumes, which all queries share. It never changes."""

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike, *, name: str = "mesh") -> None:
        """Builds the hierarchy.

        vertices: n x 3 [m]; triangles: m x 3 indices. name stands in messages. Raises ValueError for
        coordinates that are not finite, indices out of range, or a mesh without triangles.
        """
    @staticmethod
    def load(path: Path, *, scale: float = 1.0) -> "Mesh":
        """Reads OBJ, OFF, STL, PLY, DAE, glTF or GLB; scale turns its units into metres."""
    @property
    def vertices(self) -> _Array:
        """n x 3 [m], a read-only view."""
    @property
    def triangles(self) -> NDArray[np.int32]:
        """m x 3, a read-only view."""
    @property
    def bounds(self) -> Tuple[_Array, _Array]:
        """Smallest and largest coordinates [m]."""
    @property
    def is_watertight(self) -> bool: ...
    def mass_properties(self) -> Dict[str, Any]:
        """volume [m^3], center [m] and inertia [m^5] of the solid at density 1."""
    def __copy__(self) -> "Mesh": ...
    def __deepcopy__(self, memo: Any) -> "Mesh": ...

class Motion:
    """A constant twist over the step: the reference point moves on a straight line, and the body turns
    about it at constant speed."""

    def __init__(self, pose: Pose = None, *, velocity: ArrayLike = ..., angular_velocity: ArrayLike = ...,
                 reference: ArrayLike = ...) -> None:
        """pose at time 0, velocity of the reference point [m per step], angular_velocity [rad per step],
        both in the world; reference in the frame of the body [m], by default its origin."""
    @staticmethod
    def between(start: Pose, end: Pose) -> "Motion":
        """The origin moves on a straight line, and the body turns by the shortest arc."""
    @staticmethod
    def screw(start: Pose, end: Pose) -> "Motion":
        """The screw motion, which does not depend on where the body's origin is."""
    def at(self, time: float) -> _Array:
        """The pose at that time."""
    @property
    def pose(self) -> _Array: ...
    @property
    def velocity(self) -> _Array: ...
    @property
    def angular_velocity(self) -> _Array: ...
    @property
    def reference(self) -> _Array: ...

class Motions:
    """Many motions, for toi_batch(). In all of its makers, a single entry counts for all."""

    def __init__(self, motions: Sequence[Motion]) -> None: ...
    @staticmethod
    def between(start: Pose, end: Pose) -> "Motions":
        """Motion.between() of n x 4 x 4 poses."""
    @staticmethod
    def screw(start: Pose, end: Pose) -> "Motions":
        """Motion.screw() of n x 4 x 4 poses."""
    @staticmethod
    def twists(pose: Pose, *, velocity: ArrayLike = ..., angular_velocity: ArrayLike = ...) -> "Motions":
        """Motion() of n x 4 x 4 poses and n x 3 velocities."""
    def __len__(self) -> int: ...
    def __getitem__(self, index: int) -> Motion: ...

class ToiResult:
    @property
    def status(self) -> Status: ...
    @property
    def is_contact(self) -> bool:
        """True if the bodies must not move on."""
    @property
    def time(self) -> float:
        """In [0, 1]; certified: no contact before it."""
    @property
    def gap(self) -> float:
        """Distance at that time; for SEPARATED a lower bound over the whole motion [m]."""
    @property
    def triangle_a(self) -> int:
        """-1 without a contact."""
    @property
    def triangle_b(self) -> int: ...
    @property
    def point_a(self) -> _Array:
        """In the world at that time [m]."""
    @property
    def point_b(self) -> _Array: ...
    @property
    def normal(self) -> _Array:
        """Unit, from A to B, in the world."""
    @property
    def node_pairs(self) -> int: ...
    @property
    def triangle_pairs(self) -> int: ...

class FirstContact(ToiResult):
    @property
    def body_a(self) -> int:
        """Index of a body that touches first; -1 without a contact."""
    @property
    def body_b(self) -> int: ...

class Distance:
    @property
    def distance(self) -> float:
        """[m]; 0 where the surfaces intersect, upper_bound if it is not below that."""
    @property
    def triangle_a(self) -> int:
        """-1 if the distance is not below upper_bound."""
    @property
    def triangle_b(self) -> int: ...
    @property
    def point_a(self) -> _Array:
        """In the world [m]."""
    @property
    def point_b(self) -> _Array: ...

class LeastDistance:
    @property
    def status(self) -> Status:
        """SEPARATED; OVERLAPPING if the surfaces intersect; ITERATION_LIMIT or STOPPED if the query
        gave up."""
    @property
    def distance(self) -> float:
        """Certified: never closer; at most the tolerance below the truth [m]."""
    @property
    def found(self) -> float:
        """The distance at that time, or enough [m]."""
    @property
    def time(self) -> float: ...
    @property
    def triangle_a(self) -> int: ...
    @property
    def triangle_b(self) -> int: ...
    @property
    def point_a(self) -> _Array:
        """In the world at that time [m]."""
    @property
    def point_b(self) -> _Array: ...
    @property
    def normal(self) -> _Array:
        """Unit, from A to B: the direction in which the distance grows."""

class Contact:
    @property
    def gap(self) -> float: ...
    @property
    def triangle_a(self) -> int: ...
    @property
    def triangle_b(self) -> int: ...
    @property
    def point_a(self) -> _Array: ...
    @property
    def point_b(self) -> _Array: ...
    @property
    def normal(self) -> _Array: ...

def toi(mesh_a: Mesh, mesh_b: Mesh, motion_a: Union[Motion, Pose] = None,
        motion_b: Union[Motion, Pose] = None, *, tolerance: float = ...,
        minimum_separation: float = 0.0, strategy: Strategy = ..., max_iterations: int = ...,
        time_limit: float = ...) -> ToiResult:
    """When two moving meshes come within the tolerance [m] for the first time.

    A motion is a Motion, or a pose for a body at rest. Raises ValueError for poses that are no rotation
    and translation, for what is not finite, and for a tolerance that is not positive. After time_limit
    [s] the query ends with Status.STOPPED and the time up to which the meshes are certified.
    """

def toi_batch(mesh_a: Mesh, mesh_b: Mesh, motions_a: Union[Motions, Motion, Pose] = None,
              motions_b: Union[Motions, Motion, Pose] = None, *, tolerance: float = ...,
              minimum_separation: float = 0.0, strategy: Strategy = ...,
              max_iterations: int = ..., time_limit: float = ...) -> Dict[str, NDArray[Any]]:
    """toi() for n motions at once, on all cores. The answers are those of toi(), bit for bit. The time
    limit [s] is that of the whole batch: what is not answered by then is Status.STOPPED.

    Returns arrays with n rows by name: status (numbers of Status), is_contact, time, gap, triangle_a,
    triangle_b, point_a, point_b, normal.
    """

def distance(mesh_a: Mesh, mesh_b: Mesh, pose_a: Pose = None, pose_b: Pose = None, *,
             upper_bound: float = ...) -> Distance:
    """The distance of two surfaces at fixed poses and a pair of closest points."""

def least_distance(mesh_a: Mesh, mesh_b: Mesh, motion_a: Union[Motion, Pose] = None,
                   motion_b: Union[Motion, Pose] = None, *, tolerance: float = ...,
                   enough: float = ..., time_limit: float = ...) -> LeastDistance:
    """The smallest distance of two meshes over the whole motion; larger ones than enough [m] are not
    looked for."""

def contacts(mesh_a: Mesh, mesh_b: Mesh, pose_a: Pose = None, pose_b: Pose = None, *,
             threshold: float) -> List[Contact]:
    """The contact points of two surfaces that are within the threshold [m], nearest first."""

def first_contact(bodies: Sequence[Tuple[Mesh, Union[Motion, Pose]]],
                  pairs: Optional[Sequence[Tuple[int, int]]] = None, *, tolerance: float = ...,
                  minimum_separation: float = 0.0, max_iterations: int = ...,
                  time_limit: float = ...) -> FirstContact:
    """The first contact among many moving bodies; pairs are indices, by default all pairs."""

class LinkContact:
    @property
    def link(self) -> str: ...
    @property
    def other_link(self) -> Optional[str]:
        """None for a contact with an obstacle."""
    @property
    def obstacle(self) -> Optional[int]:
        """Index of the obstacle; None for a contact with another link."""
    @property
    def gap(self) -> float: ...
    @property
    def point_link(self) -> _Array: ...
    @property
    def point_other(self) -> _Array: ...
    @property
    def normal(self) -> _Array:
        """Unit, from the link to the other."""
    @property
    def triangle_link(self) -> int: ...
    @property
    def triangle_other(self) -> int: ...

class ArticulatedToiResult:
    @property
    def status(self) -> Status: ...
    @property
    def is_contact(self) -> bool: ...
    @property
    def time(self) -> float: ...
    @property
    def contacts(self) -> List[LinkContact]:
        """All pairs within the tolerance at that time, the first contact first."""

Positions = Union[None, Mapping[str, float], ArrayLike]

class Robot:
    """A robot from a URDF, with the hierarchies of its links."""

    @staticmethod
    def load(path: Path) -> "Robot": ...
    @property
    def name(self) -> str: ...
    @property
    def notes(self) -> List[str]:
        """What was assumed or repaired."""
    @property
    def link_names(self) -> List[str]: ...
    @property
    def joint_names(self) -> List[str]:
        """Joints that move by themselves; the order of arrays of positions."""
    @property
    def joint_limits(self) -> List[Tuple[float, float]]: ...
    def link_poses(self, positions: Positions = None, *, root: Pose = None) -> Dict[str, _Array]:
        """Poses of all links in the world, by name."""
    def self_pairs(self) -> List[Tuple[str, str]]:
        """All pairs of links with geometry that no joint joins directly."""

def articulated_toi(robot: Robot, start: Positions, end: Positions,
                    obstacles: Sequence[Tuple[Mesh, Union[Motion, Pose]]], *, root_start: Pose = None,
                    root_end: Pose = None, self_pairs: Sequence[Tuple[str, str]] = ...,
                    tolerance: float = ..., minimum_separation: float = 0.0,
                    max_iterations: int = ..., time_limit: float = ...) -> ArticulatedToiResult:
    """When a link of a moving robot first meets an obstacle or a link that it is paired with.

    Positions are a dictionary by joint, an array in the order of Robot.joint_names, or None; joints that
    are not named are at 0, clamped into their limits. They change linearly over the step. The root moves
    from root_start to root_end (by default it rests).
    """

class Hand:
    """A hand from a URDF, and an SRDF that names its fingers; what is missing is inferred."""

    @staticmethod
    def load(urdf: Path, *, srdf: Optional[Path] = None) -> "Hand": ...
    @property
    def name(self) -> str: ...
    @property
    def notes(self) -> List[str]: ...
    @property
    def finger_names(self) -> List[str]: ...
    @property
    def preshapes(self) -> Dict[str, Dict[str, float]]:
        """Positions of the movable joints by name, by preshape."""
    @property
    def grasp_frame(self) -> _Array:
        """In the root link: where the fingers meet, +z along the approach."""

class GraspObject:
    """An object to grasp."""

    def __init__(self, mesh: Mesh, *, name: str = "object") -> None: ...
    @staticmethod
    def load(path: Path, *, scale: float = 1.0) -> "GraspObject": ...
    @property
    def name(self) -> str: ...
    @property
    def center_of_mass(self) -> _Array: ...
    @property
    def is_watertight(self) -> bool: ...

def plan(hand: Hand, object: GraspObject, *, candidates: int = ..., seed: int = ..., jobs: int = ...,
         time_limit: float = ..., volumes: int = ..., tolerance: float = ..., friction: float = ...,
         cone_edges: int = ..., force_closure_threshold: float = ...,
         progress: Optional[Callable[[int], None]] = None) -> Tuple[str, bool]:
    """Use bullet_ccd.grasp.plan()."""

def close_at(hand: Hand, object: GraspObject, pose: Pose, shift: ArrayLike = ..., *,
             preshape: Optional[str] = None, tolerance: float = ..., friction: float = ...,
             cone_edges: int = ..., force_closure_threshold: float = ...) -> str:
    """Use bullet_ccd.grasp.close()."""
