"""Continuous collision detection of triangle meshes and robots, and grasp planning.

Lengths are in metres, angles in radians. Poses are 4 x 4 homogeneous matrices of NumPy; None stands
for the identity. Motions run over a step of time from 0 to 1, and velocities are per step. Queries
release Python's lock, so threads run in parallel. Wrong arguments raise TypeError, ValueError or
KeyError with the name of the argument; bad files raise RuntimeError.
"""
from . import grasp
from ._arguments import as_mesh
from ._core import (DEFAULT_TOLERANCE, ArticulatedToiResult, Contact, Distance, FirstContact,
                    LeastDistance, LinkContact, Mesh, Motion, Motions, Robot, Status, Strategy, ToiResult,
                    __version__, articulated_toi, contacts, distance, first_contact,
                    least_distance, toi, toi_batch)
from .collision_manager import CollisionManager, ContactData, DistanceData

__all__ = [
    "DEFAULT_TOLERANCE", "ArticulatedToiResult", "CollisionManager", "Contact", "ContactData",
    "Distance", "DistanceData", "FirstContact", "LeastDistance", "LinkContact", "Mesh", "Motion",
    "Motions", "Robot", "Status", "Strategy", "ToiResult", "__version__", "articulated_toi",
    "as_mesh", "contacts", "distance", "first_contact", "grasp", "least_distance", "toi",
    "toi_batch",
]
