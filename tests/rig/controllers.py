"""Any valid controller that the language allows, with a machine that suits it, as a strategy.
`controllers()` draws a board, then interfaces, programs and relay for its pins and ports, then one
to three loops from what pins and timers are left, each with a plant and protections computed from
it. What the checks refuse all the same is not drawn (`assume`); `drawn()` gives that too."""

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import islice
from random import Random
from typing import Any, NamedTuple

import yaml
from hypothesis import assume
from hypothesis import strategies as st
from rig.controllers_loops import AMBIENT_C, FEED_MM_PER_S, LoopDraw, Served, joined
from rig.controllers_parts import (
    Draws,
    Part,
    Resources,
    Sensors,
    Unsuited,
    adjusted,
    own_draws,
    step_k,
    text,
    tidy,
    usable_c,
)
from suite import SEED

from heatwright.spec import BOARDS, Board, Spec, SpecError, load_text
from heatwright.spec.board import eeprom
from heatwright.spec.board.timers import ticks_at_all
from heatwright.spec.board.uart import BAUD_TOLERANCE, baud_setting
from heatwright.spec.checks.board.memory import LEAST_BYTES, NEXTION_BYTES
from heatwright.spec.controller import WATCHDOG_S
from heatwright.spec.interfaces import BUS_BAUDS, DISPLAY_BAUDS, FASTEST_HOST, LCD_KEYPAD
from heatwright.spec.loops import LONGEST_RULE_S
from heatwright.spec.sensors import shortest_period_s

NAMES = ("air", "bed", "plate_2")
MONITORS = ("drivers", "camera")
HOTTEST_BOX_C = 45.0  # no room, and no loop, makes a monitored box warmer
CLOCKS_MHZ = (8, 12, 14.7456, 18.432, 20)
BAUDS = (9600, 115_200, 1200, 19_200, 38_400, 57_600, 250_000)
LENGTH_S = 60.0  # length of a scenario
BY_HOST = {"B": ("M140", "M303 E-1", "M304"), "C": ("M141", "M303 E-2", "M309")}
"""How a host heats bed and chamber, tunes them, and sets their gains."""
TITLES = ("An oven", "Größe µ/Ω ??/ */ \\", "x" * 60)


class Drawn(NamedTuple):
    text: str
    spec: Spec

    def __repr__(self) -> str:
        return f"the spec\n{self.text}"


@st.composite
def controllers(draw: Any) -> Drawn:
    found = attempt(lambda low, high: draw(st.integers(low, high)))
    assume(isinstance(found, Drawn))
    return found


def attempt(
    between: Callable[[int, int], int], loops: Sequence[int] = (1, 2, 3), seldom: int = 6
) -> Drawn | SpecError | None:
    """Draw one; what the checks refuse comes back as their words.

    seldom -- what comes seldom comes once in so many.
    """
    try:
        text = _Controller(Draws(between, seldom), loops).text()
        return Drawn(text, load_text(text, "drawn.yaml"))
    except SpecError as error:
        return error
    except Unsuited:
        return None


def drawings(random: Random, loops: Sequence[int] = (1, 2, 3), seldom: int = 6) -> Iterator[Drawn]:
    """Draw one after the other without hypothesis, with one of these numbers of loops."""
    while True:
        found = attempt(random.randint, loops, seldom)
        if isinstance(found, Drawn):
            yield found


def _seeded() -> Random:
    return Random(f"controllers {SEED}")  # noqa: S311 - no secret


def attempts(count: int) -> list[Drawn | SpecError | None]:
    """Attempt a number of them, the same ones for the same SUITE_SEED."""
    random = _seeded()
    return [attempt(random.randint) for _ in range(count)]


@cache
def drawn(count: int) -> tuple[Drawn, ...]:
    """Draw a number of them: the attempts that are accepted."""
    return tuple(islice(drawings(_seeded()), count))


