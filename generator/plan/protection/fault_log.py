"""The list of the last faults, for displays."""

from __future__ import annotations

from heatwright.generator.plan.parts import Call, File, Part, Stage


def fault_log() -> Part:
    """Plan the list; several displays share one."""
    return Part(
        files=(
            File("src/fault_log.h", "protection/fault_log.h"),
            File("src/fault_log.c", "protection/fault_log.c"),
        ),
        tick_calls=(Call(Stage.SHOW, "fault_log.h", "fault_log_tick();"),),
    )
