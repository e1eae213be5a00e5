"""Compare the firmware's count of trips for a lock-out with the model, step by step of a log.

The log shows the inputs: the fault's code shows the trips, and a count the acknowledgements. Only
a person with keys can acknowledge a locked-out fault, or anybody after a loss of power and a wait.
After several events within one step, or a reset, the firmware's count is taken over.
"""

from collections.abc import Iterator
from typing import NamedTuple

from heatwright.sim.reference.numbers import SECOND_US, period_us
from heatwright.sim.reference.protection.latch import Lockout
from heatwright.sim.tape import Tape
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller, facts_of

TRIPS = "fault.trips"


class Miscount(NamedTuple):
    """A row whose count differs from the model's."""

    row: int
    expected: str
    actual: str


def miscounts(controller: Controller, log: StepLog, loop: str) -> Iterator[Miscount]:
    """Yield the rows in which the firmware's count of trips differs from the model's.

    Raises KeyError: there is no such loop.
    """
    spec = controller.lockout
    if spec is None or TRIPS not in (log.dtype.names or ()):
        return
    step_us = period_us(controller.loops[loop])
    by_keys = facts_of(controller).keypad is not None
    told = log["fault.time_s"].tolist() if "fault.time_s" in (log.dtype.names or ()) else None
    tape, model, steps, latched = Tape(log), Lockout(controller), 0, 0
    locked_since_reset = False
    for row, (code, trips) in enumerate(zip(tape.fault_code, log[TRIPS].tolist(), strict=True)):
        begins, acknowledged = tape.begins[row], tape.acknowledged[row]
        steps = 1 if begins else steps + 1
        now_us = steps * step_us
        at_us = now_us if told is None else told[row] * SECOND_US
        if acknowledged and model.is_locked and not begins:
            if not by_keys and (locked_since_reset or now_us < spec.wait_s * SECOND_US):
                yield Miscount(row, "locked out", "acknowledged")
            model.trips = 0
        if begins:
            model = Lockout(controller)
            model.count(code, at_us if at_us <= now_us else 0)
            locked_since_reset = False
        elif code and (acknowledged or not latched):
            model.count(code, at_us)
            locked_since_reset = model.is_locked
        if begins:
            model.trips = trips  # events within the step are not in the log
        elif acknowledged > bool(latched):
            model.take(trips, at_us)
        model.age(now_us)
        if model.trips != trips:
            yield Miscount(row, str(model.trips), str(trips))
            model.trips = trips
        latched = code
