"""What a menu's two lines say of a machine, and what its keys order: written without its C."""

from types import SimpleNamespace
from typing import Any

import numpy as np

SETPOINTS_C, MAXIMUM_C, STEP_K = (15.0, 1100.0), 1150.0, 2
PERIOD_MS, PROGRAMS, POINTS = 2100, 3, 5
KWH_PER_COUNT = np.float32(484 * PERIOD_MS / 1000 / 3.6e9)
"""As the spec has it (hosted_menu.py): 484 W, energy in thousandths of a step."""
TYPES = {3: "K", 6: "S", 4: "N"}
LETTERS = [chr(code) for code in range(0x20, 0x7F) if chr(code) not in '"\\']
KINDS = ("end", "ramp in a time", "ramp at a rate", "fast as it can", "hold a time",
         "hold for SELECT")  # fmt: skip
WITH_TARGET, WITH_TIME, RATE = (1, 2, 3), (1, 4), 2
FAULTS = ("NO SENSOR", "SENSOR SHORT", "SENSOR CRC", "SENSOR STALE", "SENSOR RESET", "TOO HOT",
          "TOO COLD", "JUMP", "FROZEN", "NO HEATING", "RUNAWAY HIGH", "RUNAWAY LOW", "HEATS IN OFF",
          "WATCHDOG", "BROWN-OUT", "SETTINGS BAD", "SENSOR OPEN", "OUT OF RANGE", "STOPPED",
          "OVER CURRENT", "LEAKS IN OFF", "NO CURRENT", "MASTER LOST", "KILN LAGS", "RELAY WELDED",
          "RELAY OPEN")  # fmt: skip
OF_OTHERS = (12, 19, 20, 21, 22, 23)
"""Rules that this machine cannot break: runaway below, a host's stop, currents, a master."""
IDLE, _, PAUSED, RETURNING, RESTORING = range(5)
WAITS = (" runs", " held back", " to target", " SELECT: on")
ENDED = ("off", "finished", "stopped", "ended by fault", "power cut: cold", "power cut: lost")
VALUES = {"Setpoint": "setpoint_c", "Hold setpoint?": "is_on", "Kp %/K": "kp", "Ki %/(Ks)": "ki",
          "Kd %s/K": "kd", "Trips at": "maximum_c", "Thermocouple": "type", "Energy": "",
          "EEPROM saves": "", "Faults so far": ""}  # fmt: skip
LET_GO = {range(9, 202): "let go", range(501, 1002): "held"}
"""What SELECT meant, by the samples of it: a press, or 5 s as the lock-out asks for."""
Lines = tuple[str, str]


class Machine(SimpleNamespace):
    """What the menu shows (hosted_menu.PLACES), what is stored, and what it was told."""

    told: list[str]

    def tell(self, order: str, **then: Any) -> bool:
        """Return whether it can be done; then that is so."""
        self.told.append(order)
        vars(self).update(then if self.answer else {})
        return bool(self.answer)

    def name_of(self, number: int) -> str:
        stored = self.stored[number - 1]
        return f"{number} {stored[0] if stored else '(empty)'}"


def number(value: float, decimals: int = 0) -> str:
    size = np.float32(min(abs(value), 20e6))
    for _ in range(decimals):
        size *= np.float32(10)
    counts = int(float(size) + 0.5)
    digits = f"{counts:0{decimals + 1}d}"
    point = f".{digits[-decimals:]}" if decimals else ""
    return f"{'-' if value < 0 and counts else ''}{digits[: len(digits) - decimals]}{point}"


def celsius(value: float) -> str:
    return f"{number(value)}°C"


def tenth(value: int) -> float:
    return float(np.float32(value) * np.float32(0.1))


def time(steps: int) -> str:
    minutes = steps * PERIOD_MS // 60_000
    return f"{minutes // 1440}d{minutes // 60 % 24:02}h{minutes % 60:02}m"


def turned(now: int, least: int, most: int, by: int) -> int:
    """Return the next choice, round both ends; one that is no more goes on at the least."""
    return (now + 1 if now < most else least) if by > 0 else (now - 1 if now > least else most)


def limited(value: float, least: float, most: float) -> float:
    return max(least, min(most, value))


