"""The world of named objects."""
import numpy as np
import pytest

import bullet_ccd as ccd
from shapes import at, box, box_arrays, turned


def world():
    manager = ccd.CollisionManager()
    manager.add_object("left", box(), at(-2))
    manager.add_object("right", box_arrays(), at(2))
    return manager


def test_intersections_with_a_mesh():
    manager = world()
    assert manager.in_collision_single(box()) is False
    assert manager.in_collision_single(box(), at(1.5), return_names=True) == (True, {"right"})
    collides, names, data = manager.in_collision_single(box(1.8), return_names=True, return_data=True)
    assert collides and names == {"left", "right"} and len(data) == 2
    assert data[0].names == {"left", "__external"}


def test_intersections_inside_and_between_worlds():
    manager = world()
    assert manager.in_collision_internal(return_names=True) == (False, set())
    manager.set_transform("right", at(-1.5, 0.1))
    assert manager.in_collision_internal(return_names=True) == (True, {("left", "right")})
    other = ccd.CollisionManager()
    other.add_object("left", box(), at(-1.2))
    assert manager.in_collision_other(other, return_names=True) == \
        (True, {("left", "left"), ("right", "left")})


def test_distances():
    manager = world()
    assert manager.min_distance_internal() == pytest.approx(3)
    distance, name, data = manager.min_distance_single(box(), at(0.5), return_name=True, return_data=True)
    assert (distance, name) == (pytest.approx(0.5), "right")
    assert data.point("right")[0] == pytest.approx(1.5)
    other = ccd.CollisionManager()
    other.add_object("third", box(), at(0, 3))
    distance, names = manager.min_distance_other(other, return_names=True)
    assert distance == pytest.approx(np.hypot(1, 2)) and names[1] == "third"
    assert ccd.CollisionManager().min_distance_internal() == np.inf


def test_many_objects_as_pair_by_pair():
    random = np.random.default_rng(11)
    mesh, turned_poses = box(0.4), []
    manager, other = ccd.CollisionManager(), ccd.CollisionManager()
    for i in range(40):
        pose = turned(random.normal(size=3), random.uniform(0, 3), random.uniform(-2, 2, 3))
        turned_poses.append(pose)
        (manager if i < 25 else other).add_object(str(i), mesh, pose)

    def distance(i, j):
        return ccd.distance(mesh, mesh, turned_poses[i], turned_poses[j]).distance

    own = {(str(i), str(j)) for i in range(25) for j in range(i + 1, 25) if distance(i, j) == 0}
    between = {(str(i), str(j)) for i in range(25) for j in range(25, 40) if distance(i, j) == 0}
    assert 5 < len(own) < 250 and 5 < len(between) < 300  # some touch, and most do not
    assert manager.in_collision_internal(return_names=True) == (True, own)
    assert manager.in_collision_other(other, return_names=True) == (True, between)
    apart = ccd.CollisionManager()
    for i in range(12):
        apart.add_object(str(i), mesh, turned((1, 1, 0), i, (1.5 * i ** 1.2, 0, 0)))
    expected = min(ccd.distance(mesh, mesh, apart.transform(a), apart.transform(b)).distance
                   for a in apart.names for b in apart.names if a != b)
    assert expected > 0 and apart.min_distance_internal() == expected


def test_first_contact_of_moving_objects():
    manager = world()
    manager.add_object("wall", box(), at(0, 10))
    hit, names = manager.first_contact({"left": at(4, 0, 0)})
    assert names == ("left", "right")
    assert hit.time == pytest.approx(0.5, abs=1e-5)
    assert manager.first_contact({"wall": at(0, 20)})[1] is None
    assert manager.transform("left")[0, 3] == -2  # nothing has moved


def test_objects_come_and_go():
    manager = world()
    assert manager.names == ["left", "right"] and len(manager) == 2 and "left" in manager
    manager.remove_object("left")
    with pytest.raises(KeyError, match="left"):
        manager.set_transform("left", at(0))
    with pytest.raises(KeyError):
        manager.first_contact({"left": at(0)})
    with pytest.raises(TypeError, match="cup: expected"):
        manager.add_object("cup", 3)
    assert "cup" not in manager
    for wrong in (np.eye(3), np.full((4, 4), np.nan), np.zeros((4, 4)), 2 * np.eye(4)):
        with pytest.raises(ValueError, match="right: expected a 4 x 4 pose"):
            manager.set_transform("right", wrong)
        with pytest.raises(ValueError, match="transform: expected a 4 x 4 pose"):
            manager.min_distance_single(box(), wrong)
    assert manager.transform("right")[0, 3] == 2
