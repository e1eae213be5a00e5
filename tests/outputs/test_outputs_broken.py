"""Each line of the outputs' C that decides something is broken in turn: it must be seen.

One cannot be: the stepper's `TCNTn = 0` for a compare value already passed. The part would count
all the way round; simavr takes the new value as if it had not been passed.
"""

import numpy as np
import pytest
from output_firmware import Broken
from pwm_firmware import PwmBoard
from stepper_firmware import Feed

CLOCK_HZ = 16_000_000
TICK_S = 0.01
LATENCY = 200
PERIOD = "OUTPUT_HEATER_PERIOD_COUNTS"
MINIMUM = "OUTPUT_HEATER_MINIMUM_COUNTS"

BY_INTERRUPTS = [
    Broken("heater", "(TCNT1 - period_start);\n        if (gone", "(TCNT1);\n        if (gone"),
    Broken("heater", f"if (gone >= {PERIOD}) {{\n", f"if (gone > 2u * {PERIOD}) {{\n"),
    Broken("heater", f"period_start = (uint16_t)(period_start + {PERIOD});", ""),
    Broken("heater", "pulse_counts = next_counts;", ""),
    Broken("heater", "pin_output_heater_on();\n            change", "change"),
    Broken("heater", "pin_output_heater_off();\n            change", "change"),
    Broken("heater", "change = pulse_counts;", f"change = {PERIOD};"),
    Broken("heater", "OCR1A = (uint16_t)(period_start + change);", ""),
    Broken("heater", "while ((uint16_t)(TCNT1 - period_start) >= change)", "while (false)"),
    Broken("heater", "TIMSK1 &= (uint8_t)~(1u << OCIE1A);", ""),
    Broken("heater", "pin_output_heater_off();\n    } else if", "} else if"),
    Broken("heater", "pin_output_heater_on();\n    } else {", "} else {"),
    Broken("heater", "next_counts = counts;", ""),
    Broken("heater", "if (!(TIMSK1 & (1u << OCIE1A)))", "if (true)"),
    Broken("heater", "TIMSK1 |= (1u << OCIE1A);", ""),
    Broken("heater", f"counts < {MINIMUM}", "false"),
    Broken("heater", f"counts > {PERIOD} - {MINIMUM}", "false"),
    Broken("heater", "permitted ? output_heater.on_counts : 0", "output_heater.on_counts"),
]
BY_TIMER = [
    Broken("heater", "TCCR2A &= (uint8_t)~((1u << COM2B1) | (1u << COM2B0));\n        pin_output_"
           "heater_off", "pin_output_heater_off"),
    Broken("heater", "TCCR2A &= (uint8_t)~((1u << COM2B1) | (1u << COM2B0));\n        pin_output_"
           "heater_on", "pin_output_heater_on"),
    Broken("heater", "pin_output_heater_off();", ""),
    Broken("heater", "pin_output_heater_on();", ""),
    Broken("heater", "counts - 1u", "counts"),
    Broken("heater", "TCCR2A |= (1u << COM2B1)", "TCCR2A |= (1u << COM2B1) | (1u << COM2B0)"),
    Broken("heater", "permitted ? output_heater.on_counts : 0", "output_heater.on_counts"),
]  # fmt: skip


def pwm_problem(bench: PwmBoard, *, finest: float) -> str:
    """Say what is wrong with a heater's pulses; empty if nothing."""
    whole, prescaler = bench.cycles_of("heater"), bench.channels["heater"].prescaler
    late = LATENCY if bench.channels["heater"].by_interrupts else 12
    for percent in (50.0, 5.0, 95.0, 0.0, 30.0, 100.0, 40.0, 0.0, 60.0):
        bench.ask("heater", percent)
        pulses = bench.seen("heater", 0.2)
        if percent in {0.0, 100.0} or not len(pulses.periods):
            if pulses.share != percent / 100:
                return f"{percent} % are {pulses.share}"
            continue
        counts = int(percent * bench.channels["heater"].counts / 100 + 0.5)
        if abs(pulses.periods - whole).max() > late:
            return f"periods of {pulses.periods} instead of {whole}"
        if abs(pulses.widths - counts * prescaler).max() > late:
            return f"pulses of {pulses.widths}, {percent} %"
    for percent, share in ((finest, 0.0), (100 - finest, 1.0)) if finest else ():
        bench.ask("heater", percent)
        if bench.seen("heater", 0.2).share != share:
            return f"{percent} % is not {share}"
    return gate_problem(bench)


def gate_problem(bench: PwmBoard) -> str:
    """Say whether the gate does not close."""
    for percent in (100.0, 95.0, 50.0, 90.0):
        bench.ask("heater", percent)
        bench.put("permitted", 0)
        bench.avr.run(TICK_S)
        if bench.seen("heater", 0.1).share:
            return "on with the gate closed"
        bench.put("permitted", 1)
        bench.avr.run(TICK_S)
    return ""