class State:
    def __init__(self, machine: Machine) -> None:
        self.m = machine
        self.refused = False
        self.leave()

    def leave(self) -> None:
        """Forget what is not done."""

    def lines(self) -> Lines:
        m = self.m
        felt = celsius(m.felt_c) if m.has_reading else "--°C"
        first = f"{felt} >{celsius(m.program_c if m.state else m.setpoint_c)}"
        does = {PAUSED: " paused", RETURNING: " returning"}.get(m.state, WAITS[m.waiting])
        special = {IDLE: "on" if m.is_on else ENDED[m.ended], RESTORING: "power was cut"}
        return first, special.get(m.state, f"{m.segment}/{m.segments}{does}")

    def key(self, key: str, by: int, steps: int) -> bool:  # noqa: ARG002
        """Say whether the screen has a use for the key: UP or DOWN `by` so many `steps`."""
        return key == "select" and self.m.waiting == 3 and self.m.tell("skip")


class Times(State):
    def lines(self) -> Lines:
        return f"All  {time(self.m.clock)}", f"Seg. {time(self.m.segment_clock)}"


class Run(State):
    """To start a program, and what is asked of one that runs."""

    def leave(self) -> None:
        self.number, self.choice, self.asked, self.refused = 1, 0, "", False

    def _named(self, *names: str) -> str:
        first = names[self.m.state == PAUSED], *names[2:4]
        return first[self.choice] if self.choice < 3 else f"{names[4]} {self.choice - 2}"

    def lines(self) -> Lines:
        if self.m.state == IDLE:
            second = self.m.name_of(self.number)
            first = "SELECT: start" if self.asked == "start" else "Start program?"
        else:
            second = self._named("pause", "resume", "skip segment", "stop", "go to")
            first = "SELECT does it" if self.asked == "do" else "Program:"
        return "not possible" if self.refused else first, second

    def key(self, key: str, by: int, steps: int) -> bool:  # noqa: ARG002
        m = self.m
        if key == "select":
            self._select("do" if m.state else "start")
        else:
            self.asked, self.refused = "", False
            if m.state == IDLE:
                self.number = turned(self.number, 1, PROGRAMS, by)
            else:
                self.choice = turned(self.choice, 0, 2 + m.segments, by)
        return True

    def _select(self, meant: str) -> None:
        if self.asked != meant and (meant == "start" or self.choice):
            self.asked, self.refused = meant, False
            return
        self.asked = ""
        if meant == "start":
            self.refused = not (self.m.is_saved and self.m.tell(f"start {self.number}"))
        else:
            self.refused = not self.m.tell(self._named("pause", "resume", "skip", "stop", "jump"))


