"""What a healthy machine can do: how hot it gets, how fast, and up to which setpoint."""

import math
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import islice, tee

from heatwright.sim.faults.bears import SIGMAS
from heatwright.sim.faults.site import Place
from heatwright.sim.plants import FOREVER_S, full_power, plant_of, profile_c
from heatwright.sim.reference.numbers import steps
from heatwright.spec import Controller, Heating, Loop, ThermalNetwork

COURSE_STEP_S = 1.0
"""Time step of a simulated course, unless the loop's period is longer: slow machines have long
periods."""
LONGEST_S = 24 * 3600.0
MOST_WATCHED_S = 4 * 3600.0
TRAVELLED = 0.95
WARM_K = 15.0
"""How far below its setpoint a machine starts in trials that begin warm."""
NEAR_K = 0.5
"""Precision of the search for the highest setpoint."""
MOST_ROWS = 10_000
"""More periods than a sensor takes to follow its machine."""


def steady_c(site: Place, share: float, *, ambient_c: float, cooled: bool = False) -> float:
    """Return the steady temperature of the loop's sensor at a share (0..1) of heater power, °C.

    cooled -- whether the cooler runs, as it does above the band and while a fault is latched.
    """
    plant = plant_of(site.controller, site.network, ambient_c=ambient_c, step_s=FOREVER_S)
    plant.step(_powered(site, share, cooled=cooled))
    return plant.sensed_c()[site.loop.sensor]


def share_for(site: Place, hold_c: float, *, ambient_c: float, cooled: bool = False) -> float:
    """Return the share of the heater's power that would hold a temperature, °C; it may exceed 1."""
    full_c = steady_c(site, 1.0, ambient_c=ambient_c, cooled=cooled)
    return (hold_c - ambient_c) / (full_c - ambient_c)


def room_k(site: Place) -> float:
    """Return the largest lasting error of a reading that breaks no rule with a limit, K.

    This is half of the smallest distance from a healthy machine to a limit; the other half is for
    the control's own swings.
    """
    protection = site.loop.protection
    left_k = [
        protection.maximum_c - site.loop.setpoint.maximum_c,
        max(site.loop.setpoint.minimum_c, site.ambient_c) - protection.minimum_c,
    ]
    if protection.runaway is not None:
        left_k += [protection.runaway.above_k, protection.runaway.below_k or math.inf]
    if protection.rising_while_off is not None:
        left_k.append(protection.rising_while_off.rise_k)
    if protection.agreement is not None:
        left_k.append(protection.agreement.within_k)
    return max(0.0, min(left_k)) / 2


@lru_cache(maxsize=16)
def jump_k(site: Place, start_c: float, hold_c: float) -> float:
    """Return the largest jump up that trips no rule on its way back, K; negative: there is none.

    The machine warms up meanwhile from a steady state to a setpoint, °C, and is cooled above that;
    the reading has steps and noise. For `rise_rate`, two readings of a chip that converts by itself
    may be further apart than a period. After a jump back the machine has to warm up by the jump and
    by the rise of `heating` in the time of that rule.
    """
    loop = site.loop
    sensor, sense = site.controller.thermometers[loop.sensor], site.network.sense[loop.sensor]
    heated, cooled = _powered(site, 1.0), _powered(site, 0.0, cooled=True)
    moves_k = max(_fastest_k(site, start_c, heated), _fastest_k(site, hold_c, cooled))
    moves_k *= 1 + loop.periods_in(sensor.free_running_s)
    # A sum of readings has the noise of their mean.
    noise_k = SIGMAS * math.sqrt(2 / getattr(sensor, "oversample", 1)) * sense.noise_k
    step_k = sensor.step_at_k(hold_c, site.controller.board.mcu)
    blurred_k = math.hypot(step_k, noise_k)
    return min(loop.rise_per_period_k - moves_k, _regained_k(site, start_c, hold_c)) - blurred_k


def _regained_k(site: Place, start_c: float, hold_c: float) -> float:
    """Return the least excess of the rise at full power over what `heating` demands, K.

    The machine heats up to a setpoint, from the steady state except for a cold element.
    """
    rule, most_c = site.loop.protection.heating, hold_c + _beyond_k(site.loop)
    if rule is None:
        return math.inf
    starts_c = _with_cold_element(site, site.network, site.ambient_c, start_c)
    taken = course(
        site, site.network, ambient_c=site.ambient_c, starts_c=starts_c, step_s=site.loop.period_s
    )
    periods, least_k = steps(rule.within_s, site.loop), math.inf
    before_c: deque[float] = deque(maxlen=periods)
    for _, sensed_c in islice(taken, MOST_ROWS + periods):
        if sensed_c >= most_c:
            break
        if len(before_c) == periods:
            least_k = min(least_k, sensed_c - before_c[0])
        before_c.append(sensed_c)
    return least_k - rule.rise_k


