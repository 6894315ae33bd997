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
        any_within: bool = False, time_limit: float = ...) -> ToiResult:
    """When two moving meshes come within the tolerance [m] for the first time.

    A motion is a Motion, or a pose for a body at rest. Raises ValueError for poses that are no rotation
    and translation, for what is not finite, and for a tolerance that is not positive. With any_within
    any gap within the tolerance ends the query, which costs less and answers earlier by what it takes to
    close that gap. After time_limit [s] the query ends with Status.STOPPED and the time up to which the
    meshes are certified.
    """

def toi_batch(mesh_a: Mesh, mesh_b: Mesh, motions_a: Union[Motions, Motion, Pose] = None,
              motions_b: Union[Motions, Motion, Pose] = None, *, tolerance: float = ...,
              minimum_separation: float = 0.0, strategy: Strategy = ...,
              max_iterations: int = ..., any_within: bool = False,
              time_limit: float = ...) -> Dict[str, NDArray[Any]]:
    """toi() for n motions at once, on all cores. The answers are those of toi(), bit for bit. The time
    limit [s] is that of the whole batch: what is not answered by then is Status.STOPPED.

    Returns arrays with n rows by name: status (numbers of Status), is_contact, time, gap, triangle_a,
    triangle_b, point_a, point_b, normal.
    """

def distance(mesh_a: Mesh, mesh_b: Mesh, pose_a: Pose = None, pose_b: Pose = None, *,
             upper_bound: float = ..., time_limit: float = ...) -> Distance:
    """The distance of two surfaces at fixed poses and a pair of closest points. Raises TimeoutError
    after the time limit [s]."""

def least_distance(mesh_a: Mesh, mesh_b: Mesh, motion_a: Union[Motion, Pose] = None,
                   motion_b: Union[Motion, Pose] = None, *, tolerance: float = ...,
                   enough: float = ..., time_limit: float = ...) -> LeastDistance:
    """The smallest distance of two meshes over the whole motion; larger ones than enough [m] are not
    looked for."""

def least_distance_batch(mesh_a: Mesh, mesh_b: Mesh, motions_a: Union[Motions, Motion, Pose] = None,
                         motions_b: Union[Motions, Motion, Pose] = None, *, tolerance: float = ...,
                         enough: float = ..., time_limit: float = ...) -> Dict[str, NDArray[Any]]:
    """least_distance() for n motions at once, on all cores. The answers are those of least_distance(),
    bit for bit. The time limit [s] is that of the whole batch: what is not answered by then is
    Status.STOPPED.

    Returns arrays with n rows by name: status (numbers of Status), distance, found, time, triangle_a,
    triangle_b, point_a, point_b, normal.
    """

def contacts(mesh_a: Mesh, mesh_b: Mesh, pose_a: Pose = None, pose_b: Pose = None, *,
             threshold: float, time_limit: float = ...) -> List[Contact]:
    """The contact points of two surfaces that are within the threshold [m], nearest first. Raises
    TimeoutError after the time limit [s]."""

def first_contact(bodies: Sequence[Tuple[Mesh, Union[Motion, Pose]]],
                  pairs: Optional[Sequence[Tuple[int, int]]] = None, *, tolerance: float = ...,
                  minimum_separation: float = 0.0, max_iterations: int = ...,
                  time_limit: float = ...) -> FirstContact:
    """The first contact among many moving bodies; pairs are indices, by default all pairs."""

class ConvexShape:
    """An exact convex solid without triangles, in its own frame; lengths are along z. It never changes.
    Sizes may be 0, and ValueError says which are negative or not finite."""

    @staticmethod
    def sphere(radius: float) -> "ConvexShape": ...
    @staticmethod
    def capsule(radius: float, half_length: float) -> "ConvexShape":
        """A cylinder of that half length with a half sphere on either end [m]."""
    @staticmethod
    def box(half_extents: ArrayLike) -> "ConvexShape": ...
    @staticmethod
    def cylinder(radius: float, half_length: float) -> "ConvexShape": ...
    @staticmethod
    def cone(radius: float, half_length: float) -> "ConvexShape":
        """The tip is at +half_length, the base at -half_length."""
    @staticmethod
    def hull(points: ArrayLike) -> "ConvexShape":
        """The convex hull of n x 3 points [m]; beyond a hundred of them a Mesh is faster."""
    @staticmethod
    def half_space(normal: ArrayLike, offset: float = 0.0) -> "ConvexShape":
        """All x with normal . x <= offset [m], like the ground below a plane; any length of normal."""
    def rounded(self, radius: float) -> "ConvexShape":
        """The shape swept by a ball: larger by its radius on all sides [m]."""
    @property
    def kind(self) -> str:
        """point, segment, box, cylinder, cone, hull or half_space: what a ball of the radius sweeps"""
    @property
    def radius(self) -> float:
        """Of that ball [m]: a sphere is a point, a capsule a segment."""