def late_problem(bench: PwmBoard) -> str:
    """Say what late interrupts do that they must not: at 490 Hz a tick finds every phase."""
    for deaf_us, percent in ((300, 50.0), (1800, 97.0), (1800, 3.0)):
        bench.put("deaf_us", deaf_us)
        bench.ask("heater", percent)
        widths = bench.seen("heater", 20.0).widths
        whole, late = bench.cycles_of("heater"), deaf_us * 16
        pulse = percent / 100 * whole
        # Who sleeps through a pause goes on with the next pulse.
        most = pulse + (late if late < whole - pulse else whole) + 2 * LATENCY
        if not len(widths) or widths.max() > most:
            return f"a pulse of {widths.max()} cycles, {most} at most"
    return ""


def by_interrupts(broken: Broken | None) -> str:
    said = "kind: pwm, pin: D4, frequency: 490 Hz, power: 40 W"
    bench = PwmBoard("uno", {"heater": said}, "reset", broken=broken)
    return pwm_problem(bench, finest=2.0) or late_problem(bench)


def by_timer(broken: Broken | None) -> str:
    said = "kind: pwm, pin: D3, frequency: 976.5625 Hz, power: 40 W"
    return pwm_problem(PwmBoard("uno", {"heater": said}, "reset", broken=broken), finest=0)


STEPPER = [
    Broken("feed", "rest < part_rest", "false"),
    Broken("feed", "counts - 1u", "counts + 9u"),
    Broken("feed", "parts_done < parts", "parts_done < parts + 1u"),
    Broken("feed", "parts_done = 0;\n    pin", "pin"),
    Broken("feed", "_delay_us(2);", ""),
    Broken("feed", "steps_left--;", ""),
    Broken("feed", "steps_left == 0) {\n        pause", "steps_left == 1) {\n        pause"),
    Broken("feed", "goal = backward ? goal + steps_left : goal - steps_left;", ""),
    Broken("feed", "goal = backward ? goal + steps_left : goal", "goal = backward ? goal : goal"),
    Broken("feed", "steps_left = 0;\n}", "}"),
    Broken("feed", "backward = is_backward;", ""),
    Broken("feed", "pin_output_feed_enable_on();", ""),
    Broken("feed", "ending = false;", ""),
    Broken("feed", "backward != is_backward || ending", "ending"),
    Broken("feed", "wanted_steps_per_s = OUTPUT_FEED_SLOWEST_STEPS_PER_S;", ""),
    Broken("feed", "wanted_steps_per_s = OUTPUT_FEED_FASTEST_STEPS_PER_S;", ""),
    Broken("feed", "steps_per_s = 0.0f; /* at rest", "; /* at rest"),
    Broken("feed", "goal += (uint32_t)steps;", ""),
    Broken("feed", "steps_left += is_backward", "steps_left = is_backward"),
    Broken("feed", "ending = output_feed_is_busy();", ""),
    Broken("feed", "forget();\n    pin", "pin"),
    Broken("feed", "pin_output_feed_enable_off();", ""),
    Broken("feed", "!loop_air_is_ready()", "false"),
    Broken("feed", "fault.code == FAULT_NONE && !ending", "!ending"),
    Broken("feed", "fault.code == FAULT_NONE && !ending", "fault.code == FAULT_NONE"),
    Broken("feed", "return faster < to ? faster : to;", "return to;"),
    Broken("feed", "return slower > to ? slower : to;", "return to;"),
    Broken("feed", "<= (float)left", "<= 2.0f * (float)left"),
    Broken("feed", "if (ending) {\n                forget();", "if (ending) {\n"),
]  # fmt: skip


MOTOR = "step: D4, direction: D5, enable: D6, steps: 200, microsteps: 16, lead: 25 mm"


def late_feed_problem(broken: Broken | None) -> str:
    """Say what late interrupts do to a feed, on a timer that takes long to come round."""
    feed = Feed("mega2560", f"{MOTOR}, maximum: 78 mm/s, acceleration: 800 mm/s²", broken)
    for deaf_us in range(20, 900, 20):
        feed.put("deaf_us", deaf_us)
        feed.move(1500, 78.0)
        if not _rested(feed, 1.5):
            return "the timer has stopped"
        gaps_s = np.diff(feed.times_s[-1500:])
        # The first interval of a ramp is the longest, and ends late by as much.
        if gaps_s.max() > 1 / 1024 + TICK_S:
            return f"a step {gaps_s.max()} s after the one before"
    return "" if feed.driver.position == 44 * 1500 else "steps lost"


def feed_problem(broken: Broken | None) -> str:
    """Say what is wrong with a feed; empty if nothing."""
    for check in (_ways, _course, _slow, _heat, _stop, _fault, _letting_go):
        feed = Feed("nano", f"{MOTOR}, maximum: 20 mm/s, acceleration: 50 mm/s²", broken)
        if problem := check(feed):
            return problem
        feed.run(2 * TICK_S)
        if feed.driver.violations or feed.driver.missed:
            return "the driver's timing"
        if feed.driver.position != feed.get("position"):
            return "the position"
    return ""