def _fastest_k(site: Place, start_c: float, asked: Mapping[str, float]) -> float:
    """Return how far the sensor moves in a period at most, from a steady state, K."""
    controller, network, ambient_c = site.controller, site.network, site.ambient_c
    starts_c = profile_c(controller, network, site.loop_name, start_c, ambient_c=ambient_c)
    plant = plant_of(
        controller, network, ambient_c=ambient_c, step_s=site.loop.period_s, starts_c=starts_c
    )
    before_c, fastest_k = plant.sensed_c()[site.loop.sensor], 0.0
    for _ in range(MOST_ROWS):
        plant.step(asked)
        now_c = plant.sensed_c()[site.loop.sensor]
        moved_k, before_c = abs(now_c - before_c), now_c
        if moved_k < fastest_k / 2:
            break
        fastest_k = max(fastest_k, moved_k)
    return fastest_k


def asked_share(site: Place, percent: float) -> float:
    """Return the share of the time (0..1) in which the heater conducts at a duty, %.

    At 100 % duty it is below 1 if the supply gives more than the heater's rated power.
    """
    return percent / 100 * site.controller.switches[site.loop.heater].full_share


@lru_cache(maxsize=16)
def watch_s(site: Place) -> float:
    """Return how long a broken machine is watched, s: a rule that must trip does so in this time.

    This is the time that full power takes for 95 % of the way to the maximum, or to where the
    machine levels out, plus twice the times of the rules in `_lasting_s`; at most four hours.
    """
    return min(MOST_WATCHED_S, _travel_s(site) + 2 * sum(_lasting_s(site)))


def longest_rule_s(site: Place) -> float:
    """Return the longest time of the rules in `_lasting_s`, s: these times run in parallel."""
    return max(_lasting_s(site), default=0.0)


def _lasting_s(site: Place) -> list[float]:
    """Return the times of the rules for heating, frozen, runaway and rising_while_off, s."""
    protection = site.loop.protection
    rising = protection.rising_while_off
    lasting_s = [
        rule.within_s if isinstance(rule, Heating) else rule.for_s
        for rule in (protection.heating, protection.frozen, protection.runaway)
        if rule is not None
    ]
    return lasting_s if rising is None else [*lasting_s, rising.settle_s]


def _travel_s(site: Place) -> float:
    """Return how long full power takes for 95 % of its way to the maximum, or to its level, s."""
    network, ambient_c = site.network, site.ambient_c
    full_share = asked_share(site, site.loop.algorithm.full_percent)
    most_c = min(site.loop.protection.maximum_c, steady_c(site, full_share, ambient_c=ambient_c))
    goal_c = ambient_c + TRAVELLED * (most_c - ambient_c)
    for time_s, sensed_c in course(site, network, ambient_c=ambient_c):
        if sensed_c >= goal_c:
            return time_s
    return LONGEST_S


def rise_k(site: Place, after_s: float) -> float:
    """Return how far full power raises the loop's sensor from cold in a time (at most a day), K."""
    most_k = 0.0
    for time_s, risen_k in course(site, site.network, ambient_c=0.0):
        most_k = risen_k
        if time_s >= after_s:
            break
    return most_k


def course(
    site: Place,
    network: ThermalNetwork,
    *,
    ambient_c: float,
    starts_c: Mapping[str, float] | None = None,
    step_s: float | None = None,
) -> Iterator[tuple[float, float]]:
    """Yield time (s) and temperature (°C) at full power, from cold or from given temperatures."""
    cold = network.model_copy(update={"initial_c": ambient_c})
    step_s = step_s or max(COURSE_STEP_S, site.loop.period_s)
    plant = plant_of(site.controller, cold, ambient_c=ambient_c, step_s=step_s, starts_c=starts_c)
    asked = _powered(site, asked_share(site, site.loop.algorithm.full_percent))
    for row in range(round(LONGEST_S / step_s)):
        yield row * step_s, plant.sensed_c()[site.loop.sensor]
        plant.step(asked)


