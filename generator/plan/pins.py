"""Pins: their registers, and the inline functions that pins.h has for each."""

from heatwright.generator.plan.parts import PinFunction, PinPlan
from heatwright.generator.plan.source import Source
from heatwright.spec.boards import Pin

FAR_PORTS = "HJKL"
"""Ports that `sbi` and `cbi` cannot reach: a change takes several instructions."""


def _mask(pin: Pin) -> str:
    return f"(1u << {pin.bit})"


def _set(register: str, pin: Pin) -> str:
    return f"{register}{pin.port} |= {_mask(pin)};"


def _clear(register: str, pin: Pin) -> str:
    return f"{register}{pin.port} &= (uint8_t)~{_mask(pin)};"


def _change(pin: Pin, name: str, *statements: str) -> PinFunction:
    return PinFunction(name, "void", statements, pin.port in FAR_PORTS)


def _test(pin: Pin, name: str, comparison: str) -> PinFunction:
    return PinFunction(
        name, "bool", (f"return (PIN{pin.port} & {_mask(pin)}) {comparison} 0;",), False
    )


def _obeys(pin: Pin, pulses: str) -> PinFunction:
    looked = f"const uint8_t levels = PIN{pin.port};"
    same = f"((levels ^ PORT{pin.port}) & {_mask(pin)}) == 0"
    answer = f"return {same}{pulses and f' || {pulses} != 0'};"
    return PinFunction("obeys", "bool", (looked, answer), False)


def label(pin: Pin) -> str:
    """Name a pin for people: `D3 = PD3`, or `PD3` on a bare chip."""
    return pin.name if pin.name == pin.port_name else f"{pin.name} = {pin.port_name}"


def _pin(source: Source, name: str, pin: Pin, purpose: str, *functions: PinFunction) -> PinPlan:
    return PinPlan(name, label(pin), purpose, source.where, functions)


def switched(  # noqa: PLR0913 - all values of one pin
    source: Source,
    name: str,
    pin: Pin,
    active: str,
    purpose: str,
    *,
    released: bool = False,
    read_back: bool = False,
    pulses: str = "",
) -> PinPlan:
    """Plan an output that is on or off, with either active level.

    released -- it can be turned into an input; read_back -- its level is compared with its pin,
    except while the condition `pulses` is not 0.
    """
    on, off = (_set, _clear) if active == "high" else (_clear, _set)
    release = (_change(pin, "release", _clear("DDR", pin)),) if released else ()
    return _pin(
        source,
        name,
        pin,
        f"{purpose}, active {active}",
        _change(pin, "on", on("PORT", pin)),
        _change(pin, "off", off("PORT", pin)),
        _change(pin, "drive", _set("DDR", pin)),
        *release,
        _test(pin, "is_on", "!=" if active == "high" else "=="),
        *((_obeys(pin, pulses),) if read_back else ()),
    )


def driven(source: Source, name: str, pin: Pin, purpose: str) -> PinPlan:
    """Plan an output that is high or low."""
    return _pin(
        source,
        name,
        pin,
        purpose,
        _change(pin, "high", _set("PORT", pin)),
        _change(pin, "low", _clear("PORT", pin)),
        _change(pin, "drive", _set("DDR", pin)),
    )


def pulled_up(source: Source, name: str, pin: Pin, purpose: str) -> PinPlan:
    """Plan an input with a pull-up, so that it does not float when nothing is plugged in."""
    return _pin(source, name, pin, purpose, _change(pin, "pull_up", _set("PORT", pin)))


def lifted(source: Source, name: str, pin: Pin, purpose: str) -> PinPlan:
    """Plan an input that a chip drives; the pull-up makes it high while nothing drives it."""
    return _pin(
        source,
        name,
        pin,
        purpose,
        _change(pin, "pull_up", _set("PORT", pin)),
        _test(pin, "is_high", "!="),
    )


def contact(source: Source, name: str, pin: Pin, purpose: str) -> PinPlan:
    """Plan an input for a contact to ground; direction and pull-up are written together."""
    return _pin(
        source,
        name,
        pin,
        f"contact of {purpose}: low is closed",
        _change(pin, "listen", _clear("DDR", pin), _set("PORT", pin)),
        _test(pin, "is_high", "!="),
    )


def open_drain(source: Source, name: str, pin: Pin, purpose: str) -> PinPlan:
    """Plan a line with a pull-up resistor, pulled low or released; its PORT bit stays 0."""
    return _pin(
        source,
        name,
        pin,
        purpose,
        _change(pin, "low", _set("DDR", pin)),
        _change(pin, "release", _clear("DDR", pin)),
        _test(pin, "is_high", "!="),
    )
