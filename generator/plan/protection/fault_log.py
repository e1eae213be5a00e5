"""The list of the last faults, for displays."""

from heatwright.generator.plan.parts import Call, Part, Stage, pair


def fault_log() -> Part:
    """Plan the list; several displays share one."""
    return Part(
        files=pair("fault_log", "protection/fault_log"),
        tick_calls=(Call(Stage.SHOW, "fault_log.h", "fault_log_tick();"),),
    )