def usable_c(site: Place, network: ThermalNetwork, *, ambient_c: float) -> float:
    """Return the highest setpoint at which this healthy machine trips no rule, °C.

    If full power is too weak to raise the temperature near the setpoint, `heating_failed` and
    `sensor_frozen` rightly trip. Two starts must not trip: from cold, and from `WARM_K` below the
    setpoint with a cold element, which first has to heat up. With PID, `sensor_frozen` also limits
    the setpoint to what the duty `holding` can hold. The spec's highest setpoint is another limit.
    """
    needs, frozen = list(_needed_rises(site)), site.loop.protection.frozen
    highest_c = min(
        site.loop.setpoint.maximum_c + _beyond_k(site.loop),
        steady_c(site, asked_share(site, site.loop.algorithm.full_percent), ambient_c=ambient_c),
    )
    if site.loop.algorithm.continuous and frozen is not None and frozen.holding_percent > 0:
        held = plant_of(site.controller, network, ambient_c=ambient_c, step_s=FOREVER_S)
        held.step(_powered(site, asked_share(site, frozen.holding_percent)))
        highest_c = min(highest_c, held.sensed_c()[site.loop.sensor])
    courses = tee(course(site, network, ambient_c=ambient_c), len(needs))
    cold_c = [
        _rising_until(taken, highest_c, *each) for taken, each in zip(courses, needs, strict=True)
    ]
    most_c, least_c = min([highest_c, *cold_c]) - _beyond_k(site.loop), ambient_c
    if _comes_warm(site, network, ambient_c, most_c, needs):
        return most_c
    while most_c - least_c > NEAR_K:
        middle_c = (most_c + least_c) / 2
        if _comes_warm(site, network, ambient_c, middle_c, needs):
            least_c = middle_c
        else:
            most_c = middle_c
    return least_c


def _beyond_k(loop: Loop) -> float:
    """Return how far above its setpoint a loop still commands full power, K."""
    return max(0.0, loop.algorithm.off_at_k)


def _comes_warm(
    site: Place,
    network: ThermalNetwork,
    ambient_c: float,
    target_c: float,
    needs: Sequence[tuple[float, float]],
) -> bool:
    """Whether a machine that starts in the steady state reaches a setpoint from `WARM_K` below."""
    start_c, most_c = target_c - WARM_K, target_c + _beyond_k(site.loop)
    if start_c <= ambient_c:
        return True  # `usable_c` checks the start from cold
    spread_c = _with_cold_element(site, network, ambient_c, start_c)
    taken = course(site, network, ambient_c=ambient_c, starts_c=spread_c)
    return all(
        _rising_until(each, most_c, *need) >= most_c
        for each, need in zip(tee(taken, len(needs)), needs, strict=True)
    )


def _with_cold_element(
    site: Place, network: ThermalNetwork, ambient_c: float, start_c: float
) -> dict[str, float]:
    """Return each node's temperature, °C: that of a steady state, but at most the sensor's."""
    rested_c = profile_c(site.controller, network, site.loop_name, start_c, ambient_c=ambient_c)
    return {node: min(start_c, each_c) for node, each_c in rested_c.items()}


def _needed_rises(site: Place) -> Iterator[tuple[float, float]]:
    """Yield the rise (sensor's step included, K) and time (s) that each rule demands."""
    step_k, protection = sensor_step_k(site), site.loop.protection
    if protection.heating:
        yield protection.heating.rise_k + step_k, protection.heating.within_s
    if protection.frozen:
        yield 2 * step_k, protection.frozen.for_s


def _rising_until(
    taken: Iterable[tuple[float, float]], enough_c: float, rise_k: float, within_s: float
) -> float:
    """Return the temperature up to which a course rises fast enough, °C; stop at `enough_c`."""
    since_s, from_c = 0.0, -math.inf
    for time_s, sensed_c in taken:
        from_c = max(from_c, sensed_c) if time_s == 0 else from_c
        if sensed_c >= from_c + rise_k:
            since_s, from_c = time_s, sensed_c
        if time_s - since_s > within_s or from_c >= enough_c:
            break
    return from_c


def sensor_step_k(site: Place) -> float:
    """Return one step of the loop's sensor, K."""
    return float(site.controller.thermometers[site.loop.sensor].step_k)


def blur_k(controller: Controller, name: str, temperature_c: float) -> float:
    """Return the largest error of a sensor's analog reading, K; 0 for a sensor chip."""
    sensor = controller.thermometers[name]
    if not sensor.on_adc:
        return 0.0
    return float(sensor.step_at_k(temperature_c, controller.board.mcu))


def _powered(site: Place, share: float, *, cooled: bool = False) -> dict[str, float]:
    """Return the shares of power of all outputs: all on but coolers and other loops' heaters."""
    asked = full_power(site.controller, site.loop_name, share)
    return asked | ({site.loop.cooler: 1.0} if cooled and site.loop.cooler else {})
