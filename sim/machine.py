"""A plant that is simulated together with its processor: each time step in C, the rest in Python.

The plant is defined in Python (heatwright.sim.plants.thermal_network), which is also the reference
for the C. C works on the plant's own arrays (native/machine.c). It runs step by step, and returns
if a matrix, noise or space in the log is missing, or if a part outside needs records or acts.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.binary.dwarf import Variable
from heatwright.sim.coupling import Coupling
from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.look import NEVER, NO_LOOK
from heatwright.sim.native.shim import load
from heatwright.sim.plants.radiation import LOG_GRID, ZERO_C_K
from heatwright.sim.plants.thermal_network import MOST_STEP_MATRICES, Plant

Array = NDArray[np.float64]
Feel = Callable[[float], float]
"""From the machine's temperature at a sensor to that of its tip, °C."""


class Heat(NamedTuple):
    """Changes the power of a load: from the share that its pin requests to the real share.

    times -- factor; least -- lowest share, also while the pin is off; once_asked -- replaces any
    share above 0.
    """

    times: float = 1.0
    least: float = 0.0
    once_asked: float | None = None


class Beside(NamedTuple):
    """Another heat source at a load's node (share of its power) while a sensor is below a limit."""

    share: float
    sensor: str
    below_c: float


class Stop(NamedTuple):
    """Conditions that end a run of steps early, after the step in which any of them is met.

    changed -- one of these variables has changed; below -- a sensor is below a temperature, °C;
    spread -- no node exceeds its `highest_c` without power; turned -- this load's pin has changed.
    """

    changed: tuple[Variable, ...] = ()
    below: tuple[str, float] | None = None
    spread: bool = False
    turned: str | None = None


SOUND = Heat()
NO_STOP = Stop()
NOTHING: Mapping[str, float] = MappingProxyType({})


LOG_ROWS = 2048
"""Maximum number of steps between two times that the log is emptied."""
WATCHED, SENSED = 1, 2
"""Bits of a row: it counts for the peaks; its temperatures were given to the sensors."""
TIME, BITS, FEED, TIPS = range(4)
"""Columns of a row. After the tips: shares of power of the loads and, if logged, the nodes."""


def install(ffi: Any) -> None:
    """Register the callbacks of the machines with the shim."""

    def hw_machine_sense(handle: Any, sensor: int, felt: float) -> None:
        machine: Machine = ffi.from_handle(handle)
        machine.attempt(machine.tell, sensor, felt)

    def hw_machine_fed(handle: Any) -> float:
        machine: Machine = ffi.from_handle(handle)
        return machine.attempt(machine.fed) or 0.0

    def hw_machine_feel(handle: Any) -> None:
        machine: Machine = ffi.from_handle(handle)
        machine.attempt(machine.feel)

    ffi.def_extern()(hw_machine_sense)
    ffi.def_extern()(hw_machine_fed)
    ffi.def_extern()(hw_machine_feel)


