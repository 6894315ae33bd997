"""What a program for python-fcl writes, with the answers of closed forms."""
import numpy as np
import pytest

import bullet_ccd.fcl as fcl
from shapes import box_arrays


def model():
    vertices, triangles = box_arrays()
    made = fcl.BVHModel()
    made.beginModel(len(triangles), len(vertices))
    made.addSubModel(vertices, triangles)
    made.endModel()
    return made


def put(*place, rotation=None):
    return fcl.CollisionObject(model(), fcl.Transform(np.eye(3) if rotation is None else rotation,
                                                      np.array(place, float)))


def test_pairs():
    a, b = put(0, 0, 0), fcl.CollisionObject(fcl.Box(1, 1, 1), fcl.Transform(np.array([3.0, 0, 0])))
    result = fcl.DistanceResult()
    assert fcl.distance(a, b, fcl.DistanceRequest(enable_nearest_points=True), result) == pytest.approx(2)
    assert result.nearest_points[0][0] == pytest.approx(0.5) and result.o2 is b.geom
    assert fcl.collide(a, b) == 0
    b.setTranslation([0.9, 0.1, 0.1])
    request, found = fcl.CollisionRequest(num_max_contacts=3, enable_contact=True), fcl.CollisionResult()
    count = fcl.collide(a, b, request, found)
    assert count == len(found.contacts) > 0 and found.is_collision and found.contacts[0].o1 is a.geom
    assert fcl.distance(a, b) == -1


def test_turned_objects():
    # A quarter of a turn about z puts a corner of the box at 1 / sqrt(2).
    quaternion = fcl.Transform(np.array([np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)]))
    turned = put(2, 0, 0, rotation=quaternion.getRotation())
    assert fcl.distance(put(0, 0, 0), turned) == pytest.approx(1.5 - np.sqrt(0.5))


def test_continuous_collision_is_certified():
    thin = fcl.CollisionObject(fcl.Box(1, 1, 1e-4))
    ball, result = put(0, 0, 50), fcl.ContinuousCollisionResult()
    time = fcl.continuousCollide(ball, fcl.Transform(np.array([0.0, 0, -50])), thin, thin.getTransform(),
                                 fcl.ContinuousCollisionRequest(num_max_iterations=2, toc_err=1e-6), result)
    assert result.is_collide and result.time_of_contact == time
    assert time == pytest.approx((50 - 0.5 - 5e-5) / 100, abs=1e-6)
    assert fcl.continuousCollide(ball, ball.getTransform(), thin, thin.getTransform()) == 1


@pytest.mark.parametrize("shape, reach, top, bottom", [
    (fcl.Sphere(0.4), 0.4, 0.4, -0.4), (fcl.Ellipsoid(0.2, 0.3, 0.5), 0.2, 0.5, -0.5),
    (fcl.Capsule(0.1, 0.8), 0.1, 0.5, -0.5), (fcl.Cylinder(0.3, 0.8), 0.3, 0.4, -0.4),
    (fcl.Cone(0.3, 0.8), None, 0.4, -0.4)])
def test_round_shapes_by_closed_forms(shape, reach, top, bottom):
    here, wall = fcl.CollisionObject(shape), fcl.Box(1e-3, 8, 8)
    off = 2 + 5e-4
    assert shape.mesh.is_watertight
    # The facets are outside of the shape, by a thousandth of its size at most.
    if reach:
        for k in range(5):  # in any direction across
            turn = fcl.Transform(np.array([np.cos(0.2 * k), 0, 0, np.sin(0.2 * k)]))
            beside = fcl.CollisionObject(wall, fcl.Transform(turn.getRotation(), turn.getRotation() @ [off, 0, 0]))
            across = reach if not isinstance(shape, fcl.Ellipsoid) else np.hypot(
                0.2 * np.cos(0.4 * k), 0.3 * np.sin(0.4 * k))
            assert 2 - across - 1e-3 <= fcl.distance(here, beside) <= 2 - across + 1e-12
    slab = fcl.Box(8, 8, 1e-3)
    for height, end in ((off, top), (-off, bottom)):
        over = fcl.CollisionObject(slab, fcl.Transform(np.array([0, 0, height])))
        assert 2 - abs(end) - 1e-3 <= fcl.distance(here, over) <= 2 - abs(end) + 1e-12
        time = fcl.continuousCollide(over, fcl.Transform(), here, here.getTransform())
        assert time == pytest.approx((2 - abs(end)) / off, abs=1e-3)


def test_what_meshes_cannot_answer_is_refused():
    for wrong in ((0.0, 1.0), (-1.0, 1.0), (np.nan, 1.0), (1.0, np.inf)):
        with pytest.raises(ValueError, match="Cylinder: sizes"):
            fcl.Cylinder(*wrong)
    with pytest.raises(NotImplementedError, match="enable_signed_distance"):
        fcl.DistanceRequest(enable_signed_distance=True)
    with pytest.raises(NotImplementedError, match="enable_cost"):
        fcl.CollisionRequest(enable_cost=True)
    fcl.ContinuousCollisionRequest(ccd_motion_type=fcl.CCDMotionType.CCDM_LINEAR,
                                   gjk_solver_type=fcl.GJKSolverType.GST_INDEP,
                                   ccd_solver_type=fcl.CCDSolverType.CCDC_CONSERVATIVE_ADVANCEMENT)


def test_managers():
    objects = [put(2.0 * i, 0, 0) for i in range(5)]
    manager, other = fcl.DynamicAABBTreeCollisionManager(), fcl.DynamicAABBTreeCollisionManager()
    manager.registerObjects(objects)
    manager.setup()
    data = fcl.CollisionData()
    manager.collide(data, fcl.defaultCollisionCallback)
    assert not data.result.is_collision
    near = fcl.DistanceData()
    manager.distance(near, fcl.defaultDistanceCallback)
    assert near.result.min_distance == pytest.approx(1)
    # As trimesh asks: one more object, contacts, and the names of geometries by identity.
    data = fcl.CollisionData(request=fcl.CollisionRequest(num_max_contacts=100, enable_contact=True))
    manager.collide(put(2.4, 0.2, 0.1), data, fcl.defaultCollisionCallback)
    assert {id(c.o1) for c in data.result.contacts} == {id(objects[1].geom)}
    other.registerObject(put(100, 3, 0))
    near = fcl.DistanceData()
    manager.distance(other, near, fcl.defaultDistanceCallback)
    assert near.result.min_distance == pytest.approx(np.hypot(91, 2)) and near.result.o1 is objects[4].geom
    # Objects move, come and go.
    objects[0].setTransform(objects[1].getTransform())
    manager.update(objects[0])
    pairs = []
    manager.collide(None, lambda a, b, _: pairs.append((a, b)))
    assert [(a is objects[0], b is objects[1]) for a, b in pairs] == [(True, True)]
    manager.unregisterObject(objects[0])
    data = fcl.CollisionData()
    manager.collide(data, fcl.defaultCollisionCallback)
    assert manager.size() == 4 and not data.result.is_collision
    manager.clear()
    assert manager.empty()


def test_what_is_wrong_is_said():
    with pytest.raises(ValueError, match="no triangles"):
        fcl.BVHModel().endModel()
    with pytest.raises(TypeError, match="CollisionObject"):
        fcl.CollisionObject(3)
    with pytest.raises(ValueError, match="Transform"):
        fcl.Transform(np.eye(4))
    with pytest.raises(TypeError, match="callback"):
        fcl.DynamicAABBTreeCollisionManager().collide()
