"""A kiln that is ordered about, breaks down and loses its power, and what its EEPROM then holds."""

from collections.abc import Callable, Iterator
from random import Random
from typing import NamedTuple

from rig.firmware import changed, spec_of, whole
from storage_format import OVER, Progress, Segment

from heatwright.sim.binary.elf import Elf
from heatwright.sim.coupling import Coupling
from heatwright.sim.device import AvrDevice
from heatwright.sim.faults.bounds import checks_s
from heatwright.sim.plants import plant_of
from heatwright.spec import Controller
from heatwright.spec.scenario.program_orders import Order

STORED = """\
  stored:
    - name: quick
      segments:
        - {to: 60 °C, over: 1 min}
        - {hold: 30 s}
        - {to: 90 °C, at: 2000 K/h}
        - {to: 50 °C, at: as fast as possible}
        - {hold: until operator}
        - {to: 40 °C, over: 2 min}
    - name: slow
      segments:
        - {hold: 20 s}
        - {to: 150 °C, at: 900.5 K/h}
        - {to: 30 °C, over: 1 h}

"""
LOOP = "chamber"
Newest = Callable[[bytes], Progress | None]  # finds the newest record in an EEPROM
STEP_S = 0.1
START_S = 0.09
"""In which the start is over, but for what the controller checks of itself; the first step comes
later."""
IDLE, RUNNING, PAUSED, RETURNING, RESTORING, INTERRUPTED = range(6)
KEYS = ("up", "down", "left", "right", "select")
PLAYED = 0.2  # share of all that is done at the keys
EDIT, GAINS = "edit", "gains"
UNSAVED = ("program_crc", "temperature_c")  # what is not a member of `program`


def machine(example: str = "kiln", *, otherwise: str = "stop") -> tuple[Controller, Elf]:
    """A kiln of the examples, with shorter programs; what it does when it is too cold."""
    text = with_programs(example, STORED, ("otherwise: stop", f"otherwise: {otherwise}"))
    return spec_of(text).controller, whole(text)


def with_programs(example: str, stored: str, *changes: tuple[str, str]) -> str:
    before, _, rest = changed(example, *changes).partition("  stored:\n")
    return before + stored + "safety:" + rest.partition("safety:")[2]


class Seen(NamedTuple):
    """What the program was at a time; its record's CRC is not known."""

    time_s: float
    record: Progress


class Edit(NamedTuple):
    """A program that the display has sent."""

    time_s: float
    segments: tuple[Segment, ...]


class Cut(NamedTuple):
    """The power is cut: what the EEPROM then holds, and what went before."""

    time_s: float
    image: bytes
    felt_c: float
    seen: tuple[Seen, ...]  # since the power came on
    found: Progress | None  # what the EEPROM held when it came on
    torn: bool  # a byte was being written


def state_of(device: AvrDevice, controller: Controller) -> Progress:
    """The program as it is in RAM, with the temperature that its record takes."""
    program = device.read("program")
    values = {name: program[name].item() for name in Progress._fields if name not in UNSAVED}
    programs = controller.programs
    assert programs is not None
    keeps = programs.on_fault == "pause"
    place = "program.before_c" if keeps else f"loop_{LOOP}.temperature_c"
    temperature_c = device.read(place).item()
    return Progress(**values, program_crc=0, temperature_c=temperature_c)


