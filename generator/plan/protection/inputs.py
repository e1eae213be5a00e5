"""Inputs of the machine: contacts that must be closed for heat."""

from dataclasses import dataclass

from heatwright.generator.plan.parts import Call, Group, Part, Stage, Symbol, Wiring, pair
from heatwright.generator.plan.pins import contact, label
from heatwright.generator.plan.source import Source
from heatwright.spec import Input, facts_of


@dataclass(frozen=True, slots=True)
class InputNames:
    """The values for the templates of the inputs."""

    where: str
    inputs: list[str]
    tripping: list[str]


def plan_inputs(root: Source) -> list[Part]:
    """Plan the inputs, if there are any: one file for all."""
    inputs, board = root.controller.safety.inputs, root.controller.board
    if not inputs:
        return []
    section, trips = root.at("safety", "inputs"), facts_of(root.controller).tripping_inputs
    context = InputNames(section.where, list(inputs), list(trips))
    constants = [
        section.at(name, "for").ticks(f"INPUT_{name.upper()}_TICKS", each.for_s)
        for name, each in trips.items()
    ]
    slowest = max(inputs, key=lambda name: inputs[name].for_s)
    closed = section.at(slowest, "for")
    constants.append(closed.ticks("GATE_INPUT_TICKS", inputs[slowest].for_s, " closed before heat"))
    return [
        Part(
            files=pair("inputs", "protection/inputs", context),
            groups=(Group("Inputs of the machine", tuple(constants)),),
            pins=tuple(
                contact(section.at(name, "pin"), f"input_{name}", board.pins[each.pin], name)
                for name, each in inputs.items()
            ),
            start_calls=(Call(Stage.SENSE, "inputs.h", "inputs_start();"),),
            tick_calls=(Call(Stage.SENSE, "inputs.h", "inputs_tick();"),),
            wiring=tuple(
                Wiring(
                    label(board.pins[each.pin]),
                    f"input `{name}`",
                    _how(each),
                    (Symbol("down", "closed", name),),
                    ends=False,
                )
                for name, each in inputs.items()
            ),
        )
    ]


def _how(each: Input) -> str:
    ends = "it is acknowledged" if each.trips else "it is closed again"
    return f"a contact to ground, closed while all is well; if it opens, nothing heats until {ends}"
