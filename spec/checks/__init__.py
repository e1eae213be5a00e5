"""The checks that compare several entries of a spec: references, pins, timers, physics."""

from heatwright.spec.adjusted import extremes, with_setting
from heatwright.spec.checks import references, scenario
from heatwright.spec.checks.board import eeprom, memory, pins, ports, timers
from heatwright.spec.checks.comparison import row_controller, row_path, rows_have_loops
from heatwright.spec.checks.finding import Check, Finding, PlantCheck
from heatwright.spec.checks.interfaces import displays, host, interfaces, leds, logs, master
from heatwright.spec.checks.loops import (
    adjusted,
    algorithms,
    cooling,
    gains,
    limits,
    minimum_times,
    monitors,
    on_times,
    relays,
    second,
    tachometers,
    tenths,
    timing,
    windows,
)
from heatwright.spec.checks.physics import plant, sizing
from heatwright.spec.checks.physics.thermal import thermal
from heatwright.spec.checks.programs import limits as program_limits
from heatwright.spec.checks.programs import orders, programs
from heatwright.spec.checks.sensing import (
    analog,
    current_timing,
    currents,
    max31856,
    reading,
    senses,
    supply,
    tolerances,
)
from heatwright.spec.controller import Controller

CHECKS: tuple[Check, ...] = (
    references.loop_parts,
    references.output_sensors,
    references.interface_loops,
    programs.programs_have_a_loop,
    references.relay_is_there,
    references.loops_share_no_part,
    references.fans_run,
    references.proofs_are_of_fans,
    tachometers.tachometers_can_be_counted,
    references.heaters_can_heat,
    references.heaters_do_not_always_run,
    references.loops_go_by_thermometers,
    monitors.monitor_sensors,
    monitors.monitors_have_a_step,
    monitors.monitors_in_order,
    monitors.monitors_in_time,
    second.second_sensors_are_monitors,
    second.second_sensors_can_agree,
    references.everything_used,
    references.names_apart_in_c,
    cooling.coolers_have_a_use,
    cooling.coolers_can_be_switched,
    currents.current_sensors_measure_currents,
    currents.currents_are_watched,
    currents.currents_are_known,
    currents.currents_are_held,
    currents.limits_can_begin,
    currents.limits_can_be_told,
    currents.currents_can_be_read,
    current_timing.currents_in_time,
    current_timing.currents_can_be_smoothed,
    pins.pins_exist,
    pins.pins_can_be_switched,
    pins.analog_pins,
    pins.pins_used_once,
    pins.shields_fit,
    analog.scales_are_not_zero,
    analog.ranges_have_curves,
    analog.codes_are_of_the_circuit,
    analog.ranges_can_be_shown,
    analog.one_reference,
    tolerances.tolerances_have_a_part,
    tolerances.tolerances_leave_a_voltage,
    tolerances.accuracy_within_range,
    pins.heater_pins_stay_off,
    pins.jtag_pins_are_free,
    timers.clock_ticks,
    timers.timers_suffice,
    timing.periods_are_ticks,
    timing.interrupts_are_short,
    timing.buses_wait_for_each_other,
    reading.conversion_fits,
    timing.time_outs_fit,
    timing.stale_after,
    reading.first_reading_in_time,
    timing.watchdog_on_the_chip,
    timing.watchdog_slow_enough,
    timing.watchdog_fast_enough,
    windows.resolution_is_ticks,
    windows.window_has_steps,
    windows.spread_leaves_no_dc,
    windows.spread_has_no_rests,
    windows.pulses_fit,
    minimum_times.minimum_times_are_ticks,
    minimum_times.minimum_times_have_a_use,
    minimum_times.minimum_times_leave_the_current_alone,
    minimum_times.minimum_times_break_no_rule,
    limits.setpoints_in_order,
    limits.maximum_above_setpoints,
    limits.runaway_outside_the_band,
    limits.minimum_below_setpoints,
    limits.start_is_allowed,
    limits.efforts_are_known,
    max31856.setpoints_are_borne,
    limits.protections_in_range,
    limits.rise_rate_above_steps,
    algorithms.duty_can_be_made,
    algorithms.limits_in_order,
    algorithms.integral_leaves_room,
    algorithms.adjustable_limits_have_a_use,
    algorithms.something_acts,
    algorithms.rest_is_not_frozen,
    cooling.dead_band_has_room,
    gains.bands_in_order,
    gains.ready_can_last,
    gains.autotune_has_a_use,
    supply.supply_suffices,
    interfaces.step_fits_range,
    interfaces.countdowns_have_a_use,
    interfaces.countdowns_count_minutes,
    adjusted.numbers_have_a_use,
    adjusted.numbers_in_range,
    ports.ports_exist,
    ports.one_interface_per_port,
    ports.baud_can_be_made,
    host.host_names_once,
    host.host_fans,
    host.host_steppers,
    host.steppers_wait,
    host.ready_is_asked_for,
    host.lines_have_a_host,
    host.lines_fit_the_host,
    host.lines_name_served_loops,
    master.somebody_switches_on,
    master.masters_have_time,
    on_times.on_times_have_a_beginning,
    on_times.on_times_end_last,
    tenths.setpoints_fit_tenths,
    master.writes_have_a_reader,
    master.writes_find_their_place,
    master.writes_in_range,
    master.warm_is_once,
    displays.one_display,
    displays.display_apart_from_host,
    displays.maximum_has_an_operator,
    max31856.types_have_an_operator,
    relays.relay_is_free,
    relays.relay_can_open,
    relays.feedback_has_a_relay,
    programs.programs_are_alone,
    programs.programs_have_an_operator,
    programs.programs_have_room,
    programs.programs_names_apart,
    programs.what_a_fault_keeps_can_go_on,
    programs.targets_can_be_chosen,
    programs.slopes_have_a_program,
    program_limits.hold_back_before_runaway,
    program_limits.targets_can_be_reached,
    program_limits.program_times_fit,
    logs.entries_are_new,
    logs.entries_have_a_time,
    memory.ram_suffices,
    leds.leds_show_one_loop,
    leds.leds_have_a_meaning,
    plant.heaters_have_power,
    eeprom.eeprom_suffices,
    eeprom.settings_fit,
    eeprom.progress_lasts,
    eeprom.log_lasts,
    eeprom.start_in_time,
    scenario.scenario_in_order,
    scenario.keys_exist,
    orders.orders_have_programs,
    orders.orders_find_their_place,
    sizing.sizings_fit,
    scenario.extrusion_takes_heat,
    scenario.comparison_has_plant,
    rows_have_loops,
)

