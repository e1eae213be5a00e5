"""Whether an output makes of every duty what the reference does, and drives its pin for as long."""

from heatwright.sim.host import Host
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.output import heater_of
from heatwright.spec import TimeProportionalOutput

FINE = [each / 1000 for each in range(0, 1500, 7)]
DUTIES = [
    *(each / 8 for each in range(801)),
    *FINE,
    *(100 - each for each in FINE),
    99.999,
    *(place + each / 200 for place in (0, 99.6) for each in range(81)),
]
"""Closer together at both ends, where pulses and pauses become too short to be made."""


def output_problem(host: Host) -> str:
    """Say what is wrong, first of all with the counts; empty if nothing."""
    controller = host.build.controller
    ((_, loop),) = controller.loops.items()
    reference = heater_of(controller, loop.heater)
    output = controller.outputs[loop.heater]
    ticks, ticks_per_count = 1, 1
    if isinstance(output, TimeProportionalOutput):
        ticks, ticks_per_count = round(output.window_s * 100), round(output.resolution_s * 100)
    host.erase()
    host.power_up()
    put = getattr(host.library, f"output_{loop.heater}_set")
    tick = getattr(host.library, f"output_{loop.heater}_tick")
    for duty in DUTIES:
        reference.apply(Single(duty))
        put(duty)
        on = 0
        for _ in range(ticks):
            tick(True)
            on += host.library.host_heater()
        if on != reference.counts * ticks_per_count:
            return f"{duty} % drives the heater for {on}, not {reference.counts}"
        if ticks == 1:
            tick(False)
            if host.library.host_heater():
                return f"{duty} % drives the heater although the gate is closed"
    return ""
