"""The plugin in a real PyBullet, which is not changed."""
import ctypes
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

import bullet_ccd.pybullet as ccd_pybullet

sys.path.append(str(Path(__file__).resolve().parents[2] / "benchmarks/reference/bullet"))
import pybullet_scenes as scenes  # noqa: E402
from pybullet_scenes import (PLATE, RING, box, concave, height, shoot, sliding_box,  # noqa: E402
                             steps, write_ring)
from pybullet_situations import DATA, SITUATIONS, play, silence  # noqa: E402

_folder = tempfile.TemporaryDirectory()  # PyBullet is loaded from it while the tests run
try:
    p = scenes.find(Path(_folder.name))
except ImportError as error:
    pytest.skip(str(error), allow_module_level=True)
STARTS = [0.05 + 0.0007 * k for k in range(20)]


@pytest.fixture
def client():
    number = p.connect(p.DIRECT)
    yield number
    if p.isConnected(number):
        p.disconnect(number)


@pytest.fixture
def ccd(client):
    return ccd_pybullet.enable(client)


@pytest.fixture
def ring(tmp_path):
    return write_ring(tmp_path / "ring.obj")


def through(link, client):
    return sum(shoot(p, link, start, client=client) < 0.0 for start in STARTS)


@pytest.mark.parametrize("link", [False, True], ids=["bodies", "links"])
def test_nothing_goes_through_a_thin_plate(client, link):
    assert through(link, client) == 20  # stock: the scene is one that fails
    plugin = ccd_pybullet.enable(client)
    assert through(link, client) == 0
    assert plugin.counters.impacts > 0
    assert plugin.counters.unsupported == 0
    plugin.disable()
    assert through(link, client) == 20


def test_load_plugin_takes_the_path_alone(client):
    plugin = p.loadPlugin(str(ccd_pybullet.PLUGIN))
    assert plugin >= 0
    shoot(p)
    assert p.executePluginCommand(plugin, "impacts") > 0
    assert p.executePluginCommand(plugin, "lost_time") > 0
    assert p.executePluginCommand(plugin, "tolerance", floatArgs=[0.001]) == 0
    assert p.executePluginCommand(plugin, "exclude", intArgs=[1, -1]) == 0
    assert p.executePluginCommand(plugin, "reset_counters") == 0
    assert p.executePluginCommand(plugin, "impacts") == 0


@pytest.mark.parametrize("command", ["", "nonsense", "tolerance", "tolerance x", "tolerance -1",
                                     "tolerance nan", "exclude", "exclude 77", "exclude 0 5",
                                     "exclude 0.5", "exclude 1e99", "include 0 0 0", "impacts 3",
                                     "keep_impacts -1", "teleported", "x" * 1000])
def test_wrong_commands_are_refused_with_a_reason(client, ccd, command, capfd):
    box(p, [1, 1, 1])
    assert p.executePluginCommand(ccd.plugin, command) == -1
    assert capfd.readouterr().err.startswith("bullet_ccd: executePluginCommand: ")
    steps(p, 2)


def test_a_step_without_impact_is_stock_bit_for_bit(client):
    def way():
        p.resetSimulation()
        p.setGravity(0, 0, -9.81)
        box(p, [1, 1, 0.1], place=[0, 0, -0.1])
        bodies = [box(p, [0.05, 0.05, 0.05], 1.0, [0.01 * k, 0, 0.0501 + 0.1002 * k])
                  for k in range(4)]
        slider = sliding_box(p, [0.05, 0.05, 0.05], [0.5, 0, 0.052])
        seen = []
        for _ in range(100):
            p.stepSimulation()
            seen += [p.getBasePositionAndOrientation(body) for body in bodies]
            seen.append(p.getJointState(slider, 0)[:2])
        return seen

    stock = way()
    plugin = ccd_pybullet.enable(client)
    assert way() == stock
    assert plugin.counters.impacts == 0