class _Controller:
    def __init__(self, draws: Draws, loops: Sequence[int]) -> None:
        self.draws = draws
        self._simulated = draws.one(True, True, False)
        self.identity: Part = {"name": "drawn", "board": draws.one(*BOARDS)}
        self.board = self._clocked(BOARDS[self.identity["board"]])
        if draws.seldom():
            self.identity["title"] = draws.one(*TITLES)
        self.names = NAMES[: draws.one(*loops)]
        self.left = Resources(draws, self.board, len(self.names))
        self.interfaces: list[Part] = []
        self.outputs: dict[str, Part] = {}
        self.safety: Part = {}
        self.programs: Part = {}
        self._needed = 4 * len(self.names)
        self._ports()
        self._display_and_programs()
        self._relay()
        self._leds_without_meaning_yet()
        self._loops()
        self._monitors()
        self._seconds()
        self._host()
        self._programs()
        self._logs()
        self._leds()
        self._inputs()
        self._on_times()
        self._watchdog()

    def _clocked(self, board: Board) -> Board:
        clocked = {mhz: replace(board, clock_hz=round(mhz * 1e6)) for mhz in CLOCKS_MHZ}
        able = [mhz for mhz, other in clocked.items()
                if other.clock_hz <= other.fastest_hz and ticks_at_all(other)]  # fmt: skip
        if not self.draws.seldom():
            return board
        mhz = self.draws.one(*able)
        self.identity["clock"] = f"{mhz} MHz"
        return clocked[mhz]

    # Interfaces

    def _ports(self) -> None:
        """Choose who talks on which serial port; the details need the loops."""
        draws, board = self.draws, self.board
        first = ["serial_plotter", "gcode", "modbus_rtu"]
        first += ["nextion"] * (board.ram_bytes >= 2000) + ["serial_log"]
        self.on_port: dict[str, int] = {}
        kind = draws.one(None, *first)
        if kind is not None and (kind != "modbus_rtu" or self.left.take_timer()):
            self.on_port[kind] = 0
        for port in range(1, len(board.uarts)):
            others = {"nextion", "serial_log"} - set(self.on_port)
            other = draws.one(None, *sorted(others)) if draws.some() else None
            if other == "nextion" and self.on_port.get("gcode") == 0 and len(self.names) == 1:
                continue  # a host and a display switch a loop in different ways
            if other is not None:
                self.on_port[other] = port
        for port in self.on_port.values():
            self.left.keep_off((board.uarts[port].rx, board.uarts[port].tx))

    def _display_and_programs(self) -> None:
        draws = self.draws
        self.has_keys = self.board.shield and len(self.names) < 3 and draws.some()
        if self.has_keys:
            self.left.keep_off(LCD_KEYPAD.pins)
        self.shown = draws.one(*self.names)
        self.served_by_host = self._tools()
        commanded = {"gcode", "modbus_rtu"} & set(self.on_port)
        able = (self.has_keys or "nextion" in self.on_port) and not commanded
        some = able and draws.some()
        self.programmed = self.shown if some and self._most_points() >= 1 else None

    def _tools(self) -> tuple[str, ...]:
        if "gcode" not in self.on_port:
            return ()
        able = [name for name in self.names if "nextion" not in self.on_port or name != self.shown]
        return tuple(name for name in able if name == able[0] or self.draws.some())

    def _relay(self) -> None:
        if not self.draws.seldom():
            return
        self.outputs["main_relay"] = {"kind": "digital", "pin": self.left.digital(heats=True)}
        self.outputs["main_relay"] |= self.draws.maybe({"active": "low"})
        self.safety["relay"] = "main_relay"
        if self._spare() and self.draws.some():
            self.safety["relay_feedback"] = self.left.digital()

    def _inputs(self) -> None:
        own = own_draws(self.safety | self.outputs)
        number = 0
        while self._spare() and number < 3 and (own.some() if number else own.seldom()):
            part = {"pin": self.left.digital(), **own.maybe({"trips": False})}
            part |= own.maybe({"for": text(own.number(20, 1000, 50), "ms")})
            self.safety.setdefault("inputs", {})[f"contact_{number}"] = part
            number += 1

    def _spare(self) -> bool:
        return self.left.pins > self._needed

    def _leds_without_meaning_yet(self) -> None:
        self.lights: list[str] = []
        while self._spare() and self.draws.seldom():
            self.lights.append(self.left.digital())

    def _served(self, name: str) -> Served:
        by_master = "modbus_rtu" in self.on_port
        touched = "nextion" in self.on_port and name == self.shown
        programmed = name == self.programmed
        keyed = self.has_keys and name == self.shown and name not in self.served_by_host
        switched = by_master or touched or programmed or keyed
        has_menu = touched or (programmed and self.has_keys)
        return Served(by_master, name in self.served_by_host, switched, programmed, has_menu)

    def _loops(self) -> None:
        draws, left = self.draws, self.left
        self.host_fans: dict[str, str] = {}
        self.feeds = False
        other = not self.has_keys and draws.seldom()
        reference = draws.one("internal", "3 V") if other else "supply"
        self.sensors = sensors = Sensors(left, reference)
        if self.served_by_host:
            self._fans_and_feed()
        self.loops: list[LoopDraw] = []
        for place, name in enumerate(self.names):
            left.kept_analog = 2 * (len(self.names) - place - 1)
            spare = left.pins - 4 * (len(self.names) - place - 1)
            cold = len(self.names) > 1
            self.loops.append(LoopDraw(name, sensors, self._served(name), spare, cold=cold))
        self._simulated &= all(loop.start_c == AMBIENT_C for loop in self.loops)

    def _monitors(self) -> None:
        """Watch what belongs to no loop; in a box of its own, which one of the loops may warm."""
        draws = self.draws
        self.monitors: dict[str, Part] = {}
        self.watched: list[Any] = []
        for name in MONITORS:
            on_menu = self.has_keys and self.programmed  # there are few of these
            if not self._spare() or not (draws.some() if on_menu else draws.seldom()):
                continue
            part, sensor = self.sensors.draw(self.left.pins, chosen=False, cold=True)
            part.pop("moving_average", None)
            slow_s = shortest_period_s(sensor)
            period_s = next((each.period_s for each in self.loops if each.period_s >= slow_s), None)
            floor_c, ceiling_c = usable_c(sensor)
            wide_k = max(2.1 * step_k(sensor, self.board.mcu, floor_c, ceiling_c), 0.5)
            if period_s is None or floor_c > 0 or ceiling_c - 3 * wide_k < HOTTEST_BOX_C:
                continue
            limit_c = draws.number(HOTTEST_BOX_C + 2 * wide_k, ceiling_c, 80, 0.1)
            warning_c = draws.number(20, limit_c - wide_k - 0.1, limit_c - 10, 0.1)
            monitor: Part = {"sensor": f"{name}_probe", "warning": text(warning_c, "°C")}
            monitor["limit"] = text(limit_c, "°C")
            most_k = min(30.0, warning_c - max(floor_c, 0))
            hysteresis_k = draws.number(min(wide_k, most_k), most_k, 2, 0.1)
            monitor |= {"hysteresis": text(hysteresis_k, "K")} if hysteresis_k != 2 else {}
            starts = math.ceil(round(sensor.first_s / period_s, 6)) if sensor.first_s else 1
            stale_s = draws.number((1 + starts) * period_s, 255 * period_s, 5, period_s)
            monitor |= {"stale_after": text(stale_s, "s")} if stale_s != 5 else {}
            self.monitors[name] = monitor
            node = draws.one(None, self.loops[0])
            self.watched.append((name, part, node))

    def _seconds(self) -> None:
        """Give loops a second sensor, where the first one is, that reads all that the first may."""
        self.twins: list[tuple[LoopDraw, Part]] = []
        for loop in self.loops:
            own = own_draws(loop.loop)
            if not self._spare() or not own.seldom():
                continue
            part, sensor = self.sensors.draw(self.left.pins, chosen=False, cold=True)
            part.pop("moving_average", None)
            starts = math.ceil(round(sensor.first_s / loop.period_s, 6)) if sensor.first_s else 1
            stale_s = (1 + starts) * loop.period_s
            (low_c, high_c), mcu = sensor.range_c, self.board.mcu
            step = max(step_k(each, mcu, low_c, high_c) for each in (sensor, loop.sensor))
            apart_k = 2 * step + sensor.error_k(high_c) + loop.error_k
            limit_c = math.ceil(loop.maximum_c + apart_k) + 0.1
            reads = low_c <= loop.minimum_c and limit_c <= high_c - sensor.error_k(high_c)
            quick = shortest_period_s(sensor) <= loop.period_s and stale_s <= loop.stale_s
            if not reads or not quick:
                continue
            warning_c = math.floor(limit_c - 2.1 * step - 0.5)
            self.monitors[f"{loop.name}_twin"] = {
                "sensor": f"{loop.name}_second", "warning": text(warning_c, "°C"),
                "limit": text(limit_c, "°C"), "hysteresis": text(tidy(1.1 * step + 0.1), "K"),
                "stale_after": text(max(stale_s, 2 * loop.period_s), "s"),
            }  # fmt: skip
            moves_k = 2 * loop.rate_k_per_s * (loop.period_s + sensor.conversion_s)
            loop.loop["also"] = f"{loop.name}_twin"
            loop.loop["protection"]["agreement"] = {
                "within": text(tidy(own.one(1.2, 3.0) * (apart_k + moves_k)), "K"),
                "for": text(max(10.0, 2 * loop.period_s), "s"),
            }
            self.twins.append((loop, part))

    def _boxes(self, plant: Part) -> None:
        for name, _, warmer in self.watched:
            plant["nodes"][f"{name}_box"] = "200 J/K"
            plant["links"].append({"between": [f"{name}_box", "ambient"], "resistance": "2 K/W"})
            if warmer is not None:
                warm = [f"{name}_box", warmer.name]
                plant["links"].append({"between": warm, "resistance": "20000 K/W"})
            plant["sense"][f"{name}_probe"] = {"node": f"{name}_box", "lag": "5 s"}
        for loop, _ in self.twins:
            plant["sense"][f"{loop.name}_second"] = {**plant["sense"][f"{loop.name}_felt"]}

    def _fans_and_feed(self) -> None:
        draws = self.draws
        if self._spare() and draws.some():
            pulses = self.left.pwm(1.0, heats=False) if draws.some() else None
            part = {"kind": "pwm", **(pulses or {})}
            if not pulses:
                part = {"kind": "digital", "pin": self.left.digital()}
                part |= draws.maybe({"minimum_on": "2 s"})
            self.outputs["blower"] = part
            self.host_fans[draws.one("P0", "P9")] = "blower"
        if self.left.pins > self._needed + 3 and draws.some() and self.left.take_timer():
            self.feeds = True
            wires = {key: self.left.digital() for key in ("step", "direction", "enable")}
            self.outputs["feed"] = {
                "kind": "stepper", **wires, "steps": 200, "microsteps": draws.one(16, 1, 256),
                "lead": "25 mm", "maximum": "4 mm/s", "acceleration": "50 mm/s²",
                **draws.maybe({"enable_active": "high"}),
            }  # fmt: skip

    def _baud(self, most: int, choices: Collection[int] = BAUDS) -> Part:
        able = [
            baud for baud in choices
            if baud <= most and abs(baud_setting(self.board.clock_hz, baud).error) <= BAUD_TOLERANCE
        ]  # fmt: skip
        return {"baud": self.draws.one(*able)}

    def _port(self, kind: str) -> Part:
        return {"port": self.on_port[kind]} if self.on_port[kind] else {}

    def _host(self) -> None:
        draws = self.draws
        if "gcode" in self.on_port:
            called = draws.one(
                ("T0", "T9", "T8"), ("T0", "B", "C"), ("B", "T3", "T0"), ("C", "B", "T9")
            )
            loops = dict(zip(called, self.served_by_host, strict=False))
            part: Part = {"kind": "gcode", **self._baud(FASTEST_HOST), "loops": loops}
            part |= {"fans": self.host_fans} if self.host_fans else {}
            if self.feeds:
                part["steppers"] = {"E": "feed"}
                next(each for each in self.loops if each.name in self.served_by_host).ready()
            self.interfaces.append(part)
        if "modbus_rtu" in self.on_port:
            part = {"kind": "modbus_rtu", **self._baud(115_200, BUS_BAUDS)}
            part |= draws.maybe({"address": draws.one(1, 247)})
            part |= draws.maybe({"parity": draws.one("odd", "none")})
            part |= draws.maybe({"stop_bits": draws.one(1, 2)})
            if self.left.pins and draws.some():
                part["driver_enable"] = self.left.digital()
            self.interfaces.append(part | draws.maybe({"linuxcnc": True}))
        if "serial_plotter" in self.on_port:
            part = {"kind": "serial_plotter", "loop": draws.one(*self.names)}
            part |= draws.maybe({"line_end": "CR LF", "decimals": draws.one(0, 1, 2)})
            self.interfaces.append(part | self._baud(2_000_000))
        if "nextion" in self.on_port:
            part = {"kind": "nextion", "loop": self.shown}
            part |= self._baud(115_200, DISPLAY_BAUDS[::-1])
            self.interfaces.append(part | self._port("nextion"))
        if self.has_keys:
            part = {"kind": "lcd_keypad", "loop": self.shown}
            shown = next(each for each in self.loops if each.name == self.shown)
            most_k = max(0.1, min(100.0, shown.high_c - shown.low_c))
            step_k = draws.number(0.1, most_k, 1, 0.1)
            part |= {"step": text(step_k, "K")} if step_k != 1 else {}
            served = shown.served
            counts = served.switched and not served.programmed
            if counts and shown.loop.get("starts") != "enabled" and draws.some():
                rests = shown.kind == "pid" and not shown.integrates
                able: list[Part] = [{"counts": "at once"}]
                able += [] if rests else [{}, {"longest": "1 h", "step": "10 min"}]
                part["countdown"] = draws.one(*able)
            has_gains = shown.kind == "pid" and (served.by_host or served.by_master)
            if not (served.programmed or has_gains):
                numbers = adjusted(own_draws(part), shown.algorithm)
                part |= {"adjust": numbers} if numbers else {}
            self.interfaces.append(part)

    def _on_times(self) -> None:
        """Let loops be on for at most 25 h, longer than all that ends by itself."""
        for loop in self.loops:
            served = loop.served
            off = loop.loop.get("starts") == "disabled"
            set_off = loop.low_c == 0 and not loop.loop["setpoint"].get("stored")
            off = off or (served.zero_is_off and set_off)
            tunes_s = float(loop.loop.get("autotune", {}).get("timeout", "0 s").split()[0])
            long = loop.period_s > 60 or tunes_s > LONGEST_RULE_S
            if off and not (long or served.programmed) and own_draws(loop.loop).seldom():
                loop.loop["protection"]["on_for_at_most"] = "25 h"

    # Programs and logs

    def _most_points(self) -> int:
        """Count the points of a program that the RAM has room for, beside a display."""
        if "nextion" not in self.on_port:
            return 20
        return (self.board.ram_bytes - LEAST_BYTES - NEXTION_BYTES - 400) // 63

    def _eeprom_left(self) -> int:
        settings = (eeprom.FEWEST_SETTINGS_SLOTS + 2) * 2 * eeprom.SETTINGS_SLOT_BYTES
        return self.board.eeprom_bytes - min(settings, self.board.eeprom_bytes // 2)

    def _programs(self) -> None:
        if self.programmed is None:
            return
        draws = self.draws
        room = self._eeprom_left() - 4 * eeprom.PROGRESS_BYTES
        points = int(draws.number(1, min(20, self._most_points()), 3))
        each = eeprom.PROGRAM_FRAME_BYTES + eeprom.PROGRAM_BYTES + eeprom.SEGMENT_BYTES * points
        each *= eeprom.SLOTS_OF_A_PROGRAM
        most = max(1, min(8, room // each))
        places = int(draws.number(1, most, 3))
        loop = next(each for each in self.loops if each.name == self.programmed)
        slots = max(2, (room - places * each) // eeprom.PROGRESS_BYTES)
        least_s = max(10.0, loop.period_s, _worn_after_s(slots))
        part: Part = {"loop": self.programmed, "points": points, "places": places}
        part["save_every"] = text(draws.number(least_s, min(3600, 65_535 * loop.period_s), 60), "s")
        rests_k = max(loop.step_k, loop.band_k, loop.dead_k, 0.1)
        part["reached_within"] = text(round(1.2 * rests_k + 0.1, 2), "K")
        part |= self._hold_back(loop, 1.2 * rests_k + 0.2)
        if draws.some():
            part["after_power_loss"] = {
                "resume_within": text(draws.number(0, 100, 30), "K"),
                "otherwise": draws.one("stop", "pause"),
            }
            if part["after_power_loss"] != {"resume_within": "0 K", "otherwise": "stop"}:
                part["on_fault"] = ("stop", "pause")[places % 2]
        part |= draws.maybe({"at_end": "hold"})
        count = int(draws.number(0, min(places, 2), 1))
        stored = [self._program(f"no {number}", points, loop) for number in range(1, count + 1)]
        self.programs = part | ({"stored": stored} if stored else {})

    def _hold_back(self, loop: LoopDraw, least_k: float) -> Part:
        if not loop.runs_away:
            return {"hold_back": "off"}
        within_k = round(least_k + 0.1, 2)
        if loop.runs_away and within_k >= loop.above_k:
            rule = loop.loop["protection"]["runaway"]
            rule |= {key: text(within_k + 5, "K") for key in ("above", "below") if key in rule}
        longest_s = min(65_535, 65_535 * loop.period_s)
        limit_s = self.draws.number(max(1, loop.period_s), longest_s, 7200)
        return {"hold_back": {"within": text(within_k, "K"), "limit": text(limit_s, "s")}}

    def _program(self, name: str, points: int, loop: LoopDraw) -> Part:
        draws = self.draws
        slowest_s = loop.span_k / loop.rate_k_per_s * 20 + loop.period_s
        segments: list[Part] = []
        for _ in range(int(draws.number(1, min(points, 5), 2))):
            target = {"to": text(draws.number(loop.low_c, loop.high_c, loop.low_c, 0.1), "°C")}
            longest_s = min(31 * 86_400.0, 16_000_000 * loop.period_s)
            seconds = draws.number(max(1, slowest_s), longest_s, 2 * slowest_s)
            form = draws.one("over", "rate", "fast", "hold", "until")
            per_h = min(6000.0, max(0.1, 3600 * loop.span_k / slowest_s))
            segments.append({
                "over": target | {"over": text(min(seconds, longest_s), "s")},
                "rate": target | {"at": text(draws.number(0.1, per_h, 30, 0.1), "K/h")},
                "fast": target | {"at": "as fast as possible"},
                "hold": {"hold": text(min(seconds, longest_s), "s")},
                "until": {"hold": "until operator"},
            }[form])  # fmt: skip
        return {"name": name, "segments": segments}

    def _logs(self) -> None:
        if "serial_log" not in self.on_port:
            return
        draws = self.draws
        loop = draws.one(*self.loops)
        part: Part = {"kind": "serial_log", "loop": loop.name, **self._baud(FASTEST_HOST)}
        part |= self._port("serial_log")
        least_s = max(1.0, loop.period_s)
        if not self.programs and draws.some():
            most = self._eeprom_left() // (eeprom.LOG_FRAME_BYTES + 5) - 2
            entries = int(draws.number(1, min(most, 1000), 20))
            least_s = max(least_s, _worn_after_s(entries))
            part |= {"keep": "eeprom"} if least_s <= 3600 else {}
        if "keep" not in part:
            touched = "nextion" in self.on_port
            taken = 560 + NEXTION_BYTES * touched + 63 * self.programs.get("points", 0)
            most = (self.board.ram_bytes - taken) // 6
            entries = int(draws.number(1, min(max(most, 1), 1000), 20))
            least_s = max(1.0, loop.period_s)
        every_s = draws.number(least_s, 3600, 60)
        self.interfaces.append(part | {"every": text(every_s, "s"), "entries": entries})

    def _leds(self) -> None:
        if not self.lights:
            return
        loop = self.draws.one(*self.loops)
        able = ["enabled", "heating", "warm", "fault"]
        able += ["cooling"] * (f"{loop.name}_cooler" in loop.outputs)
        able += ["communicating"] * ("modbus_rtu" in self.on_port)
        leds = {pin: self.draws.one(*able) for pin in self.lights}
        part: Part = {"kind": "indicators", "leds": leds}
        part |= {"loop": loop.name} if len(self.loops) > 1 or self.draws.some() else {}
        self.interfaces.append(part | self.draws.maybe({"active": "low"}))

    def _watchdog(self) -> None:
        most_s = min(self.board.longest_watchdog_s, *(loop.stale_s for loop in self.loops))
        least_s = 0.25 if self.programs else 0.03
        able = [each for each in WATCHDOG_S if least_s <= each <= most_s]
        self.safety["watchdog"] = text(self.draws.one(*[2.0] * (2.0 in able), *able), "s")
        if own_draws(self.safety).seldom():
            self.safety["self_checks"] = False
        if own_draws(self.safety | self.outputs).seldom():
            self.safety["lockout"] = "off"

    # The simulated machine

    def _simulation(self) -> Part:
        loops = self.loops
        links = [link for loop in loops for link in loop.links]
        radiation = [each for loop in loops for each in loop.radiation]
        fans = joined(loops, "fans")
        if "blower" in self.outputs and self.draws.some():
            fans["blower"] = {"link": links[-1]["between"], "factor": 1.4}
        plant: Part = {
            "kind": "thermal_network",
            "nodes": joined(loops, "nodes"), "links": links,
            "heat": {f"{loop.name}_heater": loop.heat for loop in loops},
            "sense": joined(loops, "sense"), **({"fans": fans} if fans else {}),
            **({"radiation": radiation} if radiation else {}),
        }  # fmt: skip
        self._boxes(plant)
        if self.draws.seldom():
            plant["initial"] = text(self.draws.one(AMBIENT_C, 24), "°C")
        if self.draws.one(True, True, True, False):  # else what full power makes of it
            plant["bears"] = joined(loops, "bears")
        if "feed" in self.outputs or self.draws.seldom():
            plant["filament"] = {"node": loops[0].name, "heat": loops[0].fed}
        found: Part = {"ambient": "20 °C", "plant": plant, "scenario": self._scenario(plant)}
        sized = [loop for loop in loops if loop.high_c > AMBIENT_C and self.draws.seldom()]
        return found | ({"sizing": {loop.name: self._sizing() for loop in sized}} if sized else {})

    def _sizing(self) -> Part:
        draws = self.draws
        layer = {"thickness": text(draws.number(1, 100, 5), "mm"), "conductivity": "0.2 W/(m·K)"}
        outside = draws.one({}, {"outside": "20 W/m²K"}, {"wind": "10 m/s"})
        wall = {"area": "0.5 m²", "layers": [layer] * draws.one(1, 2), **outside}
        wall |= draws.maybe({"inside": "8 W/m²K", "emissivity": 0.85})
        wire = {"resistivity": "1.1 Ω·mm²/m", "surface_load": "2 W/cm²", "voltage": "24 V"}
        wire |= {"air_speed": "2 m/s", **draws.maybe({"air": "20 °C", "measured": "127 °C"})}
        return {**draws.maybe({"walls": [wall]}), **draws.maybe({"wire": wire})}

    def _scenario(self, plant: Part) -> list[Part]:
        draws = self.draws
        able = self._orders() + [{"extrude": text(FEED_MM_PER_S, "mm/s")}] * ("filament" in plant)
        count = int(draws.number(0, 6, 2)) if able else 0
        times = sorted(draws.number(0.5, LENGTH_S - 1, 5, 0.01) for _ in range(count))
        events = [{"at": text(at_s, "s"), **draws.one(*able)} for at_s in times]
        return [*events, {"for": text(LENGTH_S, "s")}]

    def _orders(self) -> list[Part]:
        found: list[Part] = []
        if self.has_keys:
            keys = ("up", "down", "select", "left", "right")
            found += [{"press": key} for key in keys] + [{"press": "up", "times": 3}]
        if "gcode" in self.on_port:
            address = next(iter(self.interfaces[0]["loops"]))
            heat, tune, gains = BY_HOST.get(address, (f"M104 {address}", f"M303 {address}", "M301"))
            warm_c = text(round((self.loops[0].low_c + self.loops[0].high_c) / 2))
            lines = ["M105", f"{heat} S{warm_c}", f"{heat} S0", "M106 S128", "M107", "M112", "M999",
                     f"{tune} S{warm_c} C3", f"{gains} P5 I0.1 D2", "G1 E5 F300"]  # fmt: skip
            lines.append(address if "T" in address else "M114")
            if self.loops[0].algorithm.get("limits_adjustable"):
                lines += [f"{gains} K90 Y35", f"{gains} J-10 Y200"]
            found += [{"send": line} for line in lines]
        if "modbus_rtu" in self.on_port:
            found += [{"write": write} for write in self._writes()]
        if self.programs:
            stored = len(self.programs.get("stored", ()))
            orders = [f"start {number}" for number in range(1, stored + 1)]
            orders += ["pause", "resume", "skip", "stop"]
            found += [{"program": order} for order in orders] if stored else []
        return found

    def _writes(self) -> list[Part]:
        found: list[Part] = [{"acknowledge": True}]
        for loop in self.loops:
            warm_c = text(round((loop.low_c + loop.high_c) / 2, 1), "°C")
            found += [{f"{loop.name}.setpoint": warm_c, f"{loop.name}.enabled": True}]
            found += [{f"{loop.name}.enabled": each} for each in (True, False)]
            if loop.kind == "pid":
                found += [{f"{loop.name}.manual": True, f"{loop.name}.manual_duty": "40 %"}]
                found += [{f"{loop.name}.manual": False}, {f"{loop.name}.kp": 3.5}, {"store": True}]
            if "autotune" in loop.loop:
                found.append({f"{loop.name}.tune": True})
        return found

    def text(self) -> str:
        whole: Part = {
            "heatwright": 1, "controller": self.identity,
            "sensors": joined(self.loops, "sensors")
            | {f"{name}_probe": part for name, part, _ in self.watched}
            | {f"{loop.name}_second": part for loop, part in self.twins},
            "outputs": {**joined(self.loops, "outputs"), **self.outputs},
            "loops": {loop.name: loop.parts() for loop in self.loops},
            **({"monitors": self.monitors} if self.monitors else {}),
            **({"programs": self.programs} if self.programs else {}), "safety": self.safety,
            **({"interfaces": self.interfaces} if self.interfaces else {}),
            **({"simulation": self._simulation()} if self._simulated else {}),
        }  # fmt: skip
        if not self._simulated and self.draws.one(True, True, False):
            for output in whole["outputs"].values():
                if "current" not in output:
                    output.pop("power", None)
        return yaml.dump(
            whole, Dumper=_Plain, allow_unicode=True, sort_keys=False, default_flow_style=None,
            width=100,
        )  # fmt: skip


def _worn_after_s(places: int) -> int:
    """Give a time between two writings, s, at which so many places last long enough."""
    return 10 * round(eeprom.slowest_s(eeprom.LEAST_YEARS, places) / 10 + 1)


class _Plain(yaml.CSafeDumper):
    """Writes each part out where it is, without anchors."""

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002
        return True