def convex_toi(shape_a: ConvexShape, shape_b: ConvexShape, motion_a: Union[Motion, Pose] = None,
               motion_b: Union[Motion, Pose] = None, *, tolerance: float = ...,
               minimum_separation: float = 0.0, max_iterations: int = ...,
               time_limit: float = ...) -> ToiResult:
    """toi() for exact convex solids: one inside the other is Status.OVERLAPPING. At most one of them is a
    half-space. The result names no triangles."""

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
    def link_parents(self) -> Dict[str, Optional[str]]:
        """The link above, by link; None for the root."""
    @property
    def link_joints(self) -> Dict[str, str]:
        """The joint to the link above, by link; the root has none."""
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
                    max_iterations: int = ..., any_within: bool = False,
                    time_limit: float = ...) -> ArticulatedToiResult:
    """When a link of a moving robot first meets an obstacle or a link that it is paired with.

    Positions are a dictionary by joint, an array in the order of Robot.joint_names, or None; joints that
    are not named are at 0, clamped into their limits. They change linearly over the step. The root moves
    from root_start to root_end (by default it rests). any_within as in toi().
    """

class RobotLeastDistance:
    """Of a robot; A is the link."""

    @property
    def status(self) -> Status:
        """As LeastDistance.status."""
    @property
    def distance(self) -> float:
        """Certified: never closer; at most the tolerance below the truth [m]."""
    @property
    def found(self) -> float:
        """The distance at that time, or enough [m]; infinite if nothing moves relative to another."""
    @property
    def time(self) -> float:
        """Of what was found: [s] on a trajectory, else in [0, 1]."""
    @property
    def segment(self) -> Optional[int]:
        """Of a trajectory."""
    @property
    def link(self) -> Optional[str]:
        """None if enough is kept."""
    @property
    def other_link(self) -> Optional[str]: ...
    @property
    def obstacle(self) -> Optional[int]: ...
    @property
    def point_link(self) -> _Array:
        """In the world at that time [m]."""
    @property
    def point_other(self) -> _Array: ...
    @property
    def normal(self) -> _Array:
        """Unit, from the link to the other: the direction in which the distance grows."""

def articulated_least_distance(robot: Robot, start: Positions, end: Positions,
                               obstacles: Sequence[Tuple[Mesh, Union[Motion, Pose]]], *,
                               root_start: Pose = None, root_end: Pose = None,
                               self_pairs: Sequence[Tuple[str, str]] = ..., tolerance: float = ...,
                               enough: float = ..., time_limit: float = ...) -> RobotLeastDistance:
    """The smallest distance of a moving robot, as articulated_toi() moves it, from the obstacles, and of
    its paired links from each other; larger ones than enough [m] are not looked for. Pairs without
    relative motion are left out."""

class Trajectory:
    """A path of a robot's joints over time, in pieces of at most fifth degree."""

    @staticmethod
    def through(robot: Robot, times: ArrayLike, positions: ArrayLike,
                velocities: Optional[ArrayLike] = None, accelerations: Optional[ArrayLike] = None, *,
                root: Pose = None) -> "Trajectory":
        """Through all waypoints, as the controllers of ROS do: linear between positions, cubic with
        velocities, quintic with accelerations, too.

        times: n, increasing [s]; the others: n x joints, in the order of Robot.joint_names. The root
        rests. Raises ValueError for what does not fit.
        """
    @staticmethod
    def spline(robot: Robot, knots: ArrayLike, control_points: ArrayLike, *, degree: int = 3,
               root: Pose = None) -> "Trajectory":
        """A B-spline of degree 1 to 5; knots: n + degree + 1 [s]; control_points: n x joints."""
    @property
    def times(self) -> _Array:
        """Of the ends of the pieces [s]."""
    def at(self, time: float) -> _Array:
        """Positions of the joints, in the order of Robot.joint_names."""
    def __len__(self) -> int:
        """The number of pieces."""

class TrajectoryToiResult(ArticulatedToiResult):
    """The time is that of the trajectory [s]."""

    @property
    def segment(self) -> Optional[int]:
        """The piece in which the query ended; None if the trajectory is free."""

def trajectory_toi(trajectory: Trajectory, obstacles: Sequence[Tuple[Mesh, Pose]], *,
                   self_pairs: Sequence[Tuple[str, str]] = ..., tolerance: float = ...,
                   minimum_separation: float = 0.0, max_iterations: int = ...,
                   time_limit: float = ..., jobs: int = 0) -> TrajectoryToiResult:
    """The first contact on a whole trajectory among obstacles at rest, or Status.SEPARATED: the
    certificate that there is none. jobs is the number of threads (0: one per core); the answer does not
    depend on it. Ctrl-C ends the query."""

