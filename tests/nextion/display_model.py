"""What the display's orders change, and what its pages show, told from docs/nextion.md alone."""

import re
from collections.abc import Mapping, Sequence
from decimal import ROUND_HALF_UP, Context, Decimal

from heatwright.spec.nextion.parts import AMBER, FIELD, GREEN

Segment = tuple[int, int, int]
"""Kind, target in tenths of a degree, amount in seconds or tenths of a kelvin per hour."""
OVER, RATE, FAST, HOLD, UNTIL = range(1, 6)
KINDS = (OVER, RATE, FAST, UNTIL, HOLD)
"""By their number in an order."""
TARGETED = (OVER, RATE, FAST)
POINTS, HIGHEST_DC, LONGEST_S, FASTEST = 10, 11_000, 31 * 86_400, 65_535
MOST_HUNDREDTHS, MOST_TENTHS, MOST_DIGITS = 99_999_999, 32_767, 9
NUMBER = re.compile(r"-?([0-9]+\.?[0-9]*|\.[0-9]+)")
EXACT = Context(prec=400)
WORDS = {OVER: "time", RATE: "K/h", FAST: "fast", HOLD: "hold", UNTIL: "until"}
RUNS = ("runs", "held back", "waits for temperature", "waits for the operator")
STATES = {2: "paused", 3: "returns to its setpoint", 5: "paused by a fault"}
ENDS = ("off", "finished", "stopped", "stopped by a fault")


def scaled(text: str, decimals: int) -> int | None:
    """A number in units of its last decimal, rounded half away from zero; none if it is not one."""
    if NUMBER.fullmatch(text) is None:
        return None
    exact = EXACT.scaleb(EXACT.create_decimal(text), decimals)
    if abs(int(exact)) >= 10**MOST_DIGITS:
        return None
    return int(exact.to_integral_value(ROUND_HALF_UP))


def whole(text: str, most: int) -> int | None:
    return int(text) if re.fullmatch("[0-9]+", text) and int(text) <= most else None


def changed_by(before: Sequence[Segment], text: str) -> list[Segment] | None:
    """A program after order 7; none where the order is refused."""
    after = list(before)
    *points, rest = text.split(":")
    for fields in (point.split(",") for point in points):
        if len(fields) not in {3, 4}:
            return None
        number, kind = whole(fields[0], POINTS + 1), whole(fields[3:][0] if fields[3:] else "0", 4)
        amount, target = amount_of(fields[1], is_rate=kind == 1), scaled(fields[2], 1)
        if number is None or kind is None or amount is None or target is None:
            return None
        possible = 0 <= amount <= MOST_HUNDREDTHS and abs(target) <= MOST_TENTHS
        if not possible or not 1 <= number <= len(after) + 1:
            return None
        if kind == amount == target == 0:
            del after[number - 1 :]
        elif number > POINTS:
            return None
        else:
            after[number - 1 : number] = [made(after[: number - 1], KINDS[kind], amount, target)]
    return after if points and not rest and all(map(is_sound, after)) else None


def amount_of(text: str, *, is_rate: bool) -> int | None:
    """A time in hundredths of a minute, or a rate; a time may have its hours before an `h`."""
    hours, h, minutes = text.partition("h")
    amount = scaled(hours, 2)
    if not h:
        return amount
    rest = scaled(minutes, 2) if minutes else 0
    if is_rate or amount is None or rest is None or amount < 0 or amount % 100:
        return None
    return 60 * amount + rest if 0 <= rest < 6000 else None


