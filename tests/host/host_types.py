"""Whether the chosen type of thermocouple lowers what may be asked for (docs/language.md)."""

from collections.abc import Iterator

import numpy as np
from host_scale import scale_of

from heatwright.sim.host import Host
from heatwright.spec import Controller
from heatwright.spec.sensing.max31856 import TYPE_CODES, lowered

DAMAGED = 0xFF
"""A code that nobody can choose: as the type that bears the least."""
MILD_C = 30.0


def types_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing, or if all types bear the same."""
    controller, parts = host.build.controller, host.build.parts
    loop = controller.loops[parts.name]
    setpoint_c, maximum_c = loop.setpoint.maximum_c, loop.protection.maximum_c
    less = lowered(controller.sensors[parts.sensor], setpoint_c, maximum_c)
    if not less:
        return ""
    types = controller.thermometers[parts.sensor].selectable
    borne = {TYPE_CODES.index(kind): less.get(kind, setpoint_c) for kind in types}
    borne[DAMAGED] = min(less.values())
    above_k = maximum_c - setpoint_c
    checks = [_Chosen(host, code, c, c + above_k) for code, c in borne.items()]
    return next((problem for check in checks for problem in check.problems()), "")


class _Chosen:
    """One type is chosen; highest_c -- what may be asked for; hottest_c -- what is too hot."""

    def __init__(self, host: Host, code: int, highest_c: float, hottest_c: float) -> None:
        self.host, self.code = host, code
        self.parts, self.controller = host.build.parts, host.build.controller
        self.highest, self.hottest = np.float32(highest_c), np.float32(hottest_c)

    def problems(self) -> Iterator[str]:
        self._power_up(MILD_C)
        found = self.host.step()
        for name, wanted in (("setpoint_c", self.highest), ("guard.maximum_c", self.hottest)):
            if found[name] != wanted:
                yield f"type {self.code}: {name} is {found[name]}, not {wanted}"
        library, loop = self.host.library, self.parts.name
        may_set = getattr(library, f"loop_{loop}_may_set")
        set_maximum = getattr(library, f"guard_{loop}_set_maximum")
        for name, may, most in (
            ("setpoint", may_set, self.highest),
            ("maximum", set_maximum, self.hottest),
        ):
            if not may(most) or may(np.nextafter(most, np.float32(np.inf))):
                yield f"type {self.code}: a {name} of {most} is not the highest"
        if self.parts.programmed:
            yield from self._starts()

    def _power_up(self, celsius: float) -> None:
        """As if the type had been chosen when more was asked for."""
        host, loop = self.host, self.controller.loops[self.parts.name]
        host.erase()
        host.power_up()
        settings = host.library.settings
        setattr(settings, f"{self.parts.sensor}_thermocouple", self.code)
        setattr(settings, f"{self.parts.name}_setpoint_c", loop.setpoint.maximum_c)
        setattr(settings, f"{self.parts.name}_maximum_c", loop.protection.maximum_c)
        host.library.settings_seal()
        host.set_reading(0, scale_of(self.controller).code(celsius))

    def _starts(self) -> Iterator[str]:
        """Programs that are too hot do not start, and none does from where it is too hot."""
        for number, hottest_c in enumerate(_hottest(self.controller), start=1):
            for celsius in (MILD_C, float(self.highest) - 1, float(self.highest) + 1):
                self._power_up(celsius)
                self.host.step()
                started = bool(self.host.library.program_start(number))
                if started != (max(hottest_c, celsius) <= self.highest):
                    yield f"type {self.code}: program {number} from {celsius} °C: {started}"


def _hottest(controller: Controller) -> Iterator[float]:
    """Yield the hottest target of each stored program."""
    assert controller.programs is not None
    for program in controller.programs.stored:
        yield max((each.to_c for each in program.segments if each.to_c is not None), default=0.0)