class Machine:
    """A plant and the device that is wired to it.

    sensors -- those of temperatures, then those of currents; felt -- a view of their values, °C, A.
    """

    def __init__(
        self, plant: Plant, device: AvrDevice, coupling: Coupling, step_s: float, *,
        logs_nodes: bool = False,
    ) -> None:  # fmt: skip
        """Take over the plant: from now on only this machine may step it.

        step_s -- time step, s; logs_nodes -- whether rows of the log have every node's temperature.
        """
        self.plant, self.step_s = plant, step_s
        self.loads = coupling.loads
        self.sensors = (*plant.feelers, *plant.ammeters)
        self._device, self._coupling = device, coupling
        self._errors: list[BaseException] = []
        self._rows: list[Array] = []
        self._kept: list[Any] = []
        self._noise: dict[int, Any] = {}
        feelers = enumerate(plant.feelers.values())
        self._noisy = {number: feeler for number, feeler in feelers if feeler.noise_k}
        native = load()
        self._lib, self._ffi = native.lib, native.ffi
        install(self._ffi)
        self._m = self._ffi.new("hw_machine *")
        self._lend(logs_nodes=logs_nodes)
        self.spoil({}, {}, {})
        self.wire()

    # -- data shared with C --------------------------------------------------------------------

    def _lend(self, *, logs_nodes: bool) -> None:
        plant, m, loads = self.plant, self._m, self.loads
        m.handle = self._held(self._ffi.new_handle(self))
        m.step_s, m.zero_c_k, m.log_grid = self.step_s, ZERO_C_K, LOG_GRID
        m.states, m.nodes, m.inputs = plant.states, len(plant.nodes), len(plant.vector)
        m.heaters, m.heater_count = self._list(
            "hw_heater", [(loads.index(name), power_w) for name, power_w in plant.heaters_w]
        )
        m.surfaces, m.surface_count = self._list("hw_surface", list(map(tuple, plant.surfaces)))
        m.fans, m.fan_count = self._list("int", [loads.index(name) for name in plant.fans])
        m.feelers, m.feeler_count = self._list("hw_feeler", len(plant.feelers))
        m.meters, m.meter_count = self._list("hw_meter", len(plant.ammeters))
        m.loads, m.load_count = self._list("hw_load", len(loads))
        self._lend_tips()
        m.key_size = 1 + len(plant.fans) + len(plant.surfaces)
        m.matrices_room = MOST_STEP_MATRICES
        m.columns = TIPS + len(self.sensors) + len(loads) + logs_nodes * len(plant.nodes)
        m.log_room, m.logs_nodes = LOG_ROWS, logs_nodes
        m.vector, m.next = self._array(plant.vector), self._array(np.empty(plant.states))
        self._key = np.empty(m.key_size)
        m.key = self._array(self._key)
        m.keys = self._array(np.empty((MOST_STEP_MATRICES, m.key_size)))
        m.matrices = self._array(np.empty((MOST_STEP_MATRICES, plant.states, m.inputs)))
        self._log = np.empty((LOG_ROWS, m.columns))
        m.log = self._array(self._log)
        felt = [each.felt_c for each in plant.feelers.values()]
        felt += [each.amperes for each in plant.ammeters.values()]
        self.felt, self._tips = np.array(felt), np.array(felt)
        m.felt, m.tips = self._array(self.felt), self._array(self._tips)
        self._active, self._given, self._conducts = (np.zeros(len(loads)) for _ in range(3))
        m.active, m.given = self._array(self._active), self._array(self._given)
        m.conducts = self._array(self._conducts)
        self._highest = np.array(plant.temperatures_c)
        m.highest = self._array(self._highest)

    def _lend_tips(self) -> None:
        m, plant = self._m, self.plant
        for number, feeler in enumerate(plant.feelers.values()):
            tip, past = m.feelers[number], np.array(feeler.past_c)
            tip.state, tip.older, tip.error = feeler.state, feeler.older_share, feeler.error_k
            tip.past, tip.length = self._array(past), len(past)
        self._draw()
        for number, meter in enumerate(plant.ammeters.values()):
            shared = m.meters[number]
            shared.load, shared.full_a = self.loads.index(meter.output), meter.full_a
            shared.share = meter.share

    def _held(self, pointer: Any) -> Any:
        """Keep an object that C points to alive as long as this machine."""
        self._kept.append(pointer)
        return pointer

    def _list(self, kind: str, items: Any) -> tuple[Any, int]:
        found = self._held(self._ffi.new(f"{kind}[]", items))
        return found, len(found)

    def _array(self, array: Array) -> Any:
        return self._ffi.cast("double *", self._held(self._ffi.from_buffer("double[]", array)))

    def wire(self) -> None:
        """Connect to the device's processor, which has just been powered on."""
        m, device = self._m, self._device
        m.h, m.clock_hz, m.powered_s = device.avr.pointer, device.avr.clock_hz, device.powered_s
        m.row, m.phase, m.read_at = 0, self._lib.HW_SENSES, device.avr.cycle
        m.steps_motors = self._coupling.moves
        m.relay = self._ffi.NULL if device.relay is None else device.relay.wired.pointer
        m.relay_closed = 0 if device.relay is None else device.relay.wired.closed_cycles
        tips = [m.feelers[number] for number in range(m.feeler_count)]
        tips += [m.meters[number] for number in range(m.meter_count)]
        for name, tip in zip(self.sensors, tips, strict=True):
            sensor = device.sensors[name]
            tip.channel = getattr(sensor, "channel", -1)
            if name in self.plant.feelers:
                tip.tip = sensor.tip.pointer if hasattr(sensor, "tip") else self._ffi.NULL
        for number, name in enumerate(self.loads):
            load, switch = m.loads[number], device.outputs[name]
            load.pin, load.active_high = switch.number, switch.active == "high"
            load.behind_relay = name in self._coupling.behind_relay
            load.high = device.avr.pins.high_cycles(switch.number)

    # -- time ----------------------------------------------------------------------------------

    def go(self, steps: int, stop: Stop = NO_STOP) -> int:
        """Advance by this many time steps, or up to one after which a condition of `stop` is met.

        Return how many steps are left.
        """
        m, lib, device = self._m, self._lib, self._device
        m.left, m.feed = steps, self._coupling.extruded_mm_per_s
        self._wait_for(stop)
        wake, m.look = device.wakes
        while True:
            fed = 0 if device.is_attended else device.feed_at
            ended = lib.hw_machine_go(m, NEVER if wake is None else wake, fed)
            if self._errors:
                raise self._errors.pop(0)
            if ended in (lib.HW_DONE, lib.HW_STOPPED):
                break
            self._serve(ended, wake)
            if ended == lib.HW_YIELD:  # after some real time: parts that wait may look now
                wake, m.look = min(NEVER if wake is None else wake, m.look.at), NO_LOOK
            else:
                wake, m.look = device.wakes
        device.avr.raise_errors()
        return int(m.left)

    def _wait_for(self, stop: Stop) -> None:
        m, avr = self._m, self._device.avr
        m.looked_at_count = len(stop.changed)
        self._looked_at = m.looked_at = self._ffi.new(
            "hw_variable[]",
            [(one.address, one.size, avr.read_ram(one.address, one.size)) for one in stop.changed],
        )
        m.until_spread, m.below_of, m.turns = stop.spread, -1, -1
        if stop.below is not None:
            sensor, m.below = stop.below
            m.below_of = self.sensors.index(sensor)
        if stop.turned is not None:
            m.turns = self.loads.index(stop.turned)
            switch = self._device.outputs[stop.turned]
            m.turned_from = switch.on == (switch.active == "high")

    def _serve(self, ended: int, wake: int | None) -> None:
        """Do what C needs, by the reason why it returned."""
        lib, device = self._lib, self._device
        if ended == lib.HW_FEED:
            device.listen()
        elif ended == lib.HW_WAKE and wake is not None:
            device.avr.run_to(wake)
            device.hear()
        elif ended == lib.HW_NEWS:
            device.hear()
        elif ended == lib.HW_MATRIX:
            self._remember()
        elif ended == lib.HW_NOISE:
            self._draw()
        elif ended == lib.HW_LOGGED:
            self._collect()
        else:
            device.avr.came_back(ended)

    def by_hand(self, run: Callable[[float], None]) -> None:
        """Advance by one step; run -- runs the device to a time, s, with an action meanwhile."""
        m = self._m
        self._make_room()
        self._tips[:] = self.felt
        self.feel()
        m.feed = self._coupling.extruded_mm_per_s
        self._lib.hw_machine_begin(m)
        run(m.powered_s + m.row * self.step_s)
        self._lib.hw_machine_read(m)
        self._heat()

    def without_power(self) -> None:
        """Advance by one step of the plant alone, while the controller has no power."""
        m = self._m
        self._make_room()
        self._tips[:], self._active[:] = self.felt, 0.0
        m.feed, m.closed = 0.0, self._device.relay_fraction()
        self._heat()

    def _heat(self) -> None:
        self._lib.hw_machine_supply(self._m)
        while self._lib.hw_machine_heat(self._m):
            self._remember()
        if self._errors:
            raise self._errors.pop(0)

    def spoil(
        self,
        heat: Mapping[str, Heat],
        besides: Mapping[str, Beside],
        feels: Mapping[str, Feel],
        *,
        volts: float = 1.0,
        taken: Mapping[str, float] = NOTHING,
    ) -> None:
        """Set the faults between pins and loads, by output, and of the tips, by sensor.

        Outputs and sensors that are not named have no fault. volts -- the heaters' supply, as a
        share of its nominal voltage; taken -- share of a heater's power that a load takes away.
        """
        self._feels = [(self.sensors.index(name), feel) for name, feel in feels.items()]
        self._m.feels = bool(feels)
        for number, name in enumerate(self.loads):
            load, beside = self._m.loads[number], besides.get(name)
            load.volts = volts if name in self.plant.heaters else 1.0
            load.taken = taken.get(name, 0.0)
            load.times, load.least, once = heat.get(name, SOUND)
            load.once_asked = -1.0 if once is None else once
            load.beside = 0.0
            if beside is not None:
                load.beside, load.below = beside.share, beside.below_c
                load.beside_of = self.sensors.index(beside.sensor)

    def _make_room(self) -> None:
        m = self._m
        if m.logged == LOG_ROWS:
            self._collect()
        self._draw()

    def _remember(self) -> None:
        """Give C the matrix for the present feed, fans and surfaces, which are its key."""
        feed, *rest = self._key.tolist()
        fans = len(self.plant.fans)
        matrix = self.plant.matrix(tuple(rest[:fans]), feed, tuple(rest[fans:]))
        self._lib.hw_machine_matrix(self._m, self._ffi.from_buffer("double[]", matrix))

    def _draw(self) -> None:
        """Draw new noise for each sensor that has used its noise."""
        for number, feeler in self._noisy.items():
            tip = self._m.feelers[number]
            if not tip.drawn:
                noise = np.array(feeler.left_k())
                self._noise[number] = buffer = self._ffi.from_buffer("double[]", noise)
                tip.noise, tip.drawn = self._ffi.cast("double *", buffer), len(noise)

    # -- calls from C --------------------------------------------------------------------------

    def attempt(self, act: Callable[..., Any], *given: Any) -> Any:
        """Run a callback of C. C cannot pass on an exception: `go` raises it later."""
        try:
            return act(*given)
        except BaseException as error:
            self._errors.append(error)

    def feel(self) -> None:
        """Set this step's temperatures of the tips that have a fault."""
        for sensor, feel in self._feels:
            self._tips[sensor] = feel(float(self.felt[sensor]))

    def tell(self, sensor: int, felt: float) -> None:
        """Set the temperature or the current of a sensor."""
        self._device.sense(self.sensors[sensor], felt)

    def fed(self) -> float:
        """Return the mean speed of the feed in the step that has just been run, mm/s."""
        if self._m.until >= self._device.feed_at:
            self._device.feed()
        return self._coupling.feed_mm_per_s()

    # -- the log -------------------------------------------------------------------------------

    @property
    def count(self) -> int:
        """Number of rows in `rows`."""
        return sum(map(len, self._rows)) + int(self._m.logged)

    @property
    def rows(self) -> Array:
        """A row for each step since the last `take_rows`: see TIME and the other columns."""
        self._collect()
        if len(self._rows) > 1:
            self._rows = [np.concatenate(self._rows)]
        return self._rows[0]

    def _collect(self) -> None:
        m = self._m
        if m.logged or not self._rows:
            self._rows.append(self._log[: m.logged].copy())
            m.logged = 0

    def take_rows(self) -> Array:
        """Return the rows since the last call and delete them; not allowed while watching peaks."""
        rows = self.rows
        self._rows = []
        return rows

    def given(self, rows: Array) -> Array:
        """Return the loads' shares of power (0..1) in some rows, a column for each of `loads`."""
        first = TIPS + len(self.sensors)
        return rows[:, first : first + len(self.loads)]

    def nodes_c(self, rows: Array) -> Array:
        """Return the temperature of every node after the step of some rows, °C."""
        return rows[:, TIPS + len(self.sensors) + len(self.loads) :]

    # -- peaks ---------------------------------------------------------------------------------

    def watch(self, sensor: str) -> None:
        """Record the highest temperatures of all nodes, and of a sensor, from now on."""
        m = self._m
        m.peak_of = self.sensors.index(sensor)
        m.peak, m.watches, m.spreads = self.felt[m.peak_of], True, False
        self._highest[:] = self.plant.temperatures_c

    def look(self, *, watches: bool) -> None:
        """Set whether the next steps count for the highest temperatures."""
        self._m.watches = watches

    @property
    def peak_c(self) -> float:
        """The highest temperature of the watched sensor, °C."""
        return float(self._m.peak)

    @property
    def highest_c(self) -> Array:
        """The highest temperature of every node while it was watched, °C."""
        return self._highest.copy()

    @property
    def spreads(self) -> bool:
        """Whether a node exceeded its `highest_c` in the last step although no heater had power."""
        return bool(self._m.spreads)