def made(before: Sequence[Segment], kind: int, amount: int, target: int) -> Segment:
    """A segment behind others: to where they lead already, it is a hold."""
    seconds = (6 * amount + 5) // 10
    led_to = [to for other, to, _ in before if other in TARGETED]
    if kind == HOLD or (kind == OVER and led_to[-1:] == [target]):
        return HOLD, 0, seconds
    amounts = {OVER: seconds, RATE: (amount + 5) // 10}
    return kind, target if kind in TARGETED else 0, amounts.get(kind, 0)


def is_sound(segment: Segment) -> bool:
    kind, target, amount = segment
    most = {OVER: LONGEST_S, HOLD: LONGEST_S, RATE: FASTEST}.get(kind)
    return 0 <= target <= HIGHEST_DC and (most is None or 1 <= amount <= most)


def segments_of(state: Mapping[str, str]) -> list[Segment]:
    """The program that is shown."""
    return [
        (int(kind), int(target), int(amount))
        for kind, target, amount in (each.split("/") for each in state["points"].split(",")[:-1])
    ]


# -- pages


def screens(state: Mapping[str, str], names: Mapping[int, str]) -> dict[str, str]:
    """All attributes that pages are told while a state lasts. names -- of programs, by place."""
    kwh = Decimal(state["energy"]) * 484 / 1000 / 3600 / 1000
    fault, letter, duty = int(state["fault"]), "BEJKNRST"[int(state["type"])], state["duty"]
    found: dict[str, object] = {
        "main.temp.val": rounded(state["temperature"]), "main.set.val": rounded(state["target"]),
        "main.duty.val": rounded(duty), "main.programm.val": state["shown"],
        "main.point.val": state["segment"], "main.pname.txt": state["name"],
        "main.state.txt": _state(state), "main.bt1.val": int(state["state"] in "13"),
        "main.energy.txt": f"{rounded(kwh, 2)} kWh", "main.ERROR.en": int(fault != 0),
        "main.alarm.txt": f"E{fault:02d}" if fault else "", "points.programm.val": state["shown"],
        "points.pname.txt": state["name"], "settings.sp.txt": rounded(state["setpoint"], 1),
        "settings.crit.txt": rounded(state["maximum"], 1), "settings.type.txt": letter,
        "settings.saves.val": state["saves"], "thermo.type.txt": letter,
        "debug.ot.val": rounded(duty), "debug.t.txt": rounded(state["temperature"], 1),
        "debug.settled.val": rounded(state["settled"]), "debug.over.txt": rounded(state["over"], 1),
        "debug.on.val": state["works"], "debug.sp.txt": rounded(state["target"], 1),
    }  # fmt: skip
    for clock, number in (("clock", ""), ("passed", "2")):
        minutes = int(state[clock]) // 60
        found[f"main.day{number}.val"] = minutes // 1440
        found[f"main.hour{number or 1}.val"] = minutes // 60 % 24
        found[f"main.minute{number or 1}.val"] = minutes % 60
    for gain in ("kp", "ki", "kd"):
        value = Decimal(state[gain])
        places = 6 if value < 10 else 4 if value < 1000 else 2 if value < 100_000 else 0
        found[f"debug.{gain}.txt"] = short(rounded(value, places))
    found |= {f"programs.name{place}.txt": name for place, name in names.items()}
    for row in range(1, POINTS + 1):
        found |= {f"points.{name}": value for name, value in _row(state, row).items()}
    return {name: str(value) for name, value in found.items()}


def _state(state: Mapping[str, str]) -> str:
    number = int(state["state"])
    if number:
        return RUNS[int(state["waiting"])] if number == 1 else STATES[number]
    if state["works"] == "1":
        return "by hand" if state["mode"] == "1" else "on"
    return ENDS[int(state["ended"])]


def _row(state: Mapping[str, str], row: int) -> dict[str, object]:
    """A segment, or none."""
    runs = state["state"] != "0" and state["number"] == state["shown"]
    running, marked = runs and state["segment"] == str(row), state["marked"] == str(row)
    kind, target, amount = [*segments_of(state), *POINTS * [(0, 0, 0)]][row - 1]
    amounts = {RATE: Decimal(amount) / 10, **dict.fromkeys((OVER, HOLD), Decimal(amount) / 60)}
    return {
        f"p{row}.bco": AMBER if marked else GREEN if running else FIELD,
        f"k{row}.txt": WORDS.get(kind, ""),
        f"m{row}.txt": _amount(kind, rounded(amounts[kind], 2)) if kind in amounts else "",
        f"t{row}.txt": short(Decimal(target) / 10) if kind in TARGETED else "",
    }


def _amount(kind: int, amount: Decimal) -> str:
    """A rate, or hours and minutes, these with two digits."""
    if kind == RATE:
        return short(amount)
    hours, minutes = divmod(amount, 60)
    return f"{hours}h{'0' * (minutes < 10)}{short(minutes)}"


def rounded(value: str | Decimal, decimals: int = 0) -> Decimal:
    found = Decimal(value).quantize(Decimal(1).scaleb(-decimals), ROUND_HALF_UP)
    return found if found else abs(found)


def short(value: Decimal) -> str:
    """Without the zeros at the end."""
    return f"{value.normalize():f}"
