"""The machines that faults are tried on: examples, and others made from their texts."""

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

from fault_rules import rules_of
from rig.firmware import changed, controller_of, edited, whole
from rig.sensors import KEYS, KINDS, bed, crucible

from heatwright.sim.faults import Fault, catalogue, try_fault
from heatwright.sim.faults.world import Site
from heatwright.spec.rules import RULES

DECIDING = ("chamber", "extruder", "fabricator", "kiln")
"""Keys, a host, a master with a cooler and a relay, a touch display with programs and a relay."""
CODES = {rule.id: code for code, rule in RULES.items()}
ON_OFF = "{kind: on_off, hysteresis: 0 K, lead: 12 s, lead_filter: 4 s}"
HEATER = "heater: {kind: digital, pin: D3, power: 240 W}"

# A relay module that is on at low level, PID in slow windows spread over them, a safety relay with
# its contact, a band with two ends, half the sensor's resolution, the setpoint kept; heating_failed
# off, so that sensor_frozen is the first.
PID = changed(
    "chamber",
    (HEATER,
     "heater: {kind: time_proportional, pin: D3, active: low, window: 2 s, resolution: 20 ms, "
     "distribution: spread, power: 240 W}\n  contactor: {kind: digital, pin: D2, active: low}"),
    ("resolution: 12 bit", "resolution: 11 bit"),
    ("maximum: 70 °C}", "maximum: 70 °C, stored: true}"),
    (ON_OFF, "{kind: pid, kp: 12, ki: 0.05, kd: 300, derivative_filter: 4 s}"),
    ("heating: {rise: 2 K, within: 120 s}", "heating: off\n      frozen: {for: 90 s}"),
    ("{above: 10 K, for: 60 s}", "{above: 10 K, below: 8 K, for: 90 s}"),
    ("watchdog: 2 s", "watchdog: 500 ms\n  relay: contactor\n  relay_feedback: D12"),
)  # fmt: skip

SIPS = """
heatwright: 1
controller: {name: sips, board: atmega2560}
sensors:
  air: {kind: max6675, chip_select: PE2, clock: PJ6, data_out: PC1}
  amps: {kind: current, pin: PF1, scale: 8.17 V/A, oversample: 4}
outputs:
  heater: {kind: pwm, pin: PC2, frequency: 100 Hz, power: 100 W, supply: 230 V, rated: 115 V,
    current: {sensor: amps, trip: 1.04 A}}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    setpoint: {initial: 21 °C, minimum: 20 °C, maximum: 200 °C}
    algorithm: {kind: pid, kp: 1.43, ki: 0.0000143}
    protection: {maximum: 250 °C, minimum: 6 °C, heating: 'off'}
safety: {watchdog: 1 s}
interfaces: [{kind: serial_plotter, loop: air, baud: 9600}]
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {air: 205.8 J/K}
    links: [{between: [air, ambient], resistance: 5 K/W}]
    heat: {heater: air}
    sense: {amps: {of: heater}, air: {node: air, lag: 10 s}}
  scenario: [{for: 60 s}]
"""

# A transistor under PWM, a fast loop, a short patience; no display, no keys, no fan.
BARE = edited("chamber", """
outputs.heater: {kind: pwm, pin: D3, frequency: 490 Hz, power: 240 W}
outputs.fan: null
loops.air.fan: null
loops.air.setpoint.initial: 50 °C
loops.air.period: 500 ms
sensors.air.resolution: 9 bit
loops.air.algorithm: {kind: pid, kp: 20, ki: 0.1}
loops.air.protection.stale_after: 50 s
safety.watchdog: 1 s
interfaces: [{kind: serial_plotter, loop: air, baud: 9600}]
simulation.scenario.0: null
""")  # fmt: skip

# A cooler with minimum times, no current to tell.
HELD = edited("fabricator", """
outputs.heater.current: null
sensors.current: null
simulation.plant.sense.current: null
outputs.cooler: {kind: digital, pin: PD6, minimum_on: 1500 ms, minimum_off: 3 s}
""")  # fmt: skip


class Machine(NamedTuple):
    """What is tried on a controller; the healthy ones take long: `verify` tries those of examples.

    otherwise -- where it differs from what holds for all of them; absent -- a fault that the
    catalogue leaves out, because the machine cannot have it; only -- the faults that are tried,
    where another machine shows the rest.
    """

    spec: str
    healthy: bool = False
    otherwise: Mapping[str, str | None] = MappingProxyType({})
    absent: tuple[str, ...] = ()
    only: tuple[str, ...] = ()


UNSEEN = ("heater_aged", "reading_drifts_low")
"""Where the band allows all power at the setpoints that people can ask for."""
NOISY = ("small_jumps",)
"""Where noise and a pulse of the heater together may jump as far as `rise_rate` allows."""

