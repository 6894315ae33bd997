"""A program of a user, which mypy --strict checks against the stubs; it is not run."""
from typing import List, Optional, Tuple

import numpy as np

import bullet_ccd as ccd
from bullet_ccd import grasp


def earliest(mesh: ccd.Mesh, count: int) -> Tuple[float, str]:
    poses = np.stack([np.eye(4)] * count)
    answers = ccd.toi_batch(mesh, mesh, ccd.Motions.twists(poses, velocity=(0, 0, -1)))
    hit: ccd.ToiResult = ccd.toi(mesh, mesh, ccd.Motion(velocity=(1, 0, 0)), strategy=ccd.Strategy.C2A)
    if hit.status == ccd.Status.HIT and hit.is_contact:
        print(hit.normal[0] + 1.0)
    return float(answers["time"].min()), hit.status.name


def world() -> Optional[Tuple[str, str]]:
    manager = ccd.CollisionManager()
    manager.add_object("box", ccd.Mesh.load("box.obj"), np.eye(4))
    _, names = manager.first_contact({"box": np.eye(4)})
    return names


def best(urdf: str) -> List[grasp.Grasp]:
    robot = ccd.Robot.load(urdf)
    hit = ccd.articulated_toi(robot, {}, dict.fromkeys(robot.joint_names, 1.0), [])
    print([contact.link.upper() for contact in hit.contacts])
    return grasp.plan(grasp.Hand.load(urdf), grasp.GraspObject(ccd.Mesh.load("mug.obj")),
                      progress=lambda count: print(count))


def certified(robot: ccd.Robot, wall: ccd.Mesh) -> Optional[float]:
    path = ccd.Trajectory.through(robot, [0, 1], np.zeros((2, len(robot.joint_names))))
    verdict: ccd.TrajectoryToiResult = ccd.trajectory_toi(path, [(wall, None)], jobs=2)
    if verdict.segment is not None:
        return verdict.time
    return ccd.trajectory_least_distance(path, [(wall, None)]).distance + float(path.at(0.5)[0])


def holds(hand: grasp.Hand, thing: grasp.GraspObject, best: grasp.Grasp) -> bool:
    trial: grasp.Trial = grasp.trial(hand, thing, best, "lift", mass=0.2)
    loads = grasp.forces(hand, thing, best, (0, 0, -1, 0, 0, 0))
    return trial.held and loads.balanced and grasp.squeeze(hand, best).reason is None


def coarser(mesh: ccd.Mesh) -> int:
    model = ccd.reduce(mesh, 1e-3)
    surface = ccd.DeformableSurface(mesh)
    status, time, contacts = ccd.deformable_contacts([surface], depth=ccd.Depth.DECIDE)
    print(status.name, time + 1.0, contacts["gap"].max(), ccd.surface_deviation(mesh, mesh).upper)
    return 0 if model is None else len(model.mesh.triangles)