def _rested(feed: Feed, most_s: float) -> bool:
    until = feed.avr.time_s + most_s
    while feed.get("busy") and feed.avr.time_s < until:
        feed.run(0.05)
    return not feed.get("busy")


def _ways(feed: Feed) -> str:
    place = 0
    for steps in (1, 600, -100, -501, 7):
        feed.move(steps, 20.0)
        place += steps
        if not _rested(feed, 3.0) or feed.driver.position != place:
            return f"{steps} steps end at {feed.driver.position}, not {place}"
    feed.move(500, 5.0)
    feed.move(-20, 5.0)  # not while it runs the other way
    feed.move(30, 5.0)
    return "" if _rested(feed, 3.0) and feed.driver.position == place + 530 else "moves together"


def _course(feed: Feed) -> str:
    """20 mm at 20 mm/s with 50 mm/s²: 0.4 s up, 0.6 s, 0.4 s down."""
    feed.move(20 * 128, 25.0)
    speeds = []
    while feed.get("busy") and feed.avr.time_s < 10:
        speeds.append(float(feed.get("output_feed.c:steps_per_s")))
        feed.run(TICK_S)
    changes = np.abs(np.diff(speeds))
    if changes.max() > 64.01 or max(speeds) != 2560 or speeds[-1] > 80 + 2 * 64:
        return "the trapezoid"
    times_s = feed.times_s
    run = times_s[(np.arange(2560) > 700) & (np.arange(2560) < 1900)]
    speed = (len(run) - 1) / (run[-1] - run[0])
    ends = times_s[-1] - times_s[0]
    return "" if abs(speed - 2560) < 0.1 and 1.3 < ends < 1.4 + 2 * TICK_S else "the speed"


def _slow(feed: Feed) -> str:
    feed.move(8, 0.0001)
    if not _rested(feed, 12.0):
        return "too slow"
    speed = 4 / (feed.times_s[6] - feed.times_s[2])
    return "" if abs(speed - 1) < 1e-3 else "the slowest speed"


def _heat(feed: Feed) -> str:
    feed.move(2000, 20.0)
    feed.run(0.6)
    feed.put("ready", 0)
    feed.run(0.6)
    waiting = feed.driver.position
    feed.run(0.5)
    if not 700 < waiting < 1700 or feed.driver.position != waiting or not feed.get("busy"):
        return "no waiting"
    feed.put("ready", 1)
    return "" if _rested(feed, 3.0) and feed.driver.position == 2000 else "no going on"


def _stop(feed: Feed) -> str:
    feed.move(4000, 20.0)
    feed.run(0.6)
    feed.put("stop", 1)
    if not _rested(feed, 0.8) or not 700 < feed.driver.position < 1700:
        return "no stop"
    before = feed.driver.position
    feed.move(-50, 20.0)
    return "" if _rested(feed, 1.0) and feed.driver.position == before - 50 else "no new move"


def _fault(feed: Feed) -> str:
    feed.put("fault.code", 6)
    feed.move(500, 20.0)
    feed.run(0.2)
    if feed.driver.position or not feed.get("busy"):
        return "a step with a fault"
    feed.put("fault.code", 0)
    feed.run(0.3)
    before = feed.driver.position
    feed.put("healthy", 0)
    feed.run(0.3)
    if feed.driver.position > before + 26 or feed.driver.on or feed.get("busy"):
        return "no end at a fault"
    feed.put("healthy", 1)
    feed.run(0.3)
    return "" if feed.driver.position <= before + 26 else "goes on after a fault"


def _letting_go(feed: Feed) -> str:
    feed.move(-4000, 20.0)
    feed.run(0.5)
    feed.put("disable", 1)
    feed.run(0.1)
    if feed.driver.on or feed.get("busy"):
        return "no letting go"
    made = len(feed.driver.steps)
    feed.move(-100, 20.0)
    feed.run(0.2)
    first_s = np.diff(feed.times_s[made : made + 2])[0]
    return "" if first_s > 1 / (80 + 2 * 64) else "from rest at full speed"


@pytest.mark.parametrize("judge", [by_interrupts, by_timer, feed_problem, late_feed_problem])
def test_nothing_is_wrong_with_the_whole(judge) -> None:  # type: ignore[no-untyped-def]
    assert judge(None) == ""


@pytest.mark.parametrize(
    ("judge", "broken"),
    [
        *((by_interrupts, each) for each in BY_INTERRUPTS),
        *((by_timer, each) for each in BY_TIMER),
        *((feed_problem, each) for each in STEPPER),
    ],
    ids=lambda each: f"{each.right[:40]} -> {each.wrong[:40]}" if isinstance(each, Broken) else "",
)
def test_what_is_broken_is_seen(judge, broken: Broken) -> None:  # type: ignore[no-untyped-def]
    assert judge(broken) != ""
