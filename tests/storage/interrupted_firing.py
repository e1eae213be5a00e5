"""A kiln on this computer that fires, is struck by faults and power cuts, and is ordered about."""

from random import Random
from typing import NamedTuple

from host_specs import build_of_spec
from rig.firmware import spec_of
from storage_firing import IDLE, INTERRUPTED, LOOP, PAUSED, with_programs

from heatwright.sim.host import Command, Host
from heatwright.sim.plants import Plant, plant_of
from heatwright.sim.reference.programs import state as orders
from heatwright.spec import Spec

STORED = """\
  stored:
    - name: up
      segments:
        - {to: 90 °C, at: 700 K/h}
        - {hold: 40 s}
        - {to: 150 °C, over: 5 min}
        - {to: 170 °C, at: as fast as possible}
        - {hold: 3 min}
        - {to: 165 °C, over: 4 min}
        - {hold: until operator}
    - name: slow
      segments:
        - {hold: 1 min}
        - {to: 500 °C, at: 520.5 K/h}
        - {to: 400 °C, over: 1 h}

"""
SENSOR_CODES = (1, 2, 3, 4, 5)
PER_KELVIN = 128
PERIOD_TICKS = 100
LEAST_C, MOST_C = -200.0, 1300.0
LONGEST_DEAD_S = 900
LONGEST_RECORDS = 120  # bytes, and some more, that are written in a period


def spec_for(otherwise: str, on_fault: str = "pause") -> Spec:
    """The kiln of the examples with programs of minutes."""
    changes = (
        ("otherwise: stop", f"otherwise: {otherwise}"),
        ("on_fault: pause", f"on_fault: {on_fault}"),
    )
    return spec_of(with_programs("kiln", STORED, *changes))


class Instant(NamedTuple):
    time_s: int
    image: bytes
    felt_c: float
    powered: bool


class Kiln:
    """The generated C of the kiln, and the machine that its specification describes.

    stops -- how often a firing was told to stop, of all kilns that there have been.
    """

    def __init__(self, spec: Spec, seed: str) -> None:
        self.random = Random(f"interrupted {seed}")  # noqa: S311 - no secret
        self._spec = spec
        self.host = Host(build_of_spec(spec, sanitized=False))
        self.time_s, self.seen = 0, list[Instant]()
        self.dead = False
        self.stops = 0
        self._lies: list[float | int] = []
        self._image, self._writes = b"", -1
        self.renew()

    def renew(self) -> None:
        controller, simulation = self._spec.controller, self._spec.controller.simulated
        ambient_c = self.random.uniform(10, 35)
        self._plant: Plant = plant_of(
            controller, simulation.plant.model_copy(update={"initial_c": ambient_c}),
            ambient_c=ambient_c, step_s=1.0,
        )  # fmt: skip
        self.host.renew()
        self._counts, self._writes = 0, -1
        self.dead, self._lies = False, []

    @property
    def felt_c(self) -> float:
        return self._plant.sensed_c()[LOOP]

    @property
    def state(self) -> int:
        return int(self.host.library.program.state)

    @property
    def fault(self) -> int:
        return int(self.host.library.fault.code)

    def run(self, periods: int) -> None:
        for _ in range(periods):
            self._read()
            counts = int(self.host.run(self.host._input).heater_counts[0])
            self._forget_orders()
            share = (counts - self._counts) / PERIOD_TICKS
            self._counts = counts
            self._pass(0.0 if self.dead else share, powered=True)

    def _read(self) -> None:
        lie = self._lies.pop(0) if self._lies else 0.0
        if isinstance(lie, int):
            self.host.set_reading(lie, 0)
        else:
            read_c = min(max(self.felt_c + lie, LEAST_C), MOST_C)
            self.host.set_reading(0, round(read_c * PER_KELVIN))

    def _forget_orders(self) -> None:
        row = self.host._input
        row["acknowledge"], row["command"], row["order"] = 0, Command.NOTHING, 0

    def _pass(self, share: float, *, powered: bool) -> None:
        self._plant.step({"element": share})
        self.time_s += 1
        writes = int(self.host.world.eeprom_writes)
        if writes != self._writes:
            self._image, self._writes = bytes(self.host.eeprom), writes
        self.seen.append(Instant(self.time_s, self._image, self.felt_c, powered))

    def cut_power(self) -> None:
        """Take the power away in the middle of a write, or not, and give it back after a while."""
        world, random = self.host.world, self.random
        world.writes_left = random.randrange(LONGEST_RECORDS)
        world.torn = random.choice((-1, random.randrange(256)))
        begun = int(world.eeprom_writes)
        for _ in range(random.randrange(1, PERIOD_TICKS)):
            self.host.library.host_tick()
            if world.writes_left == 0 and int(world.eeprom_writes) > begun:
                break
        world.writes_left = world.torn = -1
        self._lies = []
        for _ in range(random.choice((1, 10, random.randrange(1, 900)))):
            self._pass(0.0, powered=False)
        self.host.power_up()
        self._counts = 0

    def lose_sensor(self) -> None:
        self._lies = [self.random.choice(SENSOR_CODES)] * 8
        self.run(8)

    def jump(self) -> None:
        self._lies = [self.random.choice((-1, 1)) * self.random.uniform(11, 600)]
        self.run(1)

    def break_element(self) -> None:
        """It conducts no more, until that is told; stays `dead` where it is not told for long."""
        self.dead = True
        for _ in range(LONGEST_DEAD_S):
            if self.fault:
                self.dead = False
                break
            self.run(1)

    def order(self, order: int, argument: int = 0) -> None:
        self.stops += order == orders.STOP and self.state != IDLE
        self.host.order(order, argument)

    def acknowledge(self) -> None:
        self.host.acknowledge()

    def fire(self) -> None:
        random = self.random
        for _ in range(20):
            if self.state == IDLE:
                self.order(orders.START, random.choice((1, 1, 2)))
            elif self.state == PAUSED:
                self.order(orders.RESUME)
            elif self.state == INTERRUPTED:
                self.order(random.choice((orders.RESUME, orders.STOP)))
            elif random.random() < 0.4:
                skip, jump = (orders.SKIP, 0), (orders.JUMP, random.randint(1, 8))
                self.order(*random.choice((skip, jump)))
            else:
                break
            self.run(random.randint(1, 30))
        self.run(random.randint(1, 240))


def strike(kiln: Kiln) -> bool:
    """One fault in a firing, and what becomes of it; False if nothing was latched."""
    random = kiln.random
    kiln.fire()
    if kiln.state in (IDLE, PAUSED, INTERRUPTED) or kiln.fault:
        kiln.acknowledge()
        return False
    random.choice((kiln.lose_sensor, kiln.jump, *[kiln.break_element] * (random.random() < 0.2)))()
    if not kiln.fault:
        return False
    kiln.run(random.choice((0, 1, 2, random.randrange(150))))
    if random.random() < 0.35:
        kiln.cut_power()
        kiln.run(random.randint(1, 60))
    if random.random() < 0.1:
        kiln.order(orders.STOP)
    kiln.run(random.randrange(3))
    kiln.acknowledge()
    kiln.run(random.choice((1, 5, random.randrange(300))))
    if random.random() < 0.2:
        kiln.cut_power()
        kiln.run(5)
    kiln.acknowledge()
    kiln.run(1)
    kiln.order(random.choice((orders.RESUME, orders.RESUME, orders.RESUME, orders.STOP)))
    kiln.run(random.choice((2, 60, random.randrange(300))))
    return True
