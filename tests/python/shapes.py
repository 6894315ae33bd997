"""Meshes, poses and an arm that the tests share."""
import numpy as np
import pytest

import bullet_ccd as ccd

FACES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
         [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]


def box_arrays(half=0.5):
    corners = [[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    return np.array(corners), np.array(FACES)


def box(half=0.5):
    return ccd.Mesh(*box_arrays(half))


def at(x, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def turned(axis, angle, place=(0, 0, 0)):
    """By Rodrigues' formula."""
    axis = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    pose = np.eye(4)
    pose[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    pose[:3, 3] = place
    return pose


# A bar of 1 m that turns about z.
ARM = """<robot name="arm"><link name="base"/><link name="bar"><collision><origin xyz="0.5 0 0"/>
<geometry><box size="1 0.1 0.1"/></geometry></collision></link><joint name="turn" type="revolute">
<parent link="base"/><child link="bar"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1"
velocity="1"/></joint></robot>"""


@pytest.fixture
def arm(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    return ccd.Robot.load(path)
