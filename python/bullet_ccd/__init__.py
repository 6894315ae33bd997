"""Continuous collision detection of triangle meshes and robots, and grasp planning.

Lengths are in metres, angles in radians. Poses are 4 x 4 homogeneous matrices of NumPy; None stands
for the identity. Motions run over a step of time from 0 to 1, and velocities are per step. Queries
release Python's lock, so threads run in parallel, and Ctrl-C ends those that take long. Wrong
arguments raise TypeError, ValueError or KeyError with the name of the argument; bad files raise
RuntimeError. Meshes, motions, results and grasps can be pickled; robots and hands are by the paths of
their files, which are read again.
"""
from . import grasp, moveit
from ._arguments import as_mesh
from ._core import (DEFAULT_TOLERANCE, AccuracyCost, ArticulatedToiResult, Contact, ConvexShape,
                    DeformableSurface, Depth, Deviation, Distance, FirstContact, LeastDistance,
                    LinkContact, Mesh, Motion, Motions, ReducedModel, Robot, RobotLeastDistance,
                    Status, Strategy, ToiResult, Trajectory, TrajectoryToiResult, __version__,
                    advise, articulated_least_distance, articulated_toi, contacts, convex_toi,
                    deformable_contacts, distance, elementary_toi, first_contact, least_distance,
                    least_distance_batch, reduce, surface_deviation, toi, toi_batch,
                    trajectory_least_distance, trajectory_toi)
from .collision_manager import CollisionManager, ContactData, DistanceData

__all__ = [
    "DEFAULT_TOLERANCE", "AccuracyCost", "ArticulatedToiResult", "CollisionManager", "Contact",
    "ContactData", "ConvexShape", "DeformableSurface", "Depth", "Deviation", "Distance",
    "DistanceData", "FirstContact", "LeastDistance", "LinkContact", "Mesh", "Motion", "Motions",
    "ReducedModel", "Robot", "RobotLeastDistance", "Status", "Strategy", "ToiResult", "Trajectory",
    "TrajectoryToiResult", "__version__", "advise", "articulated_least_distance", "articulated_toi",
    "as_mesh", "contacts", "convex_toi", "deformable_contacts", "distance", "elementary_toi",
    "first_contact", "grasp", "least_distance", "least_distance_batch", "moveit", "reduce",
    "surface_deviation", "toi", "toi_batch", "trajectory_least_distance", "trajectory_toi",
]