def test_concave_meshes_that_move_meet_each_other(client, ring):
    def drop():
        p.resetSimulation()
        p.setGravity(0, 0, -9.81)
        box(p, [1, 1, 0.1], place=[0, 0, -0.1])
        rings = [concave(p, ring, 0.5, [0.003 * k, 0, RING + 0.06 * k]) for k in range(3)]
        small = concave(p, ring, 0.1, [0, 0, 0.3], scale=(0.3, 0.3, 1))
        steps(p, 480)
        return rings, small

    rings, small = drop()
    assert not p.getContactPoints(rings[0], rings[1])
    assert all(height(p, body) < 1.5 * RING for body in rings)  # stock: in one another
    ccd_pybullet.enable(client)
    rings, small = drop()
    for k, body in enumerate(rings):
        assert abs(height(p, body) - (2 * k + 1) * RING) < 0.003
    assert abs(height(p, small) - RING) < 0.003  # through the holes of all three
    for k in (0, 1):
        contacts = p.getContactPoints(rings[k], rings[k + 1])
        assert contacts
        assert not p.getContactPoints(rings[k], rings[k + 1], linkIndexA=0)
        for contact in contacts:
            assert (contact[1], contact[2], contact[3], contact[4]) == (rings[k], rings[k + 1], -1, -1)
            assert abs(contact[5][2] - 2 * (k + 1) * RING) < 0.004
            assert 0.045 < max(abs(contact[5][0]), abs(contact[5][1])) < 0.11  # not in the hole
            assert abs(contact[7][2]) > 0.99


URDF = """<robot name="arm">
<link name="post"><inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>
</inertial></link>
{links}</robot>"""
URDF_LINK = """<link name="{name}"><inertial><origin xyz="0.1 0 0"/><mass value="0.2"/>
<inertia ixx="1e-4" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0.1 0 0"/><geometry>{shape}</geometry></collision></link>
<joint name="to_{name}" type="revolute"><parent link="{parent}"/><child link="{name}"/>
<origin xyz="{reach} 0 0"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="0" velocity="99"/>
</joint>"""


@pytest.mark.parametrize("shape", ["box", "mesh"])
def test_contacts_of_a_urdf_name_its_links(client, tmp_path, ring, shape):
    geometry = ('<box size="0.18 0.02 0.001"/>' if shape == "box" else
                f'<mesh filename="{ring}" scale="0.9 0.1 0.025"/>')
    links = [URDF_LINK.format(name=name, parent=parent, reach=reach, shape=geometry)
             for name, parent, reach in (("upper", "post", 0), ("lower", "upper", 0.2))]
    path = tmp_path / "arm.urdf"
    path.write_text(URDF.format(links="".join(links)))

    def swing():
        """At 25 rad/s onto a mesh or a box of 0.5 mm under the second link; its lowest point."""
        p.resetSimulation()
        arm = p.loadURDF(str(path), [0, 0, 0.1], useFixedBase=True)
        plate = (concave(p, ring, 0, [0.3, 0, 0], (1, 1, PLATE / RING)) if shape == "mesh" else
                 box(p, [0.1, 0.1, PLATE], place=[0.3, 0, 0]))
        for joint in (0, 1):
            p.setJointMotorControl2(arm, joint, p.VELOCITY_CONTROL, force=0)
        p.resetJointState(arm, 0, 0.0, 25.0)
        lowest, contacts = 1.0, []
        for _ in range(12):
            p.stepSimulation()
            lowest = min(lowest, p.getLinkState(arm, 1)[0][2])
            contacts += p.getContactPoints(arm, plate)
        return lowest, contacts

    assert swing()[0] < -0.01
    plugin = ccd_pybullet.enable(client)
    lowest, contacts = swing()
    assert lowest > 0.0
    assert {contact[3] for contact in contacts} == {1}
    assert {contact[4] for contact in contacts} == {-1}
    for contact in contacts:
        assert abs(contact[6][2]) < 0.003
        assert 0.19 < contact[6][0] < 0.41
    impacts = plugin.take_impacts()
    assert {(i.body_a, i.link_a, i.body_b, i.link_b) for i in impacts} <= {(0, 1, 1, -1),
                                                                          (1, -1, 0, 1)}
    assert impacts


def test_constraints_hold_through_an_impact(client):
    def swing():
        """A thin box on a stiff string, shot sideways at a thin wall."""
        p.resetSimulation()
        box(p, [PLATE, 0.1, 0.1], place=[0.05, 0, 0])
        body = box(p, [0.0005, 0.01, 0.01], 0.1)
        p.createConstraint(body, -1, -1, -1, p.JOINT_POINT2POINT, [0, 0, 0], [0, 0, 0.5], [0, 0, 0.5])
        p.resetBaseVelocity(body, [20, 0, 0])
        steps(p, 3)
        place, turn = p.getBasePositionAndOrientation(body)
        pivot = p.multiplyTransforms(place, turn, [0, 0, 0.5], [0, 0, 0, 1])[0]
        return place[0], sum((a - b) ** 2 for a, b in zip(pivot, (0, 0, 0.5))) ** 0.5

    assert swing()[0] > 0.06
    ccd_pybullet.enable(client)
    reached, off = swing()
    assert reached < 0.05
    assert off < 0.1  # the action holds a body for the rest of a step, so the string gives a little


