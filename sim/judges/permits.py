"""Why a heater is off at this moment: which permit of the gate is missing (gate.c).

This is read from the running binary, and from the pins that the gate itself reads.
"""

from collections.abc import Iterator
from typing import NamedTuple

from heatwright.sim.device import AvrDevice
from heatwright.spec import RULES, Controller


class Missing(NamedTuple):
    """One reason why a heater is off: an id, and a sentence for the user."""

    id: str
    text: str


def missing(device: AvrDevice, controller: Controller, loop_name: str) -> tuple[Missing, ...]:
    """Return the reasons why the heater of a loop is off now; none while it is on."""
    if device.outputs[controller.loops[loop_name].heater].on:
        return ()
    found = [*_of_all(device), *_of_loop(device, controller, loop_name)]
    return tuple(found or [_other_reason(device, controller, loop_name)])


def _of_all(device: AvrDevice) -> Iterator[Missing]:
    """Yield the missing permits of all heaters."""
    code = int(device.read("fault.code"))
    if code:
        rule = RULES.get(code)
        what = f"{rule.id}: {rule.meaning}" if rule else f"{code}, which no rule has"
        yield Missing("fault", f"A fault is latched, {what}")
    if not device.read("gate.c:main_ticks"):
        yield Missing("main_loop", "The main loop no longer runs: its permit has expired.")
    opened = [name for name, contact in device.contacts.items() if contact.is_open]
    for name in opened:
        yield Missing("input", f"The contact {name} is open.")
    if device.contacts and not opened and device.read("gate.c:input_ticks"):
        yield Missing("input", "A contact was open until a moment ago.")


def _of_loop(device: AvrDevice, controller: Controller, loop_name: str) -> Iterator[Missing]:
    """Yield the missing permits of this loop's heater."""
    loop = controller.loops[loop_name]
    enabled = f"loop_{loop_name}.enabled"
    if enabled in device.variables and not device.read(enabled):
        yield Missing("switched_off", f"{loop_name} is switched off.")
    elif not device.read(f"gate.c:{loop_name}_ticks"):
        yield Missing("step", "No control step has renewed the loop's permit.")
    if device.read(f"loop_{loop_name}.missing"):
        yield Missing("reading", f"There is no fresh reading of {loop.sensor}.")
    if loop.fan is not None and not device.outputs[loop.fan].on:
        yield Missing("fan", f"The fan {loop.fan} is off.")
    if loop.fan in device.proofs and device.read(f"proof_{loop.fan}.c:still_ticks"):
        yield Missing("fan", f"The signal that fan {loop.fan} turns is missing.")
    if loop.cooler is not None and device.outputs[loop.cooler].on:
        yield Missing("cooler", f"The cooler {loop.cooler} is on.")


def _other_reason(device: AvrDevice, controller: Controller, loop_name: str) -> Missing:
    """Return the reason if no other was found: no reading, no duty, the relay, or a pulse's end."""
    if not device.read(f"gate.c:{loop_name}_sensor_ticks"):
        return Missing("step", "No control step with a reading has renewed the loop's permit.")
    duty_percent = float(device.read(f"loop_{loop_name}.duty_percent"))
    if not duty_percent > 0:
        return Missing("duty", "The control asks for no heat; no permit is missing.")
    if device.relay is not None and not device.relay.closed:
        return Missing("relay", f"The safety relay {controller.safety.relay} is open.")
    return Missing("pause", f"The duty is {duty_percent:.0f} %: the heater is between two pulses.")
