"""The files around the sources: PlatformIO's project, the Arduino sketch, the README."""

from __future__ import annotations

from collections.abc import Iterable

from heatwright.generator.plan.documents.readme import readme_names, wiring_of
from heatwright.generator.plan.parts import File, Part
from heatwright.generator.plan.text import c_comment
from heatwright.generator.wiring import Wires
from heatwright.spec import Spec
from heatwright.spec.self_checks import self_checked


def project_files(spec: Spec, parts: Iterable[Part]) -> tuple[File, ...]:
    """Plan the files that make a folder of sources a project."""
    identity, board = spec.controller.identity, spec.controller.board
    ini = {
        "board": board.platformio,
        "clock_hz": board.clock_hz if identity.clock_hz is not None else None,
        "sealed": self_checked(spec.controller),
    }
    sketch = {
        "name": identity.name,
        "title": c_comment(identity.title or identity.name),
    }
    wires = Wires(identity.name, identity.board, wiring_of(parts))
    return (
        File("platformio.ini", "project/platformio.ini.j2", ini),
        File(f"{identity.name}.ino", "project/sketch.ino.j2", sketch),
        File("wiring.svg", "project/wiring.svg.j2", {"wires": wires}),
        File("README.md", "project/README.md.j2", readme_names(spec, parts)),
    )
