"""Situations in the style of PyBullet's examples, each of which counts what must not be there."""
import contextlib
import math
import os
import random
import sys
import time
from pathlib import Path

import numpy as np

import bullet_ccd
import pybullet_scenes as scenes
from pybullet_scenes import ROOT, box, concave, height

DATA = Path(os.environ.get("BULLET_CCD_TEST_DATA", ROOT.parent / "shared/data"))


class Run:
    """A simulation whose steps are timed."""

    def __init__(self, p, folder):
        self.p = p
        self.folder = folder
        self.seconds = 0.0
        self.count = 0

    def steps(self, count, watch=None):
        for _ in range(count):
            begin = time.perf_counter()
            self.p.stepSimulation()
            self.seconds += time.perf_counter() - begin
            self.count += 1
            if watch is not None:
                watch()

    def ground(self):
        self.p.setGravity(0, 0, -9.81)
        return box(self.p, [2, 2, 0.1], place=[0, 0, -0.1])


def stack(run):
    """Ten boxes on each other stand for two seconds: how far the topmost is off its height [mm]."""
    run.ground()
    top = [box(run.p, [0.05] * 3, 1.0, [0, 0, 0.05 + 0.1 * k]) for k in range(10)][-1]
    run.steps(480)
    return round(1000 * abs(height(run.p, top) - 0.95))


def wall(run):
    """A ball at 60 m/s meets a wall of bricks of 20 mm: 1 if it went through and no brick moved."""
    p = run.p
    run.ground()
    bricks = [box(p, [0.01, 0.05, 0.025], 0.2, [0, 0.1 * (k - 2), 0.025 + 0.05 * row])
              for row in range(4) for k in range(5)]
    before = [p.getBasePositionAndOrientation(brick)[0] for brick in bricks]
    shape = p.createCollisionShape(p.GEOM_SPHERE, radius=0.02)
    ball = p.createMultiBody(0.05, shape, -1, [-1.13, 0.0, 0.075])
    p.resetBaseVelocity(ball, [60, 0, 0])
    run.steps(60)
    moved = max(math.dist(a, p.getBasePositionAndOrientation(brick)[0])
                for a, brick in zip(before, bricks))
    return int(moved < 0.002)


def concave_pile(run):
    """A mug, a bowl, a banana and a mug fall on each other: pairs whose surfaces intersect in the
    end, by the distance of the core library."""
    p = run.p
    run.ground()
    names = ["025_mug", "024_bowl", "011_banana", "025_mug"]
    bodies = [concave(p, DATA / f"objects/ycb_4k/{name}.obj", 0.3, [0, 0, 0.05 + 0.12 * k])
              for k, name in enumerate(names)]
    run.steps(480)
    meshes, poses = [], []
    for body, name in zip(bodies, names):
        meshes.append(bullet_ccd.Mesh.load(str(DATA / f"objects/ycb_4k/{name}.obj")))
        place, turn = p.getBasePositionAndOrientation(body)
        poses.append(np.eye(4))
        poses[-1][:3, :3] = np.reshape(p.getMatrixFromQuaternion(turn), (3, 3))
        poses[-1][:3, 3] = place
    return sum(bullet_ccd.distance(meshes[i], meshes[j], poses[i], poses[j]).distance <= 0.0
               for i in range(4) for j in range(i))


def rings(run):
    """Six concave rings are dropped on each other: how many lie deeper than one on another."""
    run.ground()
    path = scenes.write_ring(run.folder / "ring.obj")
    bodies = [concave(run.p, path, 0.5, [0.002 * k, 0, 0.02 + 0.06 * k]) for k in range(6)]
    run.steps(600)
    return sum(height(run.p, body) < 0.02 + 0.04 * k - 0.005 for k, body in enumerate(bodies))


def thin_box(run):
    """Forty small balls are poured at 10 m/s into a box of sheets of 1 mm: how many get out."""
    p = run.p
    p.setGravity(0, 0, -9.81)
    half, thin = 0.1, 0.0005
    for half_sizes, place in (([half, half, thin], [0, 0, 0]),
                              ([thin, half, 0.3], [half, 0, 0.3]), ([thin, half, 0.3], [-half, 0, 0.3]),
                              ([half, thin, 0.3], [0, half, 0.3]), ([half, thin, 0.3], [0, -half, 0.3])):
        box(p, half_sizes, place=place)
    noise = random.Random(1)
    shape = p.createCollisionShape(p.GEOM_SPHERE, radius=0.008)
    balls = []
    for _ in range(40):
        place = [noise.uniform(-0.05, 0.05), noise.uniform(-0.05, 0.05), noise.uniform(0.1, 0.3)]
        balls.append(p.createMultiBody(0.01, shape, -1, place))
        p.resetBaseVelocity(balls[-1], [noise.uniform(-5, 5), noise.uniform(-5, 5), -10])
        run.steps(6)
    run.steps(240)
    places = [p.getBasePositionAndOrientation(ball)[0] for ball in balls]
    return sum(z < -0.01 or max(abs(x), abs(y)) > half + 0.01 and z < 0.5 for x, y, z in places)


