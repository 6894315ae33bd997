"""A real PyBullet, and small scenes for it that tests and benchmarks share."""
import importlib
import lzma
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def find(folder):
    """PyBullet from $BULLET_CCD_PYBULLET (default: ../shared/peers/pybullet beside the checkout), where
    it may be compressed by xz (then it goes into `folder`), or the one that is installed. Raises
    ImportError if there is none."""
    place = Path(os.environ.get("BULLET_CCD_PYBULLET", ROOT.parent / "shared/peers/pybullet"))
    for path in sorted(place.glob("pybullet*.so*")):
        if path.suffix == ".xz":
            (folder / path.stem).write_bytes(lzma.decompress(path.read_bytes()))
            place = folder
        sys.path.insert(0, str(place))
        break
    try:
        return importlib.import_module("pybullet")
    except ImportError as error:
        raise ImportError(f"no PyBullet for this Python in {place}: {error}") from error


def box(p, half, mass=0.0, place=(0, 0, 0), client=0):
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=client)
    return p.createMultiBody(mass, shape, -1, place, physicsClientId=client)


def sliding_box(p, half, place, mass=0.1, client=0):
    """A box on a prismatic joint that goes down: link 0 of a multibody whose base has no shape."""
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=client)
    body = p.createMultiBody(
        0, -1, -1, [0, 0, 0], linkMasses=[mass], linkCollisionShapeIndices=[shape],
        linkVisualShapeIndices=[-1], linkPositions=[place], linkOrientations=[[0, 0, 0, 1]],
        linkInertialFramePositions=[[0, 0, 0]], linkInertialFrameOrientations=[[0, 0, 0, 1]],
        linkParentIndices=[0], linkJointTypes=[p.JOINT_PRISMATIC], linkJointAxis=[[0, 0, -1]],
        physicsClientId=client)
    p.setJointMotorControl2(body, 0, p.VELOCITY_CONTROL, force=0, physicsClientId=client)
    return body


def height(p, body, client=0):
    return p.getBasePositionAndOrientation(body, physicsClientId=client)[0][2]


def steps(p, count, client=0):
    for _ in range(count):
        p.stepSimulation(physicsClientId=client)


PLATE = 0.00025  # half the thickness of the plates that are shot at [m]


def shoot(p, link=False, start=0.05, speed=20.0, client=0):
    """A thin box, or a link that is one, at a plate of 0.5 mm. Returns its height after 30 steps."""
    p.resetSimulation(physicsClientId=client)
    box(p, [0.3, 0.3, PLATE], client=client)
    if link:
        body = sliding_box(p, [0.1, 0.005, 0.0005], [0, 0, start], client=client)
        p.resetJointState(body, 0, 0, speed, physicsClientId=client)
    else:
        body = box(p, [0.01, 0.01, 0.0005], 0.1, [0, 0, start], client)
        p.resetBaseVelocity(body, [0, 0, -speed], physicsClientId=client)
    steps(p, 30, client)
    return (p.getLinkState(body, 0, physicsClientId=client)[0][2] if link
            else height(p, body, client))


RING = 0.02  # half the height of a ring [m]


def write_ring(path):
    """A square ring of 200 mm around a hole of 100 mm, 40 mm high."""
    corners = [(x, y) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    points = [(size * x, size * y, z) for z in (-RING, RING) for size in (0.1, 0.05)
              for x, y in corners]
    faces = []
    for i in range(4):
        j = (i + 1) % 4
        quads = [(i, j, 8 + j, 8 + i), (4 + j, 4 + i, 12 + i, 12 + j),  # outside, inside
                 (8 + i, 8 + j, 12 + j, 12 + i), (j, i, 4 + i, 4 + j)]  # top, bottom
        faces += [(q[0], q[1], q[2]) for q in quads] + [(q[0], q[2], q[3]) for q in quads]
    path.write_text("".join("v %r %r %r\n" % point for point in points) +
                    "".join("f %d %d %d\n" % tuple(v + 1 for v in face) for face in faces))
    return path


def concave(p, path, mass, place, scale=(1, 1, 1), client=0):
    """A body of exactly this mesh."""
    shape = p.createCollisionShape(p.GEOM_MESH, fileName=str(path), meshScale=scale,
                                   flags=p.GEOM_FORCE_CONCAVE_TRIMESH, physicsClientId=client)
    body = p.createMultiBody(mass, shape, -1, place, physicsClientId=client)
    p.changeDynamics(body, -1, localInertiaDiagonal=[0.004 * mass] * 3, physicsClientId=client)
    return body