def test_impacts_come_as_a_list(ccd):
    box(p, [0.3, 0.3, PLATE])
    body = box(p, [0.01, 0.01, 0.0005], 0.1, [0, 0, 0.05])
    p.changeDynamics(body, -1, linearDamping=0)
    p.resetBaseVelocity(body, [0, 0, -10])
    steps(p, 5)
    impacts = ccd.take_impacts()
    assert len(impacts) == ccd.counters.impacts and ccd.lost_impacts == 0
    first = impacts[0]
    gap = 0.05 - 0.0005 - PLATE
    assert (gap - ccd.tolerance) / 10.0 - 1e-6 < first.time < gap / 10.0
    assert sorted([(first.body_a, first.link_a), (first.body_b, first.link_b)]) == [(0, -1), (1, -1)]
    down = -1.0 if first.body_a == 1 else 1.0
    assert first.normal == pytest.approx((0, 0, down), abs=1e-6)
    plate_point = first.point_b if first.body_a == 1 else first.point_a
    assert plate_point[2] == pytest.approx(PLATE, abs=1e-6)
    assert ccd.take_impacts() == []
    ccd.keep_impacts(0)
    shoot(p)
    assert ccd.take_impacts() == [] and ccd.lost_impacts == ccd.counters.impacts > 0


def test_settings_and_counters(ccd):
    assert ccd.tolerance == 2e-4
    ccd.tolerance = 1e-3
    for wrong in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="tolerance"):
            ccd.tolerance = wrong
    shoot(p)
    assert ccd.tolerance == 1e-3  # after a reset
    assert ccd.counters.impacts > 0 and ccd.counters.lost_time > 0.0
    ccd.reset_counters()
    assert ccd.counters.impacts == 0 and ccd.counters.lost_time == 0.0


def test_excluded_bodies_are_left_to_pybullet(ccd):
    box(p, [0.3, 0.3, PLATE])

    def shot():
        body = box(p, [0.01, 0.01, 0.0005], 0.1, [0, 0, 0.05])
        p.resetBaseVelocity(body, [0, 0, -20])
        return body

    for _ in range(20):  # each may be made where the one before was
        excluded = shot()
        ccd.exclude(excluded)
        steps(p, 5)
        assert height(p, excluded) < 0.0
        p.removeBody(excluded)
        covered = shot()
        steps(p, 5)
        assert height(p, covered) > 0.0
        p.removeBody(covered)


def test_teleports_are_jumps(ccd):
    box(p, [0.3, 0.3, PLATE])
    body = box(p, [0.01, 0.01, 0.0005], 0.1, [0, 0, 0.05])
    link = sliding_box(p, [0.1, 0.005, 0.0005], [0.2, 0, 0.05])
    steps(p, 3)
    p.resetBasePositionAndOrientation(body, [0, 0, -0.05], [0, 0, 0, 1])
    p.resetJointState(link, 0, 0.1)
    steps(p, 3)
    assert height(p, body) == pytest.approx(-0.05, abs=1e-6)
    assert p.getLinkState(link, 0)[0][2] == pytest.approx(-0.05, abs=1e-6)


def test_saved_states_are_restored(ccd, ring):
    def run():
        seen = []
        for _ in range(40):
            p.stepSimulation()
            seen.append([p.getBasePositionAndOrientation(body) for body in (1, 2, 3)])
        return seen

    p.setGravity(0, 0, -9.81)
    box(p, [0.3, 0.3, PLATE])
    box(p, [0.01, 0.01, 0.0005], 0.1, [0.2, 0, 0.05])
    concave(p, ring, 0.5, [0, 0, RING + 0.01])
    concave(p, ring, 0.5, [0, 0, 3 * RING + 0.02])
    p.resetBaseVelocity(1, [0, 0, -20])
    state = p.saveState()
    first = run()
    assert ccd.counters.impacts > 0
    for _ in range(3):
        p.restoreState(state)
        again = run()
        assert all(a[0] == pytest.approx(b[0], abs=1e-4) for x, y in zip(first, again)
                   for a, b in zip(x, y))
        assert height(p, 1) > 0.0
    p.removeState(state)


