"""One drawn loop: a machine, an algorithm that fits it, and protections that it does not trip."""

import math
from typing import Any, NamedTuple

from rig.controllers_parts import (
    NARROWEST_K,
    Part,
    Sensors,
    Unsuited,
    own_draws,
    step_k,
    text,
    tidy,
    usable_c,
)

from heatwright.spec.checks.loops.timing import MOST_MISSING
from heatwright.spec.checks.sensing.reading import shortest_period_s
from heatwright.spec.loops import LONGEST_RULE_S, MOST_STEPS
from heatwright.spec.sensing.max31856 import lowered

TICK_S = 0.01
LONGEST_PERIOD_S = 600.0  # unless a sensor takes longer
SIGMA = 5.670374e-8  # of Stefan and Boltzmann, W/m²/K⁴
AMBIENT_C = 20.0
FASTEST_K_PER_S = 500.0
FEED_MM_PER_S = 5.0


class Served(NamedTuple):
    by_master: bool
    by_host: bool
    switched: bool
    programmed: bool
    has_menu: bool

    @property
    def zero_is_off(self) -> bool:
        return self.by_host and not self.switched


class LoopDraw:
    """Draws one loop with its sensors, outputs and its part of the plant."""

    def __init__(
        self, name: str, sensors: Sensors, served: Served, spare_pins: int, *, cold: bool
    ) -> None:
        self.name, self.served, self._spare_pins = name, served, spare_pins
        self.draws, self.board, self.left = sensors.draws, sensors.board, sensors.left
        self.sensors, self.outputs, self.fans, self.sense = (dict[str, Part]() for _ in range(4))
        self.loop: Part = {}
        self.links, self.radiation = list[Part](), list[Part]()
        self.nodes: dict[str, str] = {}
        chosen = served.has_menu and served.switched
        part, self.sensor = sensors.draw(spare_pins - 2, chosen=chosen, cold=cold)
        self._spare_pins -= sum(key in part for key in ("clock", "data_in", "data_out"))
        self.lowers = "selectable" in part and not own_draws(part).seldom()
        """A type that bears less may be chosen."""
        self.sensors[f"{name}_felt"] = part
        self.reference = sensors.reference
        kinds = ["on_off", "pid"] + ["three_position"] * (self._spare_pins >= 3)
        self.kind = str(self.draws.one(*kinds))
        self._period()
        self._temperatures()
        self._heater()
        self._cooler_and_fan()
        self._machine()
        self._algorithm()
        self._settings()
        self._protection()
        self._adjustable()
        self._plant()

    def _period(self) -> None:
        shortest_s = shortest_period_s(self.sensor)
        longest_s = max(shortest_s, LONGEST_PERIOD_S)
        usual_s = self.draws.one(1.0, 0.2, 2.0)
        self.period_s = self.draws.number(shortest_s, longest_s, usual_s, TICK_S)
        if self.period_s > 2 and not self.draws.seldom():  # most loops are quicker
            self.period_s = max(shortest_s, usual_s)

    def _temperatures(self) -> None:
        """Choose the start and the maximum; the setpoints follow from the machine."""
        self.floor_c, ceiling_c = usable_c(self.sensor, hottest_own=self.lowers)
        self.start_c = AMBIENT_C if self.floor_c < AMBIENT_C - 5 else math.ceil(self.floor_c) + 10.0
        least_c = self.start_c + 0.6 * (min(ceiling_c, self.start_c + 400) - self.start_c)
        if self.lowers:  # so hot that another type does not bear it
            least_c = min(max(least_c, usable_c(self.sensor)[1] + 30), ceiling_c)
        self.maximum_c = self.draws.number(least_c, ceiling_c, 300, 0.1)
        self.span_k = self.maximum_c - self.start_c
        if self.span_k < NARROWEST_K / 3:
            raise Unsuited  # the sensor is too coarse
        lowest_c = max(self.floor_c, -10.0)
        self.step_k = step_k(self.sensor, self.board.mcu, lowest_c, self.maximum_c)
        self.error_k = self.sensor.error_k(self.maximum_c)

    def _heater(self) -> None:
        draws = self.draws
        kinds = ["digital"] * (self.kind != "pid") + ["time_proportional", "pwm"]
        kind = draws.one(*kinds)
        measured = kind != "time_proportional" and self.period_s <= 1 and draws.some()
        self.measured = measured and self.left.has_analog()
        self.amps_pin = self.left.analog() if self.measured else ""
        slowest_hz = 15 / self.period_s if self.measured else 1.0
        pulses = self.left.pwm(slowest_hz, heats=True) if kind == "pwm" else None
        if kind == "pwm" and pulses is None:
            kind, self.measured = "time_proportional", False
        part = {"kind": kind, **(pulses or {"pin": self.left.digital(heats=True)})}
        part |= draws.maybe({"active": "low"})
        self.power_w = draws.one(100.0, 40.0, 2000.0, 1.5, 12_000.0)
        part["power"] = text(self.power_w, "W")
        if kind == "pwm" and draws.some():
            part["supply"] = "24 V"
            if not self.measured and draws.some():
                part["rated"] = draws.one("24 V", "12 V")
        self.window_s = 0.0
        part |= self._window() if kind == "time_proportional" else {}
        self.held_on_s, self.held_off_s = 0.0, 0.0
        if kind == "digital" and not self.measured and draws.seldom():
            self.held_on_s, self.held_off_s = self._rests(part)
        self.heater_kind, self.heater = kind, part
        self.outputs[f"{self.name}_heater"] = part

    def _window(self) -> Part:
        draws = self.draws
        spread = draws.some()
        step_ms = draws.number(10, 100, 10, 10)
        step_ms = draws.number(20, 100, 20, 20) if spread else step_ms
        steps = draws.number(100, 2000, 100)
        part = {"window": text(steps * step_ms, "ms")}
        part |= {"resolution": text(step_ms, "ms")} if step_ms > 10 else {}
        self.window_s = steps * step_ms / 1000
        if spread:
            return part | {"distribution": "spread"}
        for key in ("minimum_on", "minimum_off"):
            part |= draws.maybe({key: text(draws.number(1, steps // 2, 3) * step_ms, "ms")})
        return part

    def _rests(self, part: Part) -> tuple[float, float]:
        most_s = min(600, 3 * self.period_s)
        on_s, off_s = (self.draws.number(0, most_s, self.period_s, TICK_S) for _ in range(2))
        part |= {"minimum_on": text(on_s, "s")} if on_s else {}
        part |= {"minimum_off": text(off_s, "s")} if off_s else {}
        return on_s, off_s

    def _cooler_and_fan(self) -> None:
        draws = self.draws
        self.cooler_on_s, self.cooler_off_s, self.cools, self.fan_factor = 0.0, 0.0, 1.0, 1.0
        if self.kind == "three_position":
            part = {"kind": "digital", "pin": self.left.digital()}
            part |= draws.maybe({"active": "low"})
            if not self.measured and draws.seldom():
                self.cooler_on_s, self.cooler_off_s = self._rests(part)
            self.outputs[f"{self.name}_cooler"] = part
            self.cools = draws.one(2.0, 1.1, 8.0)
        elif self._spare_pins >= 4 and draws.seldom():
            part = {"kind": "digital", "pin": self.left.digital(), "runs": "always"}
            part |= draws.maybe({"active": "low"})
            if self._spare_pins >= 5 and draws.some() and not self.measured:
                part["proof"] = {"pin": self.left.digital(), "within": draws.one("5 s", "1 s")}
                self._tachometer(part["proof"])
            self.outputs[f"{self.name}_fan"] = part
            self.fan_factor = draws.one(1.0, 2.5)

    def _tachometer(self, proof: Part) -> None:
        """Now and then the pin has pulses; a fan whose speed and limits can be counted."""
        draws = own_draws({**proof, **self.outputs})
        if not draws.some():
            return
        pulses = draws.one(2, 1, 4, 12)
        slowest, fastest = 8 * 60 / pulses, 350 * 60 / pulses
        speed = draws.number(2 * slowest, fastest / 1.5, 3000)
        part = {"speed": text(speed, "rpm"), "pulses": pulses}
        least = speed / 2
        if draws.some():
            least = draws.number(max(slowest, speed / 10), 0.8 * speed, speed / 2)
            most = draws.number(1.2 * speed, min(fastest, 12 * least), 1.5 * speed)
            part |= {"minimum": text(least, "rpm"), "maximum": text(most, "rpm")}
        window_s = math.ceil(16 / (least * pulses / 60) * 100) / 100
        proof |= {"tachometer": part, "within": text(math.ceil(1 + 2 * window_s), "s")}

    def _machine(self) -> None:
        draws = self.draws
        self.delay_s = draws.one(0.0, 0.0, 0.5) * self.period_s
        self.lag_s = draws.one(0.0, 2.0, 10.0) * self.period_s
        behind_s = (self.sensor.moving_average - 1) / 2 * self.period_s
        self.late_s = self.delay_s + behind_s + self.period_s + self.lag_s + self.held_on_s
        self.rate_k_per_s = self.span_k / 15 / self.late_s * draws.one(1.0, 0.3, 0.1)
        self.rate_k_per_s = min(self.rate_k_per_s, FASTEST_K_PER_S, 10 * self.power_w)
        self.band_k = self._band()
        coasts_k = 2 * self.rate_k_per_s * self.late_s
        margin_k = self.error_k + self.band_k + coasts_k + 0.2
        highest_c = self.maximum_c - margin_k
        self.high_c = draws.number(highest_c - 0.2 * self.span_k, highest_c, 250, 0.1)
        self.coasts_k = coasts_k
        self.most_percent = draws.number(30, 100, 100) if self.kind == "pid" else 100.0
        self.strength = draws.one(2.0, 1.4, 5.0)  # full power over what holds the highest setpoint
        self.full_w = self.power_w * self.most_percent / 100
        if self.measured:
            self._current()

    def _band(self) -> float:
        """Return how far from the setpoint a healthy loop may be on its own account."""
        if self.kind == "pid":
            return 0.0
        widest_k = 1.5 * self.step_k
        band_k = self.draws.number(0, 20, 0 if self.kind == "on_off" else widest_k, 0.1)
        least_k = 0.0 if self.kind == "on_off" else math.ceil(10 * widest_k) / 10 + 0.1
        held_k = self.rate_k_per_s * max(self.held_on_s, self.cools * self.cooler_on_s)
        return min(max(band_k, least_k, tidy(held_k)), max(0.1 * self.span_k, least_k))

    def _current(self) -> None:
        draws = self.draws
        self.heater["supply"] = supply = draws.one("24 V", "12 V", "230 V")
        mean_of_rms = draws.one(1.0, 0.5) if self.heater_kind == "pwm" else 1.0
        rated_v = float(supply.split()[0]) * mean_of_rms
        self.heater |= {"rated": text(rated_v, "V")} if mean_of_rms < 1 else {}
        full_a = self.power_w / rated_v
        held: Part = {}
        most_a = full_a
        if self.heater_kind == "pwm" and draws.some():
            most_a = tidy(full_a * draws.one(0.8, 0.5, 1.2))
            held["limit"] = text(most_a, "A")
            self.full_w = min(self.full_w, self.power_w * (most_a / full_a) ** 2)
        over_a = 1.25 * most_a
        if "limit" not in held or draws.some():
            over_a = tidy(max(1.0, draws.one(1.5, 1.2, 3.0)) * most_a)
            held["trip"] = text(over_a, "A")
        full_v = {"supply": 5.0, "internal": 1.1}.get(self.reference) or 3.0
        part: Part = {"kind": "current", "pin": self.amps_pin}
        part["scale"] = f"{text(tidy(0.85 * full_v / over_a / mean_of_rms))} V/A"
        if draws.some():
            part["offset"] = text(tidy(0.05 * full_v), "V")
        most = round(self.period_s / TICK_S)
        most = max(1, most // 2) if "limit" in held else most
        oversample = draws.number(1, min(32, most), 4)
        part |= {"oversample": int(oversample)}
        part |= {"reference": self.reference} if self.reference != "supply" else {}
        exact = {"scale": "1 %", "offset": "5 mV", "reference": "20 mV"}
        part |= own_draws(part).maybe({"tolerances": exact})
        self.sensors[f"{self.name}_amps"] = part
        self.sense[f"{self.name}_amps"] = {"of": f"{self.name}_heater"}
        self.heater["current"] = {"sensor": f"{self.name}_amps", **held}

    def _algorithm(self) -> None:
        draws = self.draws
        part: Part = {"kind": self.kind}
        if self.kind == "pid":
            part |= self._pid()
        else:
            key = "hysteresis" if self.kind == "on_off" else "dead_band"
            part |= {key: text(self.band_k, "K")} if self.band_k else {}
            if self.kind == "three_position" and draws.some():
                widest_k = min(self.band_k, 2 * self.band_k - 1.2 * self.step_k)
                part["hysteresis"] = text(draws.number(0.0, widest_k, 0.5, 0.01), "K")
            if draws.some():
                part["lead"] = text(draws.number(0, 60, 12, 0.1), "s")
                part["lead_filter"] = text(draws.number(0, 30, 4, 0.1), "s")
        self.loop["algorithm"] = self.algorithm = part

    def _pid(self) -> Part:
        draws = self.draws
        usual_kp = tidy(1000 / self.span_k)
        swing_k = self.rate_k_per_s * self.power_w / self.full_w * self.window_s
        most_kp = min(1e6, 40 / (swing_k + 1e-4))
        kp = tidy(draws.one(1.0, 0.0, 0.1, 1e6) * usual_kp)
        part: Part = {"kp": min(kp, tidy(most_kp))}
        self.integrates = part["kp"] == 0 or draws.one(True, False)
        if self.integrates:
            part["ki"] = tidy(draws.one(0.01, 1e-5, 3.0) * usual_kp / self.period_s)
        if draws.some():
            part["kd"] = tidy(draws.one(10.0, 0.1) * usual_kp * self.period_s)
            part |= draws.maybe({"derivative_of": "error"})
            part |= draws.maybe({"derivative_step": "previous"})
        if self.served.programmed and draws.some():
            part["feed_forward"] = tidy(min(1e6, draws.one(100.0, 1e4) / self.rate_k_per_s))
        if draws.some():
            part["derivative_filter"] = text(draws.number(0, 60, 3, 0.1), "s")
        if draws.some():
            part["dead_band"] = text(draws.number(0, 5, 0.1, 0.01), "K")
            part |= draws.maybe({"dead_band_keeps": "output"})
        dead_k = float(part.get("dead_band", "0 K").split()[0])
        if draws.some():
            least_k = math.ceil(max(dead_k, self.step_k)) + 1
            part["band"] = text(draws.number(least_k, least_k + 50, 10), "K")
        return part | self._limits()

    def _limits(self) -> Part:
        """Bound the integral and the output so that the machine can be held."""
        draws = self.draws
        held = 100 * self.full_w / self.strength / self.power_w
        part: Part = {}
        if self.most_percent < 100:
            part["output"] = {"maximum": text(self.most_percent, "%")}
        if self.integrates and draws.some():
            most = draws.number(1.2 * held + 1, 100, 100)
            least = draws.number(-100, min(0.6 * held, self.most_percent - 1), 0)
            part["integral"] = {"minimum": text(least, "%"), "maximum": text(most, "%")}
            part["integral"] |= draws.maybe({"while_limited": "run"})
        return part

    def _settings(self) -> None:
        draws, served = self.draws, self.served
        lowest_c = max(self.floor_c + 0.1, -50.0 if draws.seldom() else -10.0)
        self.noise_k = tidy(self.step_k) if draws.seldom() else 0.0
        coldest_c = min(self.start_c - 1 - self.step_k - 6 * self.noise_k, self.high_c - 10)
        self.minimum_c = draws.number(lowest_c, max(coldest_c, lowest_c), -10, 0.1)
        low_c = draws.number(self.minimum_c + 0.2, self.high_c - 5, self.start_c - 0.5, 0.1)
        least_c = low_c
        if not (served.by_host or served.by_master or served.switched):
            least_c = max(low_c, min(AMBIENT_C + 1, self.high_c))  # nobody asks for more
        first_c = draws.number(least_c, self.high_c, least_c, 0.1)
        if self.lowers:
            lesser = lowered(self.sensor, self.high_c, self.maximum_c).values()
            first_c = min(first_c, *lesser, self.high_c)
            if first_c < low_c:
                raise Unsuited  # of that type nothing could be asked
        if served.zero_is_off and draws.some():
            low_c = first_c = 0.0
        self.low_c = low_c
        limits = {"minimum": text(low_c, "°C"), "maximum": text(self.high_c, "°C")}
        self.loop["setpoint"] = {"initial": text(first_c, "°C"), **limits}
        self.loop["setpoint"] |= draws.maybe({"stored": True})
        self._least_duty()
        if served.switched and draws.some():
            self.loop["starts"] = draws.one("enabled", "disabled")
        asked = served.by_host or served.by_master
        if self.kind == "pid" and asked and draws.some():
            warm_s = 20 * self.span_k / self.rate_k_per_s + 20 * self.late_s
            longest_s = MOST_STEPS * self.period_s
            tune = {"timeout": text(min(math.ceil(max(warm_s, 1200)), longest_s), "s")}
            tune |= draws.maybe({"cycles": int(draws.number(3, 20, 5))})
            tune |= draws.maybe({"swing": text(draws.number(1, 100, 100), "%")})
            self.loop["autotune"] = tune
        if draws.some():
            settled: Part = {"within": text(tidy(max(self.step_k, self.band_k)), "K")}
            stays_s = draws.number(self.period_s, 500 * self.period_s, max(60, self.period_s))
            if self.period_s > 60 or draws.some():
                settled["for"] = text(max(stays_s, self.period_s), "s")
            self.loop["response"] = settled
        if asked and not (served.by_master and self.kind == "three_position") and draws.some():
            self.ready()

    def _least_duty(self) -> None:
        """Let the output have a least duty that heats no farther than the lowest setpoint."""
        full_k = self.strength * (self.high_c - AMBIENT_C) * self.power_w / self.full_w
        most = (self.low_c - AMBIENT_C) / (full_k / 100)
        if self.kind == "pid" and most > 2 and self.draws.some():
            output = self.algorithm.setdefault("output", {})
            output["minimum"] = text(self.draws.number(1, min(0.8 * most, 20), 1), "%")

    def ready(self) -> None:
        least_k = max(self.band_k, self.step_k, self.dead_k, 0.5)
        self.loop["ready_within"] = text(tidy(self.draws.one(1.5, 4.0) * least_k), "K")

    def _protection(self) -> None:
        draws = self.draws
        longest_s = min(MOST_STEPS * self.period_s, LONGEST_RULE_S)
        rules: Part = {"maximum": text(self.maximum_c, "°C")}
        if self.high_c + 15 <= self.maximum_c and draws.some():
            margin_k = self.coasts_k + self.band_k + self.error_k + 0.2
            rules = rules if margin_k > 15 else {}  # the default is lower
        if self.served.has_menu and (draws.some() or self.lowers):
            rules["maximum_adjustable"] = True
        rules["minimum"] = text(self.minimum_c, "°C")
        falls = self.cools * self.fan_factor * self.rate_k_per_s / self.strength * 1.1
        blur_k = self.step_k + 6 * 2**0.5 * self.noise_k
        pulses = self.power_w / self.full_w if self.heater_kind != "digital" else 1.0
        rate = max(self.rate_k_per_s * 1.2 * pulses, falls) + blur_k / self.period_s
        rate *= 1 + self.sensor.free_running_s / self.period_s
        rate = max(1.05 * rate * draws.one(1.5, 1.0, 10.0), 1e-3)
        rules["rise_rate"] = text(tidy(rate, 4), "K/s")
        slowest = self.rate_k_per_s * (1 - 1 / self.strength)
        rise_k = draws.one(2.0, 0.1, 10.0)
        waits_s = max(self.held_off_s, self.cooler_on_s, 2 * self.window_s)
        held_s = self.delay_s + waits_s + 3 * self.lag_s
        # What the machine loses while the heater waits, at most as fast as it heats, it regains.
        regains_s = waits_s * self.rate_k_per_s / slowest / self.strength
        within_s = 4 * (rise_k + self.step_k) / slowest + 2 * (held_s + regains_s + self.period_s)
        self._rule(rules, "heating", {"rise": text(rise_k, "K"), "within": self._time(within_s)})
        rules |= {"heating": "off"} if within_s > longest_s else {}
        self._runaway(rules)
        if self.kind == "pid" and not self.integrates:
            rules["frozen"] = "off"
        elif draws.some():
            self._frozen(rules, slowest, held_s)
        settle_s = 10 * (self.late_s + self.held_on_s)
        rise_k = tidy(max(self.coasts_k, draws.one(10.0, 1.0)))
        settles = {"rise": text(rise_k, "K"), "settle": self._time(settle_s)}
        self._rule(rules, "rising_while_off", settles)
        least_s = max(2 * self.period_s, 0.03 if draws.seldom() else 0.3)
        stale_s = draws.number(least_s, MOST_MISSING * self.period_s, 5, TICK_S)
        starting = 1 + math.ceil(round(self.sensor.first_s / self.period_s, 6))
        self.stale_s = max(stale_s, round(starting * self.period_s, 2))
        rules["stale_after"] = text(self.stale_s, "s")
        if self.served.by_master and draws.some():
            rules["master_lost_after"] = text(draws.number(10, 600, 20), "s")
        own = own_draws(rules)
        if self.served.by_host and own.some():
            lost = text(own.number(100, 600, 20), "s")
            rules["master_lost_after"] = own.one("off", lost)
        self.loop["protection"] = rules

    def _adjustable(self) -> None:
        """Let a host narrow the limits, where rules are left for what it may make of them."""
        if self.kind != "pid" or not self.integrates or not self.served.by_host:
            return
        if own_draws(self.algorithm).some():
            rules: Part = self.loop["protection"]
            given = {} if rules["runaway"] == "off" else rules["runaway"]
            band = {side: text(self.above_k, "K") for side in ("above", "below")}
            rules["runaway"] = {**band, "for": self._time(60 * self.period_s), **given}
            rules.pop("frozen", None)  # derived from the plant
            self.runs_away = True
            self.algorithm["limits_adjustable"] = True

    def _frozen(self, rules: Part, slowest: float, held_s: float) -> None:
        """Have a reading move with somewhat more heat than holding needs."""
        most = 100 * self.full_w / self.power_w
        held = most / self.strength
        share = self.draws.number(0.3, 0.9, 0.5)
        still_s = self.step_k / (share * slowest) + held_s
        for_s = max(4 * still_s, self.draws.one(600, 60) * self.period_s)
        holding = text(tidy(held + share * (most - held)), "%")
        self._rule(rules, "frozen", {"for": self._time(for_s), "holding": holding})

    def _time(self, seconds: float) -> str:
        longest_s = min(MOST_STEPS * self.period_s, LONGEST_RULE_S)
        return text(min(max(math.ceil(seconds), math.ceil(self.period_s)), longest_s), "s")

    def _rule(self, rules: Part, name: str, part: Part) -> None:
        rules[name] = "off" if self.draws.seldom() else part

    def _runaway(self, rules: Part) -> None:
        draws = self.draws
        held_s = max(self.held_on_s, self.cooler_off_s)
        least_k = math.ceil(self.band_k) + 1
        self.above_k: float = self._beyond_dead_band(draws.number(least_k, least_k + 50, 10, 0.1))
        rule = {"above": text(self.above_k, "K")}
        if draws.some():
            waits_s = max(self.held_off_s, self.cooler_on_s, 2 * self.window_s)
            late_s = 0.0 if self.kind == "pid" else self.late_s + waits_s + 2 * self.period_s
            least_k += math.ceil(3 * late_s * self.rate_k_per_s / self.strength)
            if self.kind == "pid" and not self.integrates:  # comes to rest below its setpoint
                held = 100 * self.full_w / self.strength / self.power_w
                least_k += math.ceil(1.5 * held / self.algorithm["kp"])
            below_k = self._beyond_dead_band(draws.number(least_k, least_k + 50, 10, 0.1))
            rule["below"] = text(below_k, "K")
            held_s = max(held_s, 1.1 * (waits_s + 2 * self.late_s))
            self.above_k = min(self.above_k, below_k)
        rule["for"] = self._time(max(2 * held_s, draws.one(60, 10, 1000) * self.period_s))
        self._rule(rules, "runaway", rule)
        self.runs_away = rules["runaway"] != "off"

    @property
    def dead_k(self) -> float:
        return float(self.algorithm.get("dead_band", "0 K").split()[0])

    def _beyond_dead_band(self, limit_k: float) -> float:
        if limit_k > self.dead_k or self.kind != "pid":
            return limit_k
        return math.ceil(self.dead_k) + limit_k

    def _plant(self) -> None:
        name, draws = self.name, self.draws
        target_k = self.high_c - AMBIENT_C
        ohm = self.strength * target_k / self.full_w
        joule = tidy(self.full_w / self.rate_k_per_s, 4)
        shape = draws.one("one", "radiates", "walls", "element")
        self.nodes[name] = text(joule, "J/K")
        outer, heated = name, name
        if shape == "element":
            heated = f"{name}_wire"
            self.nodes[heated] = text(tidy(joule / 20), "J/K")
            self._link(heated, name, ohm / 40)
        elif shape == "walls":
            outer = f"{name}_walls"
            self.nodes[outer] = text(tidy(joule / 2), "J/K")
            self._link(name, outer, 0.2 * ohm)
            ohm *= 0.8
        self._link(outer, "ambient", ohm * self.fan_factor)
        spare_w = 0.1 * self.full_w * (1 - 1 / self.strength)
        self.fed = text(tidy(min(0.0056, spare_w / target_k / FEED_MM_PER_S)), "J/K/mm")
        most_c = math.ceil(min(AMBIENT_C + 2 * self.power_w * ohm * self.fan_factor, 5000))
        self.bears = {node: text(most_c, "°C") for node in self.nodes}
        for role, factor in (("fan", self.fan_factor), ("cooler", self.cools)):
            if f"{name}_{role}" in self.outputs and (factor > 1 or role == "cooler"):
                self.fans[f"{name}_{role}"] = {"link": [outer, "ambient"], "factor": factor}
        if shape == "radiates":
            hot_k4 = (self.high_c + 273.15) ** 4 - (AMBIENT_C + 273.15) ** 4
            area = text(tidy(0.1 * self.full_w / self.strength / (SIGMA * hot_k4 * 0.8)), "m²")
            faces = {"between": [outer, "ambient"], "area": area}
            self.radiation.append({**faces, "emissivity": 0.8})
        sense: Part = {"node": name}
        sense |= {"lag": text(self.lag_s, "s")} if self.lag_s else {}
        sense |= {"delay": text(self.delay_s, "s")} if self.delay_s else {}
        sense |= {"noise": text(self.noise_k, "K")} if self.noise_k else {}
        self.sense[f"{name}_felt"] = sense
        self.heat = heated

    def _link(self, one: str, other: str, ohm: float) -> None:
        self.links.append({"between": [one, other], "resistance": text(tidy(ohm, 4), "K/W")})

    def parts(self) -> Part:
        found: Part = {"sensor": f"{self.name}_felt", "heater": f"{self.name}_heater"}
        for role in ("fan", "cooler"):
            if f"{self.name}_{role}" in self.outputs:
                found[role] = f"{self.name}_{role}"
        return found | {"period": text(self.period_s, "s"), **self.loop}


def joined(loops: list[LoopDraw], what: str) -> dict[str, Any]:
    return {key: part for loop in loops for key, part in getattr(loop, what).items()}