MACHINES = {
    "chamber": Machine("chamber", healthy=True),
    # Its sensor cools too slowly to jump: the fall is seen at the band's lower end.
    "pid": Machine(
        PID, healthy=True,
        otherwise={"fallen_out": "runaway_below", "fallen_out_insisted": "runaway_below"},
    ),
    # In such a window a burst costs up to 10 s of heat: full power does not do any more.
    "windowed": Machine(
        crucible("max6675").replace(
            "pwm, pin: D9, frequency: 122 Hz", "time_proportional, pin: D9, window: 10 s"
        ).replace("within: 25 s", "within: 50 s").replace("for: 25 s", "for: 50 s"),
        otherwise={"answers_damaged_in_bursts": "heating_failed"},
        only=("answers_damaged_in_bursts",), absent=UNSEEN,
    ),
    # So long without a reading, and without heat, costs more than full power gives in time.
    "patient": Machine(
        bed("falling", interface=KEYS).replace("stale_after: 1 s", "stale_after: 50 s")
        .replace("{rise: 2 K, within: 60 s}", "{rise: 0.5 K, within: 7 s}"),
        otherwise={"intermittent_wire": "heating_failed"},
        only=("intermittent_wire",), absent=("reading_drifts_low", "small_jumps"),
    ),
    # In half a second it falls too little to jump. The heavy one that loses much is too weak.
    "bare": Machine(
        BARE, otherwise={"fallen_out": "heating_failed"}, absent=("healthy_1.3C_0.7R_10degC",)
    ),
    # Its integral begins above what the band lets be seen.
    "extruder": Machine("extruder", absent=UNSEEN),
    # Its switch that has died gives the whole supply, which is above what trips.
    "fabricator": Machine(
        "fabricator", otherwise={
            "switch_shorted_when_hot": "over_current", "switch_shorted_in_band": "over_current",
        }, absent=NOISY,
    ),
    "kiln": Machine("kiln"),
    "kiln_uno": Machine(
        "kiln_uno",
        only=("key_stuck", "keys_at_random", "select_stuck", "select_leaks", "display_unplugged"),
    ),
    "held": Machine(
        HELD,
        only=(
            "open", "heater_open", "switch_shorted_when_hot", "switch_shorted_in_band", "fire",
            "cooler_shorted", "heating_and_cooling_by_turns", "hung_while_cooling",
        ),
        absent=NOISY,
    ),
    **{
        kind: Machine(
            crucible(kind), healthy=True, otherwise={"switch_leaking": "runaway_above"},
            absent=UNSEEN,
        )
        for kind in KINDS
    },
    # In 200 ms, too, they fall too little to jump.
    **{
        name: Machine(
            bed(name, interface=KEYS),
            otherwise=dict.fromkeys(("fallen_out", "fallen_out_insisted"), "heating_failed")
            | leaks,
            absent=("reading_drifts_low",),  # its nodes bear too little of what is not seen
        )
        for name, leaks in (
            ("hotend", {}), ("frost", {"switch_leaking": "runaway_above"}), ("falling", {}),
        )
    },
    # Off until somebody presses UP, and after a time.
    "timed": Machine(
        changed(
            "chamber", ("starts: enabled  ", "starts: disabled "),
            ("step: 10 K}", "step: 10 K, countdown: {longest: 1 h, step: 2 min}}"),
        ),
        only=("countdown_ends", "power_cut", "keys_at_random", "select_stuck"),
    ),
    # Nobody switches them off any more: they have been on for longer than they may be.
    **{
        f"left_{name}": Machine(
            changed(name, *others), only=("left_on", "switched_on_anew", "on_time_flipped"),
            absent={"extruder": UNSEEN, "fabricator": NOISY}.get(name, ()),
        )
        for name, *others in (
            ("chamber", ("starts: enabled  ", "starts: disabled "),
             ("stale_after: 5 s", "stale_after: 5 s\n      on_for_at_most: 22 min")),
            ("extruder", ("stale_after: 1 s", "stale_after: 1 s\n      on_for_at_most: 25 min")),
            ("fabricator", ("_after: 5 s", "_after: 5 s\n      on_for_at_most: 12 min")),
        )
    },
    # Nobody can ask for more than a duty below the shortest pulse: a shorted wire carries nothing.
    "sips": Machine(
        SIPS, only=("heater_shorted",), otherwise={"heater_shorted": None},
        absent=("heater_part_shorted", "current_sensor_stands", "reading_stands_high"),
    ),
    # What it asks for carries less than half of the limit through a wire part shorted.
    "asks_little": Machine(
        changed(SIPS, ("trip: 1.04 A", "limit: 0.9 A, trip: 1.04 A"),
                ("kp: 1.43, ki: 0.0000143", "kp: 0.3, ki: 0.002, output: {maximum: 50 %}"),
                ("minimum: 20 °C, maximum: 200 °C", "minimum: 20 °C, maximum: 120 °C")),
        only=("heater_part_shorted",), absent=("current_sensor_stands", "reading_stands_high"),
    ),
    # A fire reaches a loop that cools from its start on.
    "at_once": Machine(
        changed("fabricator", ("starts: disabled", "starts: enabled")), only=("fire",),
        absent=NOISY,
    ),
}  # fmt: skip


@cache
def site_of(name: str) -> Site:
    """Return a machine of the table, or that of a spec's text or of an example: its first loop."""
    spec = MACHINES[name].spec if name in MACHINES else name
    controller = controller_of(spec)
    return Site(controller, next(iter(controller.loops)), whole(spec))


@cache
def faults_of(name: str) -> Mapping[str, Fault]:
    """Return what the catalogue has for a machine: to find what it can do takes seconds."""
    site = site_of(name)
    return {fault.id: fault for fault in catalogue(site.controller, site.program)}


def judged(name: str, fault: str) -> str | None:
    """Try a fault of a machine; see that all is as it should be, and return the rule that trips."""
    result = try_fault(faults_of(name)[fault])
    assert result.detail == ""
    return result.rule


@cache
def expected(name: str) -> Mapping[str, str | None]:
    machine = MACHINES[name]
    rules = {**rules_of(controller_of(machine.spec)), **machine.otherwise}
    return {fault: rule for fault, rule in rules.items() if fault not in machine.absent}


def tried(name: str) -> dict[str, str | None]:
    machine, rules = MACHINES[name], expected(name)
    chosen = machine.only or [
        fault for fault in rules if machine.healthy or not fault.startswith("healthy")
    ]
    return {fault: rules[fault] for fault in chosen}
