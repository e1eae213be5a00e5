"""HAL of the loops: converters, the latch of ON, the test that the slave answers."""

from dataclasses import dataclass

from heatwright.generator.plan.linuxcnc.bus import answer_within_s, lost_after_s, rate_hz
from heatwright.generator.plan.linuxcnc.names import controller_name, loop_names
from heatwright.generator.plan.source import Source
from heatwright.spec import ModbusRtu, facts_of

UPTIME_S = 1.0
"""Step of the slave's uptime, which shows that the slave answers."""
ROUNDS, STEPS = 3, 2
"""Rounds and control steps until a command has arrived and its effect can be read."""
LOST_ANSWERS = 2
"""Answers that may be lost meanwhile: mb2hal waits for each until the time-out."""
DECIMALS = 3


@dataclass(frozen=True, slots=True)
class HalLoop:
    """A loop, with its names and numbers in HAL."""

    loop: str
    name: str
    where: str
    initial: str
    current: bool


@dataclass(frozen=True, slots=True)
class HalNames:
    """The values for the HAL files, except the panel's."""

    name: str
    file: str
    where: str
    digest: str
    digest_high: int
    digest_low: int
    loops: list[HalLoop]
    heard_s: str
    obeyed_s: str


def hal_names(source: Source, interface: ModbusRtu) -> HalNames:
    """Compute the values for the HAL files."""
    controller, names = source.controller, loop_names(source.controller)
    round_s = 1 / rate_hz(source, interface)
    return HalNames(
        name=controller_name(controller),
        file=controller.identity.name,
        where=source.where,
        digest=source.spec.digest,
        digest_high=int(source.spec.digest, 16) >> 16,
        digest_low=int(source.spec.digest, 16) & 0xFFFF,
        loops=[
            HalLoop(
                loop=loop,
                name=names[loop],
                where=Source(source.spec, ("loops", loop)).where,
                initial=f"{control.setpoint.initial_c:g}",
                current=facts_of(controller, loop).current is not None,
            )
            for loop, control in controller.loops.items()
        ],
        heard_s=_seconds(max(lost_after_s(controller), UPTIME_S + ROUNDS * round_s)),
        obeyed_s=_seconds(
            ROUNDS * round_s
            + STEPS * controller.longest_period_s
            + LOST_ANSWERS * answer_within_s(interface)
        ),
    )


def _seconds(duration_s: float) -> str:
    return f"{round(duration_s, DECIMALS):g}"