def test_a_load_after_bodies_exist(client, ring):
    """Pairs that had PyBullet's algorithms get ours: rings that are in contact already, too."""
    p.setGravity(0, 0, -9.81)
    box(p, [1, 1, 0.1], place=[0, 0, -0.1])
    low, high = (concave(p, ring, 0.5, [0, 0, z]) for z in (RING + 0.001, 3 * RING + 0.005))
    slider = sliding_box(p, [0.05, 0.05, 0.05], [0.5, 0, 0.06])
    p.stepSimulation()
    plugin = ccd_pybullet.enable(client)
    steps(p, 100)
    assert abs(height(p, high) - 3 * RING) < 0.003
    assert p.getContactPoints(low, high)
    plugin.disable()  # while they touch
    steps(p, 100)
    assert height(p, high) < 1.5 * RING  # stock again
    assert p.getJointState(slider, 0)[0] > 0.0
    plugin = ccd_pybullet.enable(client)  # they intersect now
    steps(p, 10)
    p.removeBody(low)
    steps(p, 10)


def test_bodies_come_and_go(ccd, ring):
    p.setGravity(0, 0, -9.81)
    box(p, [1, 1, 0.1], place=[0, 0, -0.1])
    for k in range(30):
        bodies = [concave(p, ring, 0.5, [0, 0, 0.03 + 0.05 * i]) for i in range(2)]
        bodies.append(sliding_box(p, [0.02, 0.02, 0.001], [0, 0, 0.2]))
        p.resetJointState(bodies[-1], 0, 0, 20.0)
        steps(p, 4)
        for body in bodies[::-1] if k % 2 else bodies:
            p.removeBody(body)
        p.stepSimulation()
    assert ccd.counters.impacts > 0


def crowd(client, ring):
    p.resetSimulation(physicsClientId=client)
    p.setGravity(0, 0, -9.81, physicsClientId=client)
    box(p, [1, 1, 0.1], place=[0, 0, -0.1], client=client)
    for k in range(2):
        concave(p, ring, 0.5, [0, 0, 0.021 + 0.042 * k], client=client)
    slider = sliding_box(p, [0.01, 0.01, 0.001], [0.3, 0, 0.05], client=client)
    p.resetJointState(slider, 0, 0, 20.0, physicsClientId=client)
    steps(p, 3, client)