class Edit(State):
    """To change a stored program: it is chosen, then changed place by place, then saved."""

    doing, number = "choose", 1

    def _places(self) -> list[tuple[int, str]]:
        places = [(letter, "letter") for letter in range(12)]
        for index, (kind, _, _) in enumerate((*self.segments, (0, 0, 0))[:POINTS]):
            places += [(index, "kind")] + [(index, "target")] * (kind in WITH_TARGET)
            places += [(index, "amount")] * (kind in (*WITH_TIME, RATE))
        return places

    def lines(self) -> Lines:
        if self.doing == "choose":
            return "Edit program?" if self.m.is_saved else "saving", self.m.name_of(self.number)
        if self.doing == "save":
            return "not possible" if self.refused else "SELECT: save", "LEFT: back"
        index, what = self.place
        if what == "letter":
            return f"Name, letter {index + 1}", f"[{''.join(self.name)}]"
        kind, to_dc, amount = (*self.segments, (0, 0, 0))[index]
        per = f"{number(tenth(amount))} K/h" if kind == RATE else f"{number(amount // 60)} min"
        shown = {"kind": KINDS[kind], "target": f"to {celsius(tenth(to_dc))}", "amount": per}
        return f"Segment {index + 1}", shown[what]

    def key(self, key: str, by: int, steps: int) -> bool:
        if self.doing == "choose":
            if key == "select":
                name, segments = self.m.stored[self.number - 1] or ("new", [])
                self.name, self.segments = list(name.ljust(12)), list(segments)
                self.doing, self.place = "change", (0, "letter")
            elif by:
                self.number = turned(self.number, 1, PROGRAMS, by)
            return key == "select" or by != 0
        if self.doing == "save":
            self._save(key)
        elif key == "select":
            is_name = self.place[1] == "letter"
            self.doing, self.place = ("change", (0, "kind")) if is_name else ("save", self.place)
        elif by:
            self._change(by, steps)
        else:
            places = self._places()
            at = places.index(self.place) + (1 if key == "right" else -1)
            self.doing = "choose" if at < 0 else "change"
            self.place = places[int(limited(at, 0, len(places) - 1))]
        return True

    def _save(self, key: str) -> None:
        if key == "left":
            self.doing, self.refused = "change", False
        elif key == "select":
            name = self.name[0] + "".join(self.name[1:]).rstrip()
            parts = "".join(f" {kind}/{to}/{amount}" for kind, to, amount in self.segments)
            stored = list(self.m.stored)
            stored[self.number - 1] = (name, list(self.segments)) if self.segments else None
            order = f"write {self.number} [{name}]{parts}"
            self.refused = not self.m.tell(order, stored=stored)
            self.doing = "save" if self.refused else "choose"

    def _change(self, by: int, steps: int) -> None:
        index, what = self.place
        if what == "letter":
            at = LETTERS.index(self.name[index]) + by
            self.name[index] = LETTERS[at % len(LETTERS)]
            return
        before = self.segments[index - 1][1] if index else 0
        kind, to_dc, amount = (*self.segments, (0, before, 0))[index]
        least_dc, most_dc = (int(10 * each) for each in SETPOINTS_C)
        if what == "target":
            to_dc = int(limited(to_dc + by * steps * 10 * STEP_K, least_dc, most_dc))
        elif what == "amount":
            fine, most = (10, 65535) if kind == RATE else (60, 31 * 24 * 3600)
            amount = int(limited(amount + by * steps * fine, fine, most))
        else:
            kind = (kind + by) % len(KINDS)
            to_dc = max(to_dc, least_dc) if kind in WITH_TARGET else 0
            amount = 1000 if kind == RATE else 3600 if kind in WITH_TIME else 0
        end = index + 1 if kind else None
        self.segments[index:end] = [(kind, to_dc, amount)] if kind else []


class Values(State):
    entry = 0

    def leave(self) -> None:
        self.title, self.refused = "Setpoint", False
        self.wanted: float | None = None

    def _now(self) -> Any:
        now = getattr(self.m, VALUES[self.title] or "is_on")
        now = 3 if self.title == "Thermocouple" and now not in TYPES else now
        return now if self.wanted is None else self.wanted

    def lines(self) -> Lines:
        m, now = self.m, self._now()
        fault = "none"
        if self.entry < len(m.entries):
            code, felt_c, seconds = m.entries[self.entry]
            fault = f"E{code} {celsius(felt_c)} {number(seconds // 60)}m"
        shown = {
            "Hold setpoint?": "on" if now else "off",
            "Thermocouple": TYPES.get(now, ""),
            "Energy": f"{number(np.float32(m.energy) * KWH_PER_COUNT, 2)} kWh",
            "EEPROM saves": number(m.saves),
            "Faults so far": fault,
        }
        shown |= {title: celsius(now) for title in ("Setpoint", "Trips at")}
        first = self.title if self.wanted is None else "SELECT: keep"
        return "not possible" if self.refused else first, shown.get(self.title) or number(now, 3)

    def key(self, key: str, by: int, steps: int) -> bool:  # noqa: ARG002
        if by:
            self.refused = False
            self._move(by, by * steps * STEP_K)
        elif self.wanted is not None:
            self.refused, self.wanted = not self._keep(self.wanted), None
        elif self.refused:
            self.refused = False
        else:
            titles = list(VALUES)
            self.title = titles[(titles.index(self.title) + 1) % len(titles)]
        return True

    def _move(self, by: int, moved_k: int) -> None:
        m, now = self.m, self._now()
        match self.title:
            case "Setpoint":
                moved = limited(now + moved_k, *SETPOINTS_C)
                self.refused = not m.tell(f"setpoint {moved:.9g}", setpoint_c=moved)
            case "Hold setpoint?" if by > 0:
                self.wanted = None if m.is_on else 1
            case "Hold setpoint?" if m.state != IDLE:
                self.refused = True
            case "Hold setpoint?":
                self.wanted = None
                m.tell("off", is_on=0)
            case "Trips at":
                self.wanted = limited(now + moved_k, SETPOINTS_C[0], MAXIMUM_C)
            case "Thermocouple":
                codes = list(TYPES)
                self.wanted = codes[(codes.index(now) + by) % len(codes)]
            case "Faults so far":
                self.entry = (self.entry + by) % 8
            case "Kp %/K" | "Ki %/(Ks)" | "Kd %s/K":
                self.wanted = gain(now, by)

    def _keep(self, wanted: float) -> bool:
        m, name = self.m, VALUES[self.title]
        orders = {"is_on": "on", "maximum_c": f"maximum {wanted:.9g}", "type": f"type {wanted:.0f}"}
        if name in orders:
            return m.tell(orders[name], **{name: wanted})
        setattr(m, name, wanted)
        return m.tell(f"keep {m.kp:.9g} {m.ki:.9g} {m.kd:.9g}") or True


