"""Names that refer to parts: a part must exist, have a use, and not be used twice."""

from collections.abc import Collection

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.commands import gcode_of
from heatwright.spec.controller import Controller
from heatwright.spec.loading.suggest import NOT_BUILT, advice
from heatwright.spec.problems import Path, shown
from heatwright.spec.quantity import duration


def unknown(path: Path, word: str, section: str, known: Collection[str]) -> Findings:
    """Report a name that the section does not define."""
    if word not in known:
        yield Finding(
            path, f"{section} has no {shown(word)}", advice(word, tuple(known)), ((section, word),)
        )


def loop_parts(controller: Controller) -> Findings:
    """Find loops that name an undefined sensor, heater, fan or cooler."""
    for name, loop in controller.loops.items():
        yield from unknown(("loops", name, "sensor"), loop.sensor, "sensors", controller.sensors)
        yield from unknown(("loops", name, "heater"), loop.heater, "outputs", controller.outputs)
        for key, part in (("fan", loop.fan), ("cooler", loop.cooler)):
            if part is not None:
                yield from unknown(("loops", name, key), part, "outputs", controller.outputs)


def output_sensors(controller: Controller) -> Findings:
    """Find outputs that name an undefined current sensor."""
    for name, sensor in current_sensors(controller).items():
        path: Path = ("outputs", name, "current", "sensor")
        yield from unknown(path, sensor, "sensors", controller.sensors)


def relay_is_there(controller: Controller) -> Findings:
    """Find a safety relay that is not defined in `outputs`."""
    relay = controller.safety.relay
    if relay is not None:
        yield from unknown(("safety", "relay"), relay, "outputs", controller.outputs)


def interface_loops(controller: Controller) -> Findings:
    """Find interfaces that name an undefined loop."""
    for index, interface in enumerate(controller.interfaces):
        for keys, loop in interface.named_loops.items():
            yield from unknown(("interfaces", index, *keys), loop, "loops", controller.loops)


def loops_go_by_thermometers(controller: Controller) -> Findings:
    """Find loops whose sensor measures no temperature."""
    for name, loop in controller.loops.items():
        if loop.sensor in controller.ammeters:
            yield Finding(
                ("loops", name, "sensor"),
                f"{loop.sensor} measures a current, and a loop needs a temperature",
                "Name a temperature sensor",
                (("sensors", loop.sensor),),
            )


def loops_share_no_part(controller: Controller) -> Findings:
    """Find heaters that two loops would switch, and sensors that two loops would read.

    A reading can be fetched only once: the second loop would get none.
    """
    for key, does in (("heater", "switches"), ("sensor", "reads")):
        used_by: dict[str, str] = {}
        for name, loop in controller.loops.items():
            part = getattr(loop, key)
            first = used_by.setdefault(part, name)
            if first != name:
                yield Finding(
                    ("loops", name, key),
                    f"the loop {first} already {does} {part}",
                    f"Give each loop a {key} of its own",
                )


def fans_run(controller: Controller) -> Findings:
    """Check that a loop's fan is a digital output that is always on, which the loop relies on."""
    for name, loop in controller.loops.items():
        fan = controller.outputs.get(loop.fan) if loop.fan is not None else None
        if fan is None or loop.fan is None:
            continue
        if loop.fan == loop.heater:
            yield Finding(
                ("loops", name, "fan"), "this is the loop's heater", "Name the fan's output"
            )
        elif not fan.is_on_off:
            yield Finding(
                ("loops", name, "fan"),
                f"{loop.fan} is of the kind {fan.kind}, so a low duty could stop the fan",
                "Name a digital output",
            )
        elif not fan.always_runs:
            yield Finding(
                ("outputs", loop.fan, "runs"),
                f"a fan that runs with its loop {NOT_BUILT}",
                "Write runs: always",
            )


def proofs_are_of_fans(controller: Controller) -> Findings:
    """Find proofs that no loop uses, and proofs so late that `heating_failed` trips before."""
    for name, output in controller.outputs.items():
        proof = output.proof
        if proof is None:
            continue
        path: Path = ("outputs", name, "proof")
        loops = {key: loop for key, loop in controller.loops.items() if loop.fan == name}
        if not loops:
            yield Finding(
                path,
                f"no loop names {name} as its fan, so its proof would have no effect",
                f"Delete it, or add fan: {name} to the loop that needs its air",
                (("loops",),),
            )
        for key, loop in loops.items():
            heating = loop.protection.heating
            if heating is not None and proof.within_s >= heating.within_s:
                yield Finding(
                    (*path, "within"),
                    f"the heater stays off until the fan's signal comes, and rule heating_failed "
                    f"of loop {key} trips after {duration(heating.within_s)}",
                    f"Use less than {duration(heating.within_s)}",
                    (("loops", key, "protection", "heating"),),
                )