class Firing:
    """One run, with cuts of which the controller learns nothing, and now and then a real one."""

    def __init__(self, controller: Controller, program: Elf, seed: int, newest: Newest) -> None:
        self._random = Random(seed)  # noqa: S311
        self._newest = newest
        self.controller = controller
        self.device = AvrDevice(controller, program)
        simulation = controller.simulated
        self._plant = plant_of(
            controller, simulation.plant, ambient_c=simulation.ambient_c, step_s=STEP_S, seed=seed
        )
        self._coupling = Coupling(controller, self.device, STEP_S)
        self._start_s = START_S + checks_s(controller, program)
        self._row = 0
        self._jump_rows = 0
        self.edits: dict[int, list[Edit]] = {1: [], 2: [], 3: []}
        """What the display has sent for each place, one after the other."""
        self._power_on(None)

    def _power_on(self, found: Progress | None) -> None:
        self._seen: list[Seen] = []
        self._found = found
        self._on_s = self.device.time_s

    def _note(self) -> None:
        if self.device.time_s - self._on_s < self._start_s:
            return  # the memory is still as the power-up leaves it
        record = state_of(self.device, self.controller)
        if not self._seen or self._seen[-1].record != record:
            self._seen.append(Seen(self.device.time_s, record))

    @property
    def felt_c(self) -> float:
        return self._plant.sensed_c()[LOOP] + 100.0 * (self._jump_rows > 0)

    def cuts(self, rows: int, *, busy: float, quiet: float) -> Iterator[Cut]:
        """Go on for so many steps of time; cut as often while something is written, and else."""
        for _ in range(rows):
            before = self.device.avr.eeprom.writes
            self._act()
            yield from self._row_with(busy if self._writes else quiet)
            self._writes = self.device.avr.eeprom.writes != before

    _writes = False

    def _row_with(self, share: float) -> Iterator[Cut]:
        self._row += 1
        end_s = self._row * STEP_S
        self.device.sense(LOOP, self.felt_c)
        if self._random.random() < share:
            self.device.advance(end_s - STEP_S * self._random.random())
            yield self._cut()
        self.device.advance(end_s)
        self._note()
        self._plant.step(self._coupling.supplied(self._coupling.active()), 0.0)
        self._jump_rows = max(0, self._jump_rows - 1)

    def _cut(self) -> Cut:
        eeprom = self.device.avr.eeprom
        torn = eeprom.writing is not None
        image = eeprom.after_power_cut(self._random.randrange(256))
        self._note()
        return Cut(self.device.time_s, image, self.felt_c, tuple(self._seen), self._found, torn)

    def _act(self) -> None:
        random = self._random
        state = self._seen[-1].record.state if self._seen else IDLE
        if random.random() < STEP_S / 90.0:
            self.lose_power()
        elif random.random() < STEP_S / 120.0:
            self._jump_rows = 15
        elif random.random() < STEP_S / 8.0:
            self._operate(state)

    def _operate(self, state: int) -> None:
        random = self._random
        jump = f"#10 {random.randint(1, 6)};"
        orders = {
            IDLE: ["#8 1;", "#8 2;", "#8 3;", "#16;", "#16;", EDIT, EDIT],
            RUNNING: ["#9 0;", "#18;", jump, "#17;", EDIT, GAINS],
            PAUSED: ["#9 1;", "#9 1;", jump, "#17;", GAINS],
            INTERRUPTED: ["#16;", "#16;", "#9 1;", "#9 1;", "#9 1;", jump, "#17;"],
        }
        order = random.choice(orders.get(state, ["#9 0;", "#17;"]))
        self.device.send({EDIT: self._edit, GAINS: self._gains}.get(order, lambda: order)())

    def _edit(self) -> str:
        """Another program at one of the places, on the display."""
        place, points = self._random.randint(1, 3), self._random.randint(1, 10)
        minutes = [self._random.randint(1, 3) for _ in range(points)]
        ways = "".join(f"{n},{each},{9 * n + 30}:" for n, each in enumerate(minutes, start=1))
        segments = [Segment(OVER, 90 * n + 300, 60 * m) for n, m in enumerate(minutes, start=1)]
        self.edits[place].append(Edit(self.device.time_s, tuple(segments)))
        return f"#13 {place};#7 {ways}{f'{points + 1},0,0:' * (points < 10)};"

    def _gains(self) -> str:
        return f"#5 {self._random.randint(1, 9)};#22;#20 {self._random.randint(500, 1100)};"

    def lose_power(self) -> None:
        undefined = self._random.randrange(256)
        image = self.device.avr.eeprom.after_power_cut(undefined)
        self.device.power_cycle(undefined)
        self._power_on(self._newest(image))


class FiringByKeys(Firing):
    """The same with keys: orders through the menu, and now and then somebody who plays with it."""

    def _operate(self, state: int) -> None:
        random = self._random
        orders: dict[int, list[tuple[Order, int]]] = {
            IDLE: [("start", 1), ("start", 2)],
            RUNNING: [("pause", 0), ("skip", 0), ("jump", random.randint(1, 6)), ("stop", 0)],
            PAUSED: [("resume", 0), ("resume", 0), ("jump", random.randint(1, 6)), ("stop", 0)],
        }
        if self.device.read("fault.code"):
            self.device.shield.play(["select"])
        elif random.random() < PLAYED:
            self.device.shield.play(random.choices(KEYS, k=random.randint(1, 8)))
        else:
            self.device.program(*random.choice(orders.get(state, [("stop", 0)])))