def gain(now: float, by: int) -> float:
    least, factor = np.float32(0.001), np.float32(1.05)
    if by > 0:
        return min(float(least if np.float32(now) < least else np.float32(now) * factor), 1e6)
    moved = np.float32(now) * (np.float32(1) / factor)
    return 0.0 if moved < least else float(moved)


class Menu:
    """The screens in the order of RIGHT."""

    def __init__(self, machine: Machine) -> None:
        self.m = machine
        self._screens = [kind(machine) for kind in (State, Times, Run, Edit, Values)]
        self._at = 0
        self.shown: Lines = ("", "")
        self._shown_fault = 0

    def look(self) -> None:
        """Show at once what has been latched, or has gone: the loop's steps are rare."""
        if self.m.fault != self._shown_fault:
            self.refresh()

    def refresh(self) -> None:
        self._shown_fault = self.m.fault
        first, second = self._screens[self._at].lines()
        if self.m.fault:
            second = "E?? NO SUCH CODE"  # damaged memory
            if self.m.fault <= len(FAULTS) and self.m.fault not in OF_OTHERS:
                words = "HOLD SELECT" if self.m.trips >= 3 else FAULTS[self.m.fault - 1]
                second = f"E{self.m.fault:02} {words}"
        self.shown = f"{first:16.16}", f"{second:16.16}"

    def press(self, key: str, repeats: int) -> None:
        """Do what a key does that is down for the first time, or again: coarsely after 20 times."""
        by, along = {"up": 1, "down": -1}.get(key, 0), {"right": 1, "left": -1}.get(key, 0)
        screen, steps = self._screens[self._at], 10 if repeats >= 20 else 1
        if (repeats and not by) or (self.m.fault > 0) != (key in LET_GO.values()):
            return
        if self.m.fault:
            self.m.tell("release" if key == "held" else "acknowledge", fault=0)
        elif (along and not isinstance(screen, Edit)) or not screen.key(key, by, steps):
            screen.leave()
            self._at = (self._at + along) % len(self._screens)
        self.refresh()


class Keypad:
    """When a key counts: two samples agree; and, held for half a second, each tenth.

    SELECT is also let go, with at least 101 samples of no key before it.
    """

    def __init__(self) -> None:
        self._sample, self._reported, self._since, self.repeats = "", "unknown", 0, 0
        self._alike, self._rested = 0, False

    def tick(self, key: str, fresh: int) -> str:
        """Take what is down by the ADC; return a key that counts now."""
        if fresh:
            before, self._sample = self._sample, key
            if over := self._let_go(before, key):
                self._since = self.repeats = 0
                return over
            if key == before != self._reported and not (self._reported == "unknown" and key):
                self._reported, self._since, self.repeats = key, 0, 0
                return key
        if self._sample != self._reported:
            self._since = self.repeats = 0
            return ""
        self._since += 1
        if self._since < 50 or self._since % 10:
            return ""
        self.repeats = min(self.repeats + 1, 255)
        return self._reported

    def _let_go(self, before: str, key: str) -> str:
        if key == before:
            self._alike += 1
            return ""
        meant = [each for alike, each in LET_GO.items() if self._alike in alike]
        over = meant[0] if meant and before == "select" and self._rested else ""
        self._rested = not before and self._alike > 100
        self._alike = 1
        return over
