"""The supply voltage of a load, and its rated voltage."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import Controller
from heatwright.spec.quantity import number


def supply_suffices(controller: Controller) -> Findings:
    """Check that the rated voltage is at most the supply's: PWM can only lower the voltage."""
    for name, output in controller.outputs.items():
        if output.rated_v is None:
            continue
        path = ("outputs", name, "rated")
        if output.supply_v is None:
            reason = "without a supply this key has no effect"
            yield Finding(path, reason, "Add supply: with its voltage")
        elif output.rated_v > output.supply_v:
            yield Finding(
                path,
                f"{number(output.rated_v)} V is more than the supply of "
                f"{number(output.supply_v)} V, so the load never has its rated power",
                "Write the power at the supply's voltage, and delete rated",
                (("outputs", name, "supply"),),
            )