def trajectory_least_distance(trajectory: Trajectory, obstacles: Sequence[Tuple[Mesh, Pose]], *,
                              self_pairs: Sequence[Tuple[str, str]] = ..., tolerance: float = ...,
                              enough: float = ..., time_limit: float = ...,
                              jobs: int = 0) -> RobotLeastDistance:
    """The smallest distance on a whole trajectory."""

class Depth(_Enumeration):
    """What becomes of features that deform and whose gap has come down to the tolerance."""

    TOLERANCE: "Depth"  #: it is a contact
    DECIDE: "Depth"  #: it is followed further; what stays open is a contact
    EXACT: "Depth"  #: a contact if and only if the features touch, or come within the minimum separation

class DeformableSurface:
    """A mesh that deforms: its hierarchy, built once, and where its vertices are in a step. Threads may
    share it; they take turns."""

    def __init__(self, mesh: Mesh, *, self_collision: bool = True, weld_duplicates: bool = False,
                 seams: Sequence[Tuple[int, int]] = ...) -> None:
        """At rest. seams are pairs of vertices that are sewn together. Raises ValueError for vertices at
        the same place, unless they are welded."""
    def set_step(self, start: ArrayLike, end: ArrayLike) -> None:
        """Where the vertices are at both ends of the step: n x 3 [m]; in between they move on straight
        lines. Raises ValueError, and keeps the step before, for other numbers of vertices and what is
        not finite."""
    def set_motion(self, mesh: Mesh, motion: Union[Motion, Pose]) -> None:
        """The step of the rigid mesh that the surface was made of. How far arcs are off straight lines is
        kept as an additional separation, so divide steps with large turns."""

def deformable_contacts(surfaces: Sequence[DeformableSurface], *, first_only: bool = False,
                        tolerance: float = ..., minimum_separation: float = 0.0,
                        depth: Depth = ..., max_iterations: int = ..., time_limit: float = ...,
                        jobs: int = 0) -> Tuple[Status, float, Dict[str, NDArray[Any]]]:
    """All contacts of a step between surfaces and within them, or the first ones only, sorted by time.

    Returns the status, the time up to which the step is certified free of contact, and arrays with n rows
    by name: status, is_edge_edge (else a vertex of body_a and a face of body_b), body_a, body_b (indices),
    vertices (n x 4: the vertex and three corners, or two ends of each edge), time, gap, normal (from A
    to B), weights (n x 4, of the vertices in the vector from A's nearest point to B's). The answer does
    not depend on the number of threads.
    """

def elementary_toi(start: ArrayLike, end: ArrayLike, *, edge_edge: bool = False, tolerance: float = ...,
                   minimum_separation: float = 0.0, depth: Depth = ...,
                   max_iterations: int = ...) -> Dict[str, NDArray[Any]]:
    """The first contacts of n pairs of features whose vertices move on straight lines.

    start, end: n x 4 x 3 [m]: a vertex and the corners of a face, or the ends of two edges. Returns arrays
    with n rows by name: status, is_contact, time, gap, normal, weights.
    """

class Deviation:
    """How far one surface reaches from another."""

    @property
    def lower(self) -> float:
        """The point is this far away [m]."""
    @property
    def upper(self) -> float:
        """Certified: no point is farther away [m]."""
    @property
    def point(self) -> _Array: ...

def surface_deviation(surface: Mesh, other: Mesh, *, enough: float = 0.0,
                      time_limit: float = ...) -> Deviation:
    """The greatest distance of a point of the surface from the other one (the one-sided Hausdorff
    distance), within 1 % or the bound enough [m]. Raises TimeoutError after the time limit [s]."""

class ReducedModel:
    """A smaller model in place of a mesh."""

    @property
    def kind(self) -> str:
        """sphere, capsule, box, hull or mesh"""
    @property
    def mesh(self) -> Mesh: ...
    @property
    def deviation(self) -> float:
        """Certified: no point of either surface is farther from the other one [m]."""
    @property
    def pose(self) -> _Array:
        """Of a sphere, capsule (along z) or box, in the frame of the mesh."""
    @property
    def radius(self) -> float: ...
    @property
    def height(self) -> float:
        """Of a capsule: distance of the centres of its ends [m]."""
    @property
    def half_extents(self) -> _Array:
        """Of a box [m]."""

