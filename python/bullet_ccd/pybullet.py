"""Continuous collision detection and contacts of concave meshes for PyBullet, by one line:

    import bullet_ccd.pybullet
    ccd = bullet_ccd.pybullet.enable()            # of the p.DIRECT client 0

PyBullet itself is not changed. Limits: p.DIRECT clients only, and what p.resetJointState and
p.resetBasePositionAndOrientation do is a jump, in which nothing is swept.
"""
from __future__ import annotations

import ctypes
import importlib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, List, Tuple

__all__ = ["Ccd", "Counters", "Impact", "PLUGIN", "enable"]

#: The plugin that p.loadPlugin() takes.
PLUGIN = Path(__file__).resolve().with_name("libbullet_ccd_pybullet.so")

Vector = Tuple[float, float, float]


def _host() -> Any:
    """PyBullet, which is imported where it is needed only."""
    return importlib.import_module("pybullet")


@dataclass(frozen=True)
class Counters:
    """Counts since the world was made, which p.resetSimulation() does anew, or reset_counters()."""

    queries: int           #: pairs whose time of impact was asked for
    impacts: int           #: pairs that came too near
    clamps: int            #: bodies that were held for the rest of a step
    overlaps: int          #: pairs left to PyBullet's contacts, because they intersected already
    event_limits: int      #: impacts of bodies that had met their limit in a step
    settled: int           #: bodies that lost their spin and approach, because they were stuck
    iteration_limits: int  #: queries that gave up; their bodies were held
    unsupported: int       #: shapes that were not covered in the last step
    lost_time: float       #: motion that held bodies missed, summed over them [s]


@dataclass(frozen=True)
class Impact:
    """Two bodies or links that were stopped where they met."""

    time: float  #: simulated time since the plugin was loaded or the simulation was reset [s]
    body_a: int  #: body unique id
    link_a: int  #: link index; -1 is the base
    body_b: int
    link_b: int
    point_a: Vector  #: closest points at that time, in the world [m]
    point_b: Vector
    normal: Vector   #: unit, from A to B


class Ccd:
    """The plugin in one client. Methods raise RuntimeError while it is disabled and once the client has
    disconnected."""

    _NUMBERS_OF_AN_IMPACT = 14

    def __init__(self, client: int, plugin: int) -> None:
        self.client = client
        #: What p.executePluginCommand() and p.unloadPlugin() take.
        self.plugin = plugin
        # The library that PyBullet has opened. PyDLL keeps Python's lock, which guards it.
        self._library = ctypes.PyDLL(str(PLUGIN))
        self._session = self._execute("session")

    def __repr__(self) -> str:
        return f"Ccd(client={self.client}, plugin={self.plugin})"

    @property
    def counters(self) -> Counters:
        """What was done since the world was made."""
        numbers = self._numbers()
        names = [field.name for field in fields(Counters)]
        counts = {name: int(number) for name, number in zip(names[:-1], numbers)}
        return Counters(**counts, lost_time=numbers[len(names) - 1])

    def reset_counters(self) -> None:
        """Lets all counters begin at zero."""
        self._execute("reset_counters")

    @property
    def tolerance(self) -> float:
        """Distance at which shapes other than meshes count as touching [m]. Choose 1/1000 to 1/100
        of the smallest thing in the world. It outlives p.resetSimulation()."""
        return self._numbers()[-2]

    @tolerance.setter
    def tolerance(self, metres: float) -> None:
        if not 0.0 < metres < float("inf"):
            raise ValueError(f"tolerance: {metres} is not a positive length")
        self._execute(f"tolerance {metres!r}")

    def exclude(self, body: int, link: int = -1) -> None:
        """Leaves a body's base or link to stock PyBullet, until include() or p.removeBody()."""
        self._execute(f"exclude {int(body)} {int(link)}")

    def include(self, body: int, link: int = -1) -> None:
        """Takes back exclude()."""
        self._execute(f"include {int(body)} {int(link)}")

    def teleported(self, body: int) -> None:
        """Call it for a kinematic body that was put elsewhere and did not move there."""
        self._execute(f"teleported {int(body)}")

    def keep_impacts(self, count: int) -> None:
        """How many impacts wait for take_impacts() at most (10,000 unless told). Later ones are
        counted only (lost_impacts)."""
        self._execute(f"keep_impacts {int(count)}")

    @property
    def lost_impacts(self) -> int:
        """Impacts that were not kept, because too many waited."""
        return int(self._numbers()[-1])

    def take_impacts(self) -> List[Impact]:
        """The impacts since the last call, oldest first."""
        taken: List[Impact] = []
        width, most = self._NUMBERS_OF_AN_IMPACT, 1000
        rows = (ctypes.c_double * (width * most))()
        while True:
            count = int(self._library.bulletCcdTakeImpacts(self._session, rows, most))
            self._check(count)
            for i in range(count):
                row = rows[i * width:(i + 1) * width]
                taken.append(Impact(row[0], int(row[1]), int(row[2]), int(row[3]), int(row[4]),
                                    (row[5], row[6], row[7]), (row[8], row[9], row[10]),
                                    (row[11], row[12], row[13])))
            if count < most:
                return taken

    def disable(self) -> None:
        """The client goes on with stock PyBullet, until enable() is called for it again.

        The plugin stays loaded: PyBullet 3.2.7 crashes when any plugin is loaded after one has been
        unloaded (p.unloadPlugin)."""
        self._execute("off")

    def _execute(self, command: str) -> int:
        result = int(_host().executePluginCommand(self.plugin, command,
                                                  physicsClientId=self.client))
        if result < 0:
            raise RuntimeError(f"bullet_ccd.pybullet: \"{command}\" failed; the reason is on the "
                               "standard error output")
        return result

    def _numbers(self) -> List[float]:
        count = len(fields(Counters)) + 2
        numbers = (ctypes.c_double * count)()
        self._check(int(self._library.bulletCcdCounters(self._session, numbers, count)))
        return list(numbers)

    @staticmethod
    def _check(result: int) -> None:
        if result < 0:
            raise RuntimeError("bullet_ccd.pybullet: it was disabled, the plugin was unloaded, the "
                               "client has disconnected, or its world does not fit")


def enable(client: Any = 0) -> Ccd:
    """Loads the plugin into a client: its number, or a BulletClient of pybullet_utils.

    It may be loaded before or after bodies are made, and stays when the simulation is reset. A second
    call for a client returns another handle of the same plugin. Raises RuntimeError where PyBullet
    refuses the plugin; the standard error output says why.
    """
    number = int(getattr(client, "_client", client))
    if not PLUGIN.is_file():
        raise RuntimeError(f"{PLUGIN} is not there; build the target bullet_ccd_pybullet")
    plugin = int(_host().loadPlugin(str(PLUGIN), physicsClientId=number))
    if plugin < 0:
        raise RuntimeError("PyBullet did not load the plugin; the reason is on the standard error "
                           "output")
    ccd = Ccd(number, plugin)
    ccd._execute("on")
    return ccd
