"""The files around the sources: PlatformIO's project, the Arduino sketch, the README."""

from collections.abc import Iterable

from heatwright.generator.plan.documents.readme import readme_names
from heatwright.generator.plan.parts import File, Part
from heatwright.spec import Spec


def project_files(spec: Spec, parts: Iterable[Part]) -> tuple[File, ...]:
    """Plan the files that make a folder of sources a project."""
    told = readme_names(spec, parts)
    return (
        File("platformio.ini", "project/platformio.ini.j2", told),
        File(f"{told.name}.ino", "project/sketch.ino.j2", told),
        File("wiring.svg", "project/wiring.svg.j2", told),
        File("README.md", "project/README.md.j2", told),
    )
