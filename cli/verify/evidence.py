"""All the evidence for one spec."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heatwright.cli.figures import as_json, build_json, replay_json
from heatwright.cli.results import speed
from heatwright.cli.verify.checks import Check
from heatwright.cli.verify.rows import figure_cells
from heatwright.cli.verify.trials import Trials
from heatwright.generator.toolchain import BuildResult
from heatwright.sim.avr import Core
from heatwright.sim.chain import ChainError
from heatwright.sim.faults.controller.upsets import BAD, GUARDED, Outcome
from heatwright.spec import Spec


@dataclass(frozen=True)
class Evidence:
    """All results, and the checks on them."""

    file: str
    spec: Spec
    core: Core
    """The simulator core that ran the instructions."""
    elf: Path | None
    """The binary, if it was built elsewhere."""
    built: BuildResult
    chains: tuple[ChainError, ...]
    """Errors of the analog sensors' measuring chains."""
    checks: tuple[Check, ...]
    trials: Trials
    upsets: tuple[Outcome, ...] = ()
    """Outcomes of flipped bits, if they were requested."""

    @property
    def passed(self) -> bool:
        """Whether everything holds."""
        return not self.failures

    @property
    def count(self) -> int:
        """Number of checks, with the figures of timing and the faults."""
        return len(self.checks) + len(self.trials.timing.figures) + len(self.trials.faults)

    @property
    def left_out(self) -> int:
        """Number of faults that were not tried, because --fault names others."""
        return self.trials.known - len(self.trials.faults)

    @property
    def failures(self) -> tuple[str, ...]:
        """The checks, figures of timing, upsets and faults that fail, one line each."""
        return (
            *(
                f"{check.what}: {check.found} (limit: {check.limit})"
                for check in self.checks
                if not check.passed
            ),
            *(
                f"{what}: {found} (limit: {limit})"
                for figure in self.trials.timing.figures.values()
                if not figure.passed
                for what, _, found, limit in [figure_cells(figure)]
            ),
            *(
                f"{each.upset}: {each.words}"
                for each in self.upsets
                if each.result in BAD and each.upset.kind in GUARDED
            ),
            *(
                f"fault {each.fault}: {each.detail}"
                for each in self.trials.faults
                if not each.passed
            ),
        )

    @property
    def unusual(self) -> tuple[str, ...]:
        """Everything in which this run differs from the default, one line each."""
        return (
            *([] if self.elf is None else [f"The binary was built elsewhere: {self.elf}."]),
            *([] if self.core == "own" else ["simavr's core ran the instructions."]),
            *([f"Faults that were not tried: {self.left_out}."] if self.left_out else []),
        )

    @property
    def mismatches(self) -> tuple[str, ...]:
        """The first few variables that differ from the model's, a line each."""
        return tuple(
            f"{loop}: {mismatch}"
            for loop, replayed in self.trials.loops.replays.items()
            for mismatch in replayed.first
        )

    def as_json(self) -> dict[str, Any]:
        """Return the evidence as JSON data; temperatures in °C, differences in K."""
        return {
            "spec": self.file,
            "digest": self.spec.digest,
            "core": self.core,
            "elf": None if self.elf is None else str(self.elf),
            "build": build_json(self.built),
            "sensors": [chain.as_json() for chain in self.chains],
            "replay": replay_json(self.trials.loops.replays.values()),
            "loops": {
                name: {
                    "closed_loop": as_json(figures),
                    "replay": replay_json([self.trials.loops.replays[name]]),
                }
                for name, figures in self.trials.loops.run.figures.items()
            },
            "faults": [each.as_json() for each in self.trials.faults],
            "faults_left_out": self.left_out,
            "timing": self.trials.timing.as_json(),
            "upsets": [
                {**each.upset._asdict(), "result": each.result, "words": each.words}
                for each in self.upsets
            ],
            "speed": speed(self.trials.loops.run),
            "passed": self.passed,
        }
