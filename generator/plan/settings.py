"""Settings and the latched fault in EEPROM."""

from __future__ import annotations

from heatwright.generator.plan.numbers import c_float, quantity, ticks
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage
from heatwright.generator.plan.source import Source
from heatwright.spec.algorithms import LARGEST_GAIN

SETTINGS_DELAY_S = 10.0
MOST_SETTINGS_SLOTS = 16
"""The start checks every slot, of 64 bytes in at most 0.6 ms at 8 MHz: well within the shortest
watchdog period of 30 ms."""

SETTINGS_SLOT_BYTES = 64
"""Of a slot, or a multiple: whatever a firmware stores, the next one finds where it begins."""
RECORD_BYTES = 2 + 1 + 4 + 2 + 10
"""CRC, size, digest, sequence number and fault."""

EEPROM_CELL_WRITES = 100_000
"""Endurance of an EEPROM cell, AVR data sheets, section "Features"."""


def settings(root: Source, loops: list[dict[str, object]]) -> Part:
    """Settings and the latched fault in EEPROM."""
    stored = any(loop["stored"] for loop in loops)
    tunable = any(loop["tunable"] for loop in loops)
    kept_bytes = sum(4 * bool(loop["stored"]) + 12 * bool(loop["tunable"]) for loop in loops)
    record_bytes = RECORD_BYTES + kept_bytes
    slot_bytes = -(-record_bytes // SETTINGS_SLOT_BYTES) * SETTINGS_SLOT_BYTES
    eeprom_bytes = root.controller.board.eeprom_bytes
    slots = min(MOST_SETTINGS_SLOTS, eeprom_bytes // slot_bytes)
    constants = [
        Constant(
            "SETTINGS_SLOT_BYTES",
            f"{slot_bytes}u",
            f"the record takes {record_bytes}; slots are alike in every firmware",
        ),
        Constant(
            "SETTINGS_SLOTS",
            f"{slots}u",
            f"{slots * slot_bytes} of the {eeprom_bytes} bytes of EEPROM: "
            f"{slots * EEPROM_CELL_WRITES / 1e6:.1f} million saves",
        ),
    ]
    if stored:
        constants.append(
            Constant(
                "SETTINGS_DELAY_TICKS",
                f"{ticks(SETTINGS_DELAY_S)}u",
                "a setpoint is saved when it has rested 10 s",
            )
        )
    if tunable:
        constants.append(
            Constant("GAIN_MAXIMUM", c_float(LARGEST_GAIN), "no gain is larger, whoever sets it")
        )
    context = {
        "loops": loops,
        "any_stored": stored,
        "any_tunable": tunable,
        "any_kept": stored or tunable,
        "save_delay": quantity(SETTINGS_DELAY_S, "s"),
    }
    return Part(
        files=(
            File("src/settings.h", "src/settings.h.j2", context),
            File("src/settings.c", "src/settings.c.j2", context),
        ),
        groups=(Group("Settings in EEPROM", tuple(constants)),),
        start_calls=(Call(Stage.RESTORE, "settings.h", "settings_start();"),),
        tick_calls=(Call(Stage.STORE, "settings.h", "settings_tick();"),),
    )
