"""Settings and the latched fault in EEPROM."""

from dataclasses import dataclass

from heatwright.generator.plan.loop.names import LoopSummary
from heatwright.generator.plan.numbers import c_float, quantity, ticks
from heatwright.generator.plan.parts import Call, Constant, Group, Part, Stage, pair
from heatwright.generator.plan.sensors.max31856 import types_of
from heatwright.generator.plan.source import Source
from heatwright.spec.algorithms import LARGEST_GAIN
from heatwright.spec.board.eeprom import CELL_WRITES, layout, settings_bytes

SETTINGS_DELAY_S = 10.0
LATE = ("a setpoint", "a maximum", "a type of thermocouple", "a number")
"""Settings that are saved only some time after a change."""


@dataclass(frozen=True, slots=True)
class SettingsNames:
    """The values for the templates of the settings."""

    loops: list[LoopSummary]
    types: list[str]
    """The sensors whose type of thermocouple the operator chooses."""
    any_stored: bool
    any_tunable: bool
    adjustable: list[str]
    any_limits: bool
    any_later: bool
    any_sealed_kept: bool
    any_kept: bool
    save_delay: str


def settings(root: Source, loops: list[LoopSummary]) -> Part:
    """Plan the settings and the latched fault in EEPROM."""
    stored = any(loop.stored for loop in loops)
    tunable = any(loop.tunable for loop in loops)
    adjustable = [loop.name for loop in loops if loop.adjustable]
    types = [name for name, sensor in root.controller.thermometers.items() if sensor.selectable]
    constants = _layout(root)
    numbers = any(loop.numbers for loop in loops)
    if stored or adjustable or types or numbers:
        constants.append(
            Constant(
                "SETTINGS_DELAY_TICKS",
                f"{ticks(SETTINGS_DELAY_S)}u",
                f"{_late(stored, bool(adjustable), bool(types), numbers)} saved 10 s after "
                "the last change",
            )
        )
    if tunable:
        constants.append(
            Constant("GAIN_MAXIMUM", c_float(LARGEST_GAIN), "the largest gain that can be set")
        )
    constants += [constant for name in types for constant in types_of(root, name)]
    context = SettingsNames(
        loops=loops,
        types=types,
        any_stored=stored,
        any_tunable=tunable,
        adjustable=adjustable,
        any_limits=any(loop.limits_adjustable for loop in loops),
        any_later=stored or bool(adjustable or types or numbers),
        any_sealed_kept=stored or bool(adjustable or types),
        any_kept=stored or tunable or bool(adjustable or types or numbers),
        save_delay=quantity(SETTINGS_DELAY_S, "s"),
    )
    return Part(
        files=pair("settings", "core/settings", context),
        groups=(Group("Settings in EEPROM", tuple(constants)),),
        start_calls=(Call(Stage.RESTORE, "settings.h", "settings_start();"),),
        tick_calls=(Call(Stage.STORE, "settings.h", "settings_tick();"),),
    )


def _layout(root: Source) -> list[Constant]:
    area = layout(root.controller).settings
    eeprom_bytes = root.controller.board.eeprom_bytes
    return [
        Constant(
            "SETTINGS_SLOT_BYTES",
            f"{area.slot_bytes}u",
            f"the record takes {settings_bytes(root.controller)}; "
            "slots are the same in every firmware",
        ),
        Constant(
            "SETTINGS_SLOTS",
            f"{area.slots}u",
            f"{area.end} of the {eeprom_bytes} bytes of EEPROM: "
            f"{area.slots * CELL_WRITES / 1e6:.1f} million saves",
        ),
    ]


def _late(*there: bool) -> str:
    """Name the settings of LATE that the controller has; `there` is True for each of these."""
    what = [name for name, is_there in zip(LATE, there, strict=True) if is_there]
    return f"{' or '.join(what)} is"