def multibody(p, mass, shape, place, links, turn=(0, 0, 0, 1)):
    """`links`: mass, shape, position, parent, joint type, axis."""
    return p.createMultiBody(
        mass, shape, -1, place, turn, linkMasses=[link[0] for link in links],
        linkCollisionShapeIndices=[link[1] for link in links],
        linkVisualShapeIndices=[-1] * len(links), linkPositions=[link[2] for link in links],
        linkOrientations=[[0, 0, 0, 1]] * len(links),
        linkInertialFramePositions=[[0, 0, 0]] * len(links),
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * len(links),
        linkParentIndices=[link[3] for link in links], linkJointTypes=[link[4] for link in links],
        linkJointAxis=[link[5] for link in links])


def gripper(run):
    """Two thin jaws close at 4 m/s on a card of 1 mm, at 12 distances: jaws that end beyond it."""
    p = run.p
    missed = 0
    for start in (0.03 + 0.003 * k for k in range(12)):
        p.resetSimulation()
        shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.0005, 0.01, 0.03])
        jaws = multibody(p, 0, -1, [0, 0, 0], [
            (0.05, shape, [side * start, 0, 0], 0, p.JOINT_PRISMATIC, [-side, 0, 0])
            for side in (1, -1)])
        card = box(p, [0.0005, 0.03, 0.03], 0.01)
        for joint in (0, 1):
            p.resetJointState(jaws, joint, 0.0, 4.0)
            p.setJointMotorControl2(jaws, joint, p.VELOCITY_CONTROL, targetVelocity=4.0, force=20)
        run.steps(24)
        middle = p.getBasePositionAndOrientation(card)[0][0]
        missed += p.getLinkState(jaws, 0)[0][0] < middle
        missed += p.getLinkState(jaws, 1)[0][0] > middle
    return missed


class PartsBelow:
    """Parts of a multibody that have ever been below a height within half a width of the middle."""

    def __init__(self, p, body, floor, half):
        self.p, self.body, self.floor, self.half, self.parts = p, body, floor, half, set()

    def __call__(self):
        places = [self.p.getBasePositionAndOrientation(self.body)[0]]
        places += [self.p.getLinkState(self.body, link)[0]
                   for link in range(self.p.getNumJoints(self.body))]
        self.parts |= {k for k, (x, y, z) in enumerate(places)
                       if z < self.floor and max(abs(x), abs(y)) < self.half}


def ragdoll(run):
    """A body of nine capsules on spherical joints falls flat at 30 m/s on a sheet of 1 mm: parts that
    come below it."""
    p = run.p
    p.setGravity(0, 0, -9.81)
    box(p, [2, 2, 0.0005])
    limb = p.createCollisionShape(p.GEOM_CAPSULE, radius=0.01, height=0.1)
    chest = p.createCollisionShape(p.GEOM_CAPSULE, radius=0.03, height=0.15)
    links = []
    for x, z in ((0.09, 0.08), (-0.09, 0.08), (0.05, -0.16), (-0.05, -0.16)):  # arms, legs
        links.append((0.3, limb, [x, 0, z], 0, p.JOINT_SPHERICAL, [0, 0, 1]))
        links.append((0.3, limb, [0, 0, -0.14], len(links), p.JOINT_SPHERICAL, [0, 0, 1]))
    doll = multibody(p, 2.0, chest, [0, 0, 0.6], links, [math.sqrt(0.5), 0, 0, math.sqrt(0.5)])
    for joint in range(p.getNumJoints(doll)):
        p.setJointMotorControlMultiDof(doll, joint, p.POSITION_CONTROL, [0, 0, 0, 1],
                                       positionGain=0, velocityGain=0.1, force=[0.1] * 3)
    p.resetBaseVelocity(doll, [0, 0, -30], [3, 1, 0])
    below = PartsBelow(p, doll, -0.002, 1.9)
    run.steps(240, below)
    return len(below.parts)


