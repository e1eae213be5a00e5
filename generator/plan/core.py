"""The parts of every firmware: start, clock, gate, latched fault."""

from __future__ import annotations

from dataclasses import dataclass

from heatwright.generator.plan.loop.names import LoopSummary
from heatwright.generator.plan.numbers import TICK_MS, c_float, quantity, steps
from heatwright.generator.plan.parts import Call, Constant, Group, Part, Stage, pair
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.text import derivation_words
from heatwright.generator.plan.timers import compare_match, registers
from heatwright.spec import Controller, Loop, Rule, facts_of
from heatwright.spec.board.timers import looks, tick_interval
from heatwright.spec.outputs import is_held
from heatwright.spec.rules import NO_LOCKOUT

GATE_MAIN_PERMIT_TICKS = 10
MOST_PERMIT_TICKS = 65_535
"""Largest count of the gate's 16-bit counters, more than the longest period; a longer time is
limited to this count, so the heater goes off earlier."""

FAULT_COOLING_ABOVE_C = 50.0
"""Burn threshold of hot metal, 51 degC for a contact of one minute (ISO 13732-1), rounded down."""


def rule_macro(rule: Rule) -> str:
    """The C name of a rule's code."""
    return f"FAULT_{rule.id.upper()}"


WATCHDOG_NAMES = {
    0.015: "15MS", 0.03: "30MS", 0.06: "60MS", 0.12: "120MS", 0.25: "250MS",
    0.5: "500MS", 1.0: "1S", 2.0: "2S", 4.0: "4S", 8.0: "8S",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class ResetNames:
    """The values for the templates of the reset.

    causes -- the register with the cause of a reset; locks_power -- only a loss of power ends a
    lock-out; proves -- the watchdog is tested at each start.
    """

    reset_lines: list[str]
    causes: str
    has_usb: bool
    locks_power: bool
    proves: bool
    checked_where: str


def start(root: Source, reset_lines: list[str]) -> Part:
    """Plan the first and last calls of `start` in main.c, and the first instructions of a reset."""
    controller, facts = root.controller, facts_of(root.controller)
    period = WATCHDOG_NAMES[controller.safety.watchdog_s]
    watchdog = root.at("safety", "watchdog").where
    context = ResetNames(
        reset_lines=reset_lines,
        causes="MCUCSR" if controller.board.is_old else "MCUSR",
        has_usb=controller.board.mcu == "atmega32u4",
        locks_power=controller.lockout is not None and facts.keypad is None,
        proves=facts.proves_watchdog,
        checked_where=root.at("safety", "self_checks").where,
    )
    proves = (Call(Stage.GUARD, "reset.h", "reset_prove_watchdog();"),)
    return Part(
        files=pair("reset", "core/reset", context),
        start_calls=(
            *(proves if facts.proves_watchdog else ()),
            Call(Stage.GUARD, "", f"wdt_enable(WDTO_{period});", f" /* {watchdog} */"),
            Call(Stage.SENSE, "reset.h", "reset_report();"),
            Call(Stage.GO, "", "sei();"),
        ),
    )


@dataclass(frozen=True, slots=True)
class ClockNames:
    """The values for the templates of the clock.

    divider -- timer periods per tick; once -- statements for the start, kept -- for the start and
    each tick; counted -- the fans whose tachometers are sampled.
    """

    timer: int
    vector: str
    divider: int
    once: list[str]
    kept: list[str]
    tick_ms: int
    modbus: bool
    counted: list[str]


def clock(root: Source, timer: int) -> Part:
    """Plan the tick on timer `timer`."""
    board, facts = root.controller.board, facts_of(root.controller)
    interval = tick_interval(board.clock_hz, board.timers[timer], looks(root.controller))
    assert interval is not None  # noqa: S101 - the spec chose a timer that can
    derived = f"{board.clock_hz / 1e6:g} MHz / {interval.prescaler} / {interval.counts}"
    constants = [
        Constant("CLOCK_COMPARE", f"{interval.counts - 1}u", f"timer {timer}: {derived}"),
        Constant("CLOCK_TICKS_PER_SECOND", f"{1000 // TICK_MS}u", f"one tick is {TICK_MS} ms"),
    ]
    if interval.divider > 1:
        constants.append(
            Constant("CLOCK_TIMER_PERIODS", f"{interval.divider}u", "timer periods per tick")
        )
    names = registers(board, timer)
    setup, once = compare_match(names, interval, "CLOCK_COMPARE"), (names.counter, "TIFR")
    context = ClockNames(
        timer=timer,
        vector=names.vector(),
        divider=interval.divider,
        once=[line for line in setup if line.startswith(once)],
        kept=[line for line in setup if not line.startswith(once)],
        tick_ms=TICK_MS,
        modbus=facts.modbus is not None,
        counted=[name for name, each in facts.proofs.items() if each.tachometer],
    )
    return Part(
        files=pair("clock", "core/clock", context),
        groups=(Group(f"Clock of {TICK_MS} ms", tuple(constants)),),
        start_calls=(Call(Stage.GO, "clock.h", "clock_start();"),),
    )


@dataclass(frozen=True, slots=True)
class GateNames:
    """The values for the templates of the gate.

    driven -- the outputs whose pins' directions the gate rewrites; wanting -- the loops that need
    the relay only while they are on; plain -- the on/off outputs without minimum times; counted --
    the fans with a tachometer; pins -- the functions of pins.h that the gate calls.
    """

    loops: list[LoopSummary]
    steppers: list[str]
    driven: list[str]
    relay: str | None
    relay_where: str
    checked: bool
    wanting: list[str]
    plain: list[str]
    inputs: list[str]
    inputs_where: str
    input_trips: bool
    counted: list[str]
    pins: list[str]


def gate(root: Source, loops: list[LoopSummary], steppers: list[str]) -> Part:
    """Plan the heater gate and its permits; the gate also stops steppers and switches the relay."""
    facts = facts_of(root.controller)
    proven = facts.proofs
    fans = [loop.fan for loop in root.controller.loops.values()]
    driven = {root.controller.safety.relay}
    for loop in root.controller.loops.values():
        driven |= {loop.heater, loop.cooler}
    context = GateNames(
        loops=loops,
        steppers=steppers,
        driven=[name for name in root.controller.outputs if name in driven],
        relay=root.controller.safety.relay,
        relay_where=root.at("safety", "relay").where,
        checked=facts.checked,
        wanting=[loop.name for loop in loops if loop.wants_relay],
        plain=[
            name
            for name, each in root.controller.switches.items()
            if each.is_on_off and not is_held(each)
        ],
        inputs=list(root.controller.safety.inputs),
        inputs_where=root.at("safety", "inputs").where,
        input_trips=bool(facts.tripping_inputs),
        counted=[name for name, each in proven.items() if each.tachometer],
        pins=["pin_output_*_drive"]
        + [f"pin_output_{name}_is_on" for name in dict.fromkeys(filter(None, fans))]
        + [f"pin_proof_{name}_is_high" for name, each in proven.items() if not each.tachometer]
        + [f"pin_input_{name}_is_high" for name in root.controller.safety.inputs],
    )
    return Part(
        files=pair("gate", "protection/gate", context),
        groups=(
            Group(
                "Heater gate",
                (
                    Constant(
                        "GATE_MAIN_PERMIT_TICKS",
                        f"{GATE_MAIN_PERMIT_TICKS}u",
                        f"after {GATE_MAIN_PERMIT_TICKS * TICK_MS} ms without the main "
                        "loop the heaters are off",
                    ),
                ),
            ),
        ),
        tick_calls=()
        if facts.checked  # the self-checks then renew the permit
        else (Call(Stage.GUARD, "gate.h", "gate_renew_main();"),),
    )


def permits(source: Source, loop: Loop, prefix: str) -> list[Constant]:
    """How long the heater may be on after a control step, and after a good reading."""
    stale = steps(loop.protection.stale_after_s, loop)
    return [
        source.at("period").count(
            f"{prefix}_PERMIT_TICKS",
            min(2 * loop.period_ticks, MOST_PERMIT_TICKS),
            "after two periods without a step the heater is off",
        ),
        source.at("protection", "stale_after").count(
            f"{prefix}_SENSOR_PERMIT_TICKS",
            min(stale * loop.period_ticks + 1, MOST_PERMIT_TICKS),
            f"{quantity(loop.protection.stale_after_s, 's')} without a reading: heater off",
        ),
    ]


@dataclass(frozen=True, slots=True)
class FaultNames:
    """The values for the templates of the fault."""

    loops: list[LoopSummary]
    rules: tuple[Rule, ...]
    lockout: LockoutNames | None


def fault(root: Source, loops: list[LoopSummary]) -> Part:
    """Plan the latched fault and its codes."""
    lockout, constants = _lockout(root)
    context = FaultNames(loops, facts_of(root.controller).rules, lockout)
    cooling = Constant(
        "FAULT_COOLING_ABOVE_C",
        c_float(FAULT_COOLING_ABOVE_C),
        "with a fault the cooler runs above it: such metal burns skin in a minute (ISO 13732-1)",
    )
    cooled = any(loop.cooler for loop in loops)
    if cooled:
        constants = (cooling, *constants)
    return Part(
        groups=(Group("Faults", constants),) if constants else (),
        files=pair("fault", "protection/fault", context),
        tick_calls=(Call(Stage.STORE, "fault.h", "fault_tick();"),) if lockout else (),
    )


def lockout_ends(controller: Controller) -> str:
    """Say how a person at the machine ends a lock-out; "" if the controller has no lock-out."""
    spec = controller.lockout
    if spec is None:
        return ""
    if facts_of(controller).keypad is not None:
        return f"hold SELECT for {quantity(spec.hold_s, 's')}"
    waits = quantity(spec.wait_s, "s")
    return f"take all power away, the USB's too, for a minute, and wait {waits}"


@dataclass(frozen=True, slots=True)
class LockoutNames:
    """The values of the lock-out, for the templates of the fault."""

    where: str
    by_keys: bool
    apart: list[str]
    """Codes of the rules whose trips are not counted for the lock-out."""


def _lockout(root: Source) -> tuple[LockoutNames | None, tuple[Constant, ...]]:
    """Return the lock-out's values and constants."""
    spec, at = root.controller.lockout, root.at("safety", "lockout")
    if spec is None:
        return None, ()
    keys = facts_of(root.controller).keypad is not None
    trips, within = (derivation_words(spec.derived.get(key)) for key in ("trips", "within"))
    constants = [
        at.at("trips").count(
            "LOCKOUT_TRIPS", spec.trips, f"after them only a person can acknowledge{trips}"
        ),
        at.at("within").count(
            "LOCKOUT_WITHIN_S", int(spec.within_s), f"older trips are not counted{within}"
        ),
    ]
    if keys:
        constants.append(
            at.at("hold").ticks("LOCKOUT_HOLD_TICKS", spec.hold_s, ", and at most twice as long")
        )
    else:
        constants.append(
            at.at("wait").count("LOCKOUT_WAIT_S", int(spec.wait_s), "wait after a loss of power")
        )
    apart = [rule_macro(rule) for rule in facts_of(root.controller).rules if rule.id in NO_LOCKOUT]
    return LockoutNames(at.where, keys, apart), tuple(constants)