def heaters_can_heat(controller: Controller) -> Findings:
    """Refuse a heater that is a motor."""
    for name, loop in controller.loops.items():
        if loop.heater in controller.steppers:
            yield Finding(
                ("loops", name, "heater"),
                f"{loop.heater} is a stepper, which feeds material and cannot heat",
                "Name the heater's output",
                (("outputs", loop.heater),),
            )


def heaters_do_not_always_run(controller: Controller) -> Findings:
    """Refuse a heater output with `runs: always`."""
    for name, loop in controller.loops.items():
        heater = controller.outputs.get(loop.heater)
        if heater and heater.always_runs:
            yield Finding(
                ("outputs", loop.heater, "runs"),
                f"the heater of the loop {name} would always be on",
                "Delete runs",
            )


def everything_used(controller: Controller) -> Findings:
    """Find sensors and outputs that nothing uses.

    A misspelled name, or a sensor of the wrong kind, may be the reason: while another check reports
    one, this check reports nothing.
    """
    if any(True for each in (loop_parts, output_sensors, relay_is_there) for _ in each(controller)):
        return
    if any(each.sensor not in controller.sensors for each in controller.monitors.values()):
        return
    used = {loop.sensor for loop in controller.loops.values()}
    used.update(current_sensors(controller).values())
    used.update(monitor.sensor for monitor in controller.monitors.values())
    for name, sensor in controller.sensors.items():
        if name in used:
            continue
        if sensor.measures_current:
            yield Finding(
                ("sensors", name),
                "no output uses this sensor",
                f"Delete it, or write current: {{sensor: {name}, limit: …}} at the heater",
                (("outputs",),),
            )
        else:
            yield Finding(
                ("sensors", name),
                "no loop and no monitor uses this sensor",
                "Delete this sensor, or name it in a loop or a monitor",
                (("loops",), ("monitors",)),
            )
    driven = driven_by_loops(controller) | driven_by_host(controller) | {controller.safety.relay}
    for name, output in controller.outputs.items():
        if not output.always_runs and name not in driven:
            yield Finding(
                ("outputs", name),
                "no loop uses this output",
                "Delete it, or name it in a loop or a gcode interface"
                + ("; or write runs: always" if output.is_on_off else ""),
                (("loops",), ("interfaces",), ("safety",)),
            )


def driven_by_loops(controller: Controller) -> set[str]:
    """List the outputs that loops switch or rely on."""
    loops = controller.loops.values()
    parts = ((loop.heater, loop.fan, loop.cooler) for loop in loops)
    return {name for part in parts for name in part if name is not None}


def current_sensors(controller: Controller) -> dict[str, str]:
    """Map each output with a measured current to its current sensor."""
    return {
        name: output.current.sensor
        for name, output in controller.outputs.items()
        if output.current is not None
    }


def driven_by_host(controller: Controller) -> set[str]:
    """List the outputs that a host commands."""
    gcode = gcode_of(controller)
    return set() if gcode is None else {*gcode.fans.values(), *gcode.steppers.values()}


def names_apart_in_c(controller: Controller) -> Findings:
    """Find names that could give equal C identifiers: `heater` and `heater_start`.

    Identifiers of a part begin with its name (`output_heater`, `output_heater_start()`), so no name
    may be another of its section plus `_word`. A number may follow: no function is named so.
    """
    sections: dict[Path, Collection[str]] = {
        (section,): getattr(controller, section)
        for section in ("sensors", "outputs", "loops", "monitors")
    }
    sections["safety", "inputs"] = controller.safety.inputs
    for section, names in sections.items():
        for name in names:
            words = name.split("_")
            for count in range(1, len(words)):
                other, rest = "_".join(words[:count]), "_".join(words[count:])
                if other in names and not rest[0].isdigit():
                    yield Finding(
                        (*section, name),
                        f"in C its identifiers could be equal to those of {other!r}",
                        f"Rename one of them, for instance {name!r} to {rest!r}",
                    )