# Each of these checks uses the whole plant, so they run only if all its names are defined.
SIMULATION_CHECKS: tuple[PlantCheck, ...] = (
    plant.plant_links,
    plant.plant_radiation,
    plant.plant_nodes,
    plant.plant_covers_loops,
    monitors.plant_covers_monitors,
    senses.senses_fit,
    senses.currents_are_sensed,
    plant.heat_arrives,
    cooling.coolers_cool,
)


def check(controller: Controller) -> list[Finding]:
    """Run all checks on a controller.

    The extremes of numbers that the keypad can set, and the rows of a comparison, add only findings
    that the controller itself does not have.
    """
    simulation = controller.simulation
    found: list[Finding] = []
    if simulation is not None:
        found += plant.plant_names(controller, simulation.plant)
        for each in SIMULATION_CHECKS if not found else ():
            found += each(controller, simulation.plant)
    whole = not found and not [*references.loop_parts(controller)]
    found += _check_one(controller, whole)
    own = {finding[:3] for finding in found}
    found += _of_extremes(controller, whole, {*own})
    lost = {finding.path[1] for finding in rows_have_loops(controller)}
    for index, row in enumerate(controller.comparison):
        if index in lost:
            continue
        for finding in _check_one(row_controller(controller, row), whole, any_setpoint=False):
            if finding[:3] not in own:
                path = row_path(controller, index, finding.path)
                found.append(finding._replace(path=path))
    return found


def _of_extremes(
    controller: Controller, whole: bool, known: set[tuple[object, ...]]
) -> list[Finding]:
    """Check the controller at the extremes of the numbers that the keypad can set."""
    if [*adjusted.numbers_have_a_use(controller), *adjusted.numbers_in_range(controller)]:
        return []
    found = []
    for setting in extremes(controller):
        for finding in _check_one(with_setting(controller, setting), whole):
            if finding[:3] not in known:
                known.add(finding[:3])
                found.append(adjusted.of_extreme(controller, finding, setting))
    return found


def _check_one(controller: Controller, whole: bool, *, any_setpoint: bool = True) -> list[Finding]:
    """Run the checks of one controller; physics only if the parts of its machine are all there."""
    found = [finding for each in CHECKS for finding in each(controller)]
    if whole:
        found += thermal(controller, any_setpoint=any_setpoint)
        if controller.simulation is not None:
            found += monitors.monitors_hold(controller, controller.simulation)
    return found
