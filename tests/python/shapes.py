"""Meshes and poses that the tests share."""
import numpy as np

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