def quadruped(run):
    """Four legs with thin feet come down at 20 m/s on rough terrain and trot: parts that
    come below it."""
    p = run.p
    p.setGravity(0, 0, -9.81)
    noise = random.Random(2)
    rows, cell = 32, 0.08
    heights = [noise.uniform(0.0, 0.04) for _ in range(rows * rows)]
    terrain = p.createCollisionShape(p.GEOM_HEIGHTFIELD, meshScale=[cell, cell, 1],
                                     heightfieldData=heights, numHeightfieldRows=rows,
                                     numHeightfieldColumns=rows)
    p.createMultiBody(0, terrain, -1, [0, 0, (max(heights) + min(heights)) / 2])
    trunk = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.12, 0.06, 0.02])
    thigh = p.createCollisionShape(p.GEOM_CAPSULE, radius=0.01, height=0.08)
    shin = p.createCollisionShape(p.GEOM_CAPSULE, radius=0.006, height=0.08)
    links = []
    for x, y in ((0.1, 0.07), (0.1, -0.07), (-0.1, 0.07), (-0.1, -0.07)):
        links.append((0.2, thigh, [x, y, -0.05], 0, p.JOINT_REVOLUTE, [0, 1, 0]))
        links.append((0.1, shin, [0, 0, -0.1], len(links), p.JOINT_REVOLUTE, [0, 1, 0]))
    robot = multibody(p, 3.0, trunk, [0, 0, 0.6], links)
    p.resetBaseVelocity(robot, [0, 0, -20])
    below = PartsBelow(p, robot, -0.005, 1.1)
    for k in range(40):
        for joint in range(8):
            swing = 0.3 * math.sin(0.8 * k + (math.pi if joint // 2 in (1, 2) else 0.0))
            p.setJointMotorControl2(robot, joint, p.POSITION_CONTROL, swing * (1 - 2 * (joint % 2)),
                                    force=5)
        run.steps(10, below)
    return len(below.parts)


def whip(run):
    """A chain of twelve links on point to point joints swings at 12 m/s at a sheet of 1 mm: links
    that were behind it at once."""
    p = run.p
    p.setGravity(0, 0, -9.81)
    shape = p.createCollisionShape(p.GEOM_CAPSULE, radius=0.004, height=0.03)
    bodies = []
    for k in range(12):
        bodies.append(p.createMultiBody(0.02, shape, -1, [0, 0, -0.02 - 0.04 * k]))
        p.resetBaseVelocity(bodies[-1], [12.0 * (k + 1) / 12, 0, 0])
        if k == 0:
            p.createConstraint(bodies[0], -1, -1, -1, p.JOINT_POINT2POINT, [0, 0, 0], [0, 0, 0.02],
                               [0, 0, 0])
        else:
            p.createConstraint(bodies[k - 1], -1, bodies[k], -1, p.JOINT_POINT2POINT, [0, 0, 0],
                               [0, 0, -0.02], [0, 0, 0.02])
    box(p, [0.0005, 0.5, 0.4], place=[0.1, 0, -0.4])  # a curtain that the chain hangs before
    beyond = [0]

    def watch():
        places = [p.getBasePositionAndOrientation(body)[0] for body in bodies]
        beyond[0] = max(beyond[0], sum(x > 0.101 and z < 0.0 for x, _, z in places))

    run.steps(60, watch)
    return beyond[0]


def kuka(run):
    """A KUKA arm with a hand holds a paddle of 1 mm and swings it at 15 rad/s at a sheet of 1 mm, from
    8 angles: how often the paddle's middle comes behind the sheet."""
    p = run.p
    through = 0
    for k in range(8):
        p.resetSimulation()
        arm = p.loadURDF(str(DATA / "arms/combined/iiwa7_sah.urdf"), useFixedBase=True)
        moving = [j for j in range(p.getNumJoints(arm)) if p.getJointInfo(arm, j)[2] != p.JOINT_FIXED]
        for joint in range(p.getNumJoints(arm)):
            p.setJointMotorControl2(arm, joint, p.VELOCITY_CONTROL, force=0)
        angle, speed = -0.4 + 0.01 * k, 15.0
        p.resetJointState(arm, moving[1], 1.4)
        p.resetJointState(arm, moving[0], angle, speed)
        link, turn = p.getLinkState(arm, moving[6])[:2]
        place = [link[0] + 0.4 * math.cos(angle), link[1] + 0.4 * math.sin(angle), link[2]]
        paddle = box(p, [0.08, 0.0005, 0.08], 0.02, place)
        upright = p.getQuaternionFromEuler([0, 0, angle])
        p.resetBasePositionAndOrientation(paddle, place, upright)
        p.resetBaseVelocity(paddle, [-speed * place[1], speed * place[0], 0], [0, 0, speed])
        grip = p.multiplyTransforms(*p.invertTransform(link, turn), place, upright)
        p.createConstraint(arm, moving[6], paddle, -1, p.JOINT_FIXED, [0, 0, 0], grip[0], [0, 0, 0],
                           grip[1])
        box(p, [0.1, 0.0005, 0.3], place=[1.3, 0.0, link[2]])
        behind = []

        def watch():
            x, y, z = p.getBasePositionAndOrientation(paddle)[0]
            behind.append(y > 0.002 and abs(x - 1.3) < 0.1 and abs(z - link[2]) < 0.3)

        run.steps(20, watch)
        through += any(behind)
    return through


def pick(run):
    """A Panda arm closes its gripper on a box and lifts it by 0.2 m: 1 if it is not held."""
    p = run.p
    p.setGravity(0, 0, -9.81)
    arm = p.loadURDF(str(DATA / "arms/panda/panda_arm_hand.urdf"), useFixedBase=True)
    names = {p.getJointInfo(arm, j)[1].decode(): j for j in range(p.getNumJoints(arm))}
    fingers = [names["panda_finger_joint1"], names["panda_finger_joint2"]]
    joints = [names[f"panda_joint{k}"] for k in range(1, 8)]
    tip = names[[name for name in names if "grasptarget" in name][0]]
    home = [0, 0.2, 0, -2.2, 0, 2.4, 0.785]
    for joint, angle in zip(joints, home):
        p.resetJointState(arm, joint, angle)
    for finger in fingers:
        p.resetJointState(arm, finger, 0.04)
    box(p, [0.1, 0.1, 0.1], place=[0.5, 0, 0.0])
    thing = box(p, [0.02, 0.02, 0.03], 0.2, [0.5, 0, 0.1305])
    p.changeDynamics(thing, -1, lateralFriction=1.0)
    down = p.getQuaternionFromEuler([math.pi, 0, 0])

    def go(place, opening, count):
        movable = [j for j in range(p.getNumJoints(arm)) if p.getJointInfo(arm, j)[2] != p.JOINT_FIXED]
        for _ in range(count):
            angles = p.calculateInverseKinematics(arm, tip, place, down, maxNumIterations=20)
            for joint in joints:
                p.setJointMotorControl2(arm, joint, p.POSITION_CONTROL, angles[movable.index(joint)],
                                        force=200)
            for finger in fingers:
                p.setJointMotorControl2(arm, finger, p.POSITION_CONTROL, opening, force=40)
            run.steps(1)

    go([0.5, 0, 0.25], 0.04, 240)
    go([0.5, 0, 0.135], 0.04, 240)
    go([0.5, 0, 0.135], 0.0, 120)
    go([0.5, 0, 0.335], 0.0, 360)
    return int(height(p, thing) < 0.28)


SITUATIONS = {  # name: function, files that it needs, whether its number must be 0 with the plugin
    "stack of ten": (stack, None, False),
    "ball and wall": (wall, None, True),
    "rings": (rings, None, True),
    "mugs, bowl, banana": (concave_pile, "objects/ycb_4k", True),
    "balls in a thin box": (thin_box, None, True),
    "gripper and card": (gripper, None, True),
    "ragdoll on a sheet": (ragdoll, None, True),
    "quadruped on terrain": (quadruped, None, True),
    "chain and curtain": (whip, None, True),
    "KUKA arm and paddle": (kuka, "arms/combined", True),
    "Panda picks a box": (pick, "arms/panda", True),
}


@contextlib.contextmanager
def silence():
    """PyBullet prints a page on every robot whose links lack inertia."""
    sys.stdout.flush()
    kept, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nothing)


def play(p, enable, situation, folder):
    """The number of a situation, milliseconds of a step, and impacts."""
    client = p.connect(p.DIRECT)
    ccd = enable(client) if enable is not None else None
    run = Run(p, folder)
    number = situation(run)
    impacts = ccd.counters.impacts if ccd is not None else 0
    p.disconnect(client)
    return number, 1000 * run.seconds / run.count, impacts