def memory():
    """What this process has in memory [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def grows(again, count):
    """Whether memory grows in each third of many runs. The heap itself grows by steps, now and then."""
    seen = [memory()]
    for _ in range(3):
        for _ in range(count // 3):
            again()
        seen.append(memory())
    return min(b - a for a, b in zip(seen, seen[1:])) > 1e6


def test_many_resets(client, ccd, ring):
    for _ in range(20):
        crowd(client, ring)
        assert ccd.counters.impacts > 0
    if os.environ.get("BULLET_CCD_LONG_TESTS"):
        assert not grows(lambda: crowd(client, ring), 1000)  # a crowd is more than 100 kB


def test_many_clients_one_after_the_other(ring):
    def come_and_go():
        client = p.connect(p.DIRECT)
        plugin = ccd_pybullet.enable(client)
        crowd(client, ring)
        assert plugin.counters.impacts > 0
        p.disconnect(client)
        with pytest.raises(RuntimeError, match="disconnected"):
            plugin.counters

    for _ in range(20):
        come_and_go()
    if os.environ.get("BULLET_CCD_LONG_TESTS"):
        assert not grows(come_and_go, 300)


@pytest.mark.parametrize("way", ["disconnect", "unload, disconnect", "reset, disconnect",
                                 "reset, unload, reset, disconnect", "off, load, disconnect",
                                 "load, load, disconnect", "off, reset, load, off, disconnect",
                                 "off, unload, disconnect"])
def test_every_order_of_the_end(client, ring, way):
    plugin = ccd_pybullet.enable(client)
    crowd(client, ring)
    for what in way.split(", "):
        if what == "unload":
            p.unloadPlugin(plugin.plugin, physicsClientId=client)
            with pytest.raises(RuntimeError, match="unloaded"):
                plugin.counters
        elif what == "off":
            plugin.disable()
            with pytest.raises(RuntimeError, match="disabled"):
                plugin.counters
        elif what == "load":
            plugin = ccd_pybullet.enable(client)
        elif what == "reset":
            p.resetSimulation(physicsClientId=client)
        else:
            p.disconnect(client)
        if what != "disconnect":
            crowd(client, ring)


@pytest.mark.parametrize("first", [0, 1])
def test_two_clients(ring, first):
    clients = [p.connect(p.DIRECT) for _ in range(2)]
    plugins = [ccd_pybullet.enable(client) for client in clients]
    plugins[1].tolerance = 1e-3
    for _ in range(2):
        for client in clients:
            crowd(client, ring)
    assert plugins[0].tolerance == 2e-4
    plugins[0].reset_counters()
    assert plugins[1].counters.impacts > 0
    p.disconnect(clients[first])
    crowd(clients[1 - first], ring)
    assert plugins[1 - first].counters.impacts > 0
    p.disconnect(clients[1 - first])


def test_a_client_without_the_plugin_is_stock_beside_one_with_it(client, ccd):
    other = p.connect(p.DIRECT)
    assert shoot(p, client=client) > 0.0
    assert shoot(p, client=other) < 0.0
    p.disconnect(other)


def test_a_second_path_to_the_plugin_is_refused(client, ccd, tmp_path, capfd):
    link = tmp_path / "another.so"
    link.symlink_to(ccd_pybullet.PLUGIN)
    assert p.loadPlugin(str(link)) < 0
    assert "this client has it already" in capfd.readouterr().err
    assert shoot(p) > 0.0
    assert ccd_pybullet.enable(client).plugin == ccd.plugin


def test_other_versions_are_refused(client, monkeypatch, capfd):
    monkeypatch.setattr(p, "getAPIVersion", lambda: 201904040)
    with pytest.raises(RuntimeError, match="did not load"):
        ccd_pybullet.enable(client)
    assert "201904040, and only 202010061" in capfd.readouterr().err
    assert shoot(p) < 0.0
    monkeypatch.delattr(p, "getAPIVersion")
    assert p.loadPlugin(str(ccd_pybullet.PLUGIN)) < 0
    assert shoot(p) < 0.0


def test_other_hosts_are_refused(capfd):
    context = (ctypes.c_char * 256)()
    assert ctypes.PyDLL(str(ccd_pybullet.PLUGIN)).initPlugin(context) == -1
    assert "does not own its simulation" in capfd.readouterr().err
    # A window's simulation runs in a thread that is none of Python's; so does this call.
    assert ctypes.CDLL(str(ccd_pybullet.PLUGIN)).initPlugin(context) == -1
    assert "no p.DIRECT client" in capfd.readouterr().err


def test_worlds_with_deformable_bodies_are_covered_for_the_others(client, ccd):
    p.resetSimulation(p.RESET_USE_DEFORMABLE_WORLD)
    box(p, [0.3, 0.3, PLATE])
    body = box(p, [0.01, 0.01, 0.0005], 0.1, [0, 0, 0.05])
    p.resetBaseVelocity(body, [0, 0, -20])
    steps(p, 30)
    assert height(p, body) > 0.0
    p.resetSimulation()
    assert shoot(p) > 0.0


def run(program):
    """In a process of its own, because PyBullet prints and starts threads."""
    return subprocess.run(
        [sys.executable, "-c", "import pybullet as p, bullet_ccd.pybullet as c, "
         "pybullet_scenes as s\n" + program], capture_output=True, text=True, timeout=100,
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)))


def test_programs_may_end_without_a_word():
    ended = run("k = c.enable(p.connect(p.DIRECT))\ns.shoot(p)\nc.enable(p.connect(p.DIRECT))")
    assert ended.returncode == 0, ended.stderr


def test_servers_are_refused():
    """Their simulation runs in a thread, as that of a window does."""
    ended = run(f"k = p.connect(p.SHARED_MEMORY_SERVER, {os.getpid()})\nassert k >= 0\n"
                "try:\n    c.enable(k)\nexcept RuntimeError:\n"
                "    assert s.shoot(p, client=k) < 0\n    p.disconnect(k)\n    print('refused')")
    assert ended.returncode == 0, ended.stderr
    assert "this is no p.DIRECT client" in ended.stderr
    assert "refused" in ended.stdout


def test_the_library_shows_nothing_but_its_functions():
    names = subprocess.run(["nm", "-D", "--defined-only", str(ccd_pybullet.PLUGIN)],
                           capture_output=True, text=True, check=True).stdout.split()[2::3]
    assert sorted(names) == ["bulletCcdCounters", "bulletCcdTakeImpacts", "executePluginCommand",
                             "exitPlugin", "initPlugin", "postTickPluginCallback",
                             "preTickPluginCallback"]


@pytest.mark.parametrize("title", [t for t, (_, _, must_be_zero) in SITUATIONS.items() if must_be_zero])
def test_nothing_that_must_not_be_there_is_there(title, tmp_path):
    situation, files, _ = SITUATIONS[title]
    if files is not None and not (DATA / files).is_dir():
        pytest.skip(f"{DATA / files} is not there")
    with silence():
        count, _, impacts = play(p, ccd_pybullet.enable, situation, tmp_path)
    assert count == 0
    assert impacts > 0 or title == "Panda picks a box"