def reduce(mesh: Mesh, accuracy: float, *, contains: bool = False,
           kind: Optional[str] = None, time_limit: float = ...) -> Optional[ReducedModel]:
    """The cheapest model whose surface deviates by at most the accuracy [m], in both directions.

    With contains, the model's solid contains the mesh, which must be watertight. With kind (sphere,
    capsule, box, hull, mesh), None if no such model keeps the accuracy. Raises TimeoutError soon after
    the time limit [s].
    """

class AccuracyCost:
    """What keeps an accuracy, and what that costs, measured on two bodies."""

    @property
    def accuracy(self) -> float:
        """0: the meshes themselves."""
    @property
    def model_accuracy(self) -> float:
        """For reduce() of both meshes; then queries with this minimum separation and tolerance."""
    @property
    def minimum_separation(self) -> float: ...
    @property
    def tolerance(self) -> float: ...
    @property
    def triangles_a(self) -> int: ...
    @property
    def triangles_b(self) -> int: ...
    @property
    def bytes(self) -> float:
        """Of both hierarchies with their meshes."""
    @property
    def reduce_seconds(self) -> float:
        """For making the models."""
    @property
    def build_seconds(self) -> float:
        """For building their hierarchies."""
    @property
    def microseconds(self) -> float:
        """Of a query, median."""
    @property
    def warm_microseconds(self) -> float:
        """Of a query of the bodies themselves, median."""
    @property
    def pairs(self) -> float:
        """Of nodes and of triangles that it looks at, mean."""
    @property
    def triangles_seen(self) -> int:
        """That all those queries together looked at."""
    @property
    def cold_milliseconds(self) -> float:
        """For building as far as one query needs, and that query, median."""
    @property
    def triangles_built(self) -> int:
        """For that query, median."""
    @property
    def largest_gap(self) -> float:
        """Of the meshes themselves, where a query stopped [m]."""
    @property
    def contacts(self) -> int: ...
    @property
    def broken(self) -> int:
        """Contacts whose gap is 0 or above the accuracy: must be 0."""

def advise(mesh_a: Mesh, mesh_b: Mesh, *, time_limit: float = 50.0) -> List[AccuracyCost]:
    """Measures on random motions of two bodies what accuracies from 1 um to 5 mm cost: first the meshes
    themselves, then coarser and coarser models. No row is begun after the time limit [s] or Ctrl-C."""

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
    def usual_mass(self) -> float: ...
    @property
    def usual_mass_from(self) -> str: ...
    @property
    def is_watertight(self) -> bool: ...

def plan(hand: Hand, object: GraspObject, *, candidates: int = ..., seed: int = ..., jobs: int = ...,
         time_limit: float = ..., volumes: int = ..., tolerance: float = ..., friction: float = ...,
         cone_edges: int = ..., force_closure_threshold: float = ...,
         mass: Optional[float] = None,
         progress: Optional[Callable[[int], None]] = None) -> Tuple[str, bool]:
    """Use bullet_ccd.grasp.plan()."""

def close_at(hand: Hand, object: GraspObject, pose: Pose, shift: ArrayLike = ..., *,
             preshape: Optional[str] = None, tolerance: float = ..., friction: float = ...,
             cone_edges: int = ..., force_closure_threshold: float = ...,
             mass: Optional[float] = None) -> str:
    """Use bullet_ccd.grasp.close()."""

def squeeze(hand: Hand, record: str, *, mass: float, center_of_mass: Sequence[float],
            friction: float = ..., firmness: float = ..., efforts: Dict[str, float] = ...) -> Dict[str, Any]:
    """Use bullet_ccd.grasp.squeeze()."""

def trial(hand: Hand, object: GraspObject, record: str, protocol: str, *, mass: float,
          friction: float = ..., firmness: float = ..., efforts: Dict[str, float] = ...,
          surface_friction: Optional[float] = None, rate: float = ..., up: ArrayLike = ...,
          seed: int = ...) -> Dict[str, Any]:
    """Use bullet_ccd.grasp.trial()."""

def forces(hand: Hand, object: GraspObject, record: str, load: ArrayLike, *, friction: float = ...,
           objective: str = ..., efforts: Dict[str, float] = ...) -> Dict[str, Any]:
    """Use bullet_ccd.grasp.forces()."""

def pick_place(arm: Robot, hand: Hand, object: GraspObject, object_pose: Pose, target: ArrayLike,
               target_size: ArrayLike, *, obstacles: Sequence[Tuple[str, Mesh, Pose]] = ...,
               start: Dict[str, float] = ..., root_pose: Pose = None, flange: str = "",
               mount: Pose = None, candidates: int = ..., tries: int = ..., approach: float = ...,
               lift: float = ..., acceleration: float = ..., mass: Optional[float] = None,
               seed: int = ..., time_limit: float = 0.0) -> Tuple[str, str]:
    """Use bullet_ccd.grasp.pick_place()."""
