"""PWM that the timers can make, and which timer makes each PWM output.

The timer of the output's pin makes it with its compare output, or a 16-bit timer makes it by
interrupts, at any pin.
"""

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from heatwright.spec.boards import Board, Pin, Timer
from heatwright.spec.controller import Controller
from heatwright.spec.loading.suggest import listed
from heatwright.spec.outputs import SLOWEST_PWM_HZ, PwmOutput
from heatwright.spec.problems import Path
from heatwright.spec.quantity import hertz

FREQUENCY_TOLERANCE = 0.005
"""Tolerance of an Uno's ceramic resonator: a PWM frequency cannot be more accurate."""

FEWEST_COUNTS = 100
"""Minimum number of steps of a PWM period: one step is then at most 1 % of the power."""

FASTEST_BY_INTERRUPTS_HZ = 500.0
"""Maximum frequency: two interrupts a period, some 100 cycles each, use 0.6 % of a 16 MHz clock."""

MOST_COUNTS_BY_INTERRUPTS = (1 << 15) - 1
"""Longest PWM period, half the range of a free-running 16-bit timer: an edge that is up to a period
late is then not mistaken for a future edge."""

LATEST_INTERRUPT_S = 50e-6
"""Longest time for which other interrupts delay one: a 1-Wire slot's is the longest. A pulse or a
pause that is shorter cannot be made, and is left out."""


class PwmSetting(NamedTuple):
    """How a timer makes a PWM: `counts` counts of clock/`prescaler` to a period."""

    prescaler: int
    counts: int
    frequency_hz: float


def pwm_settings(clock_hz: int, timer: Timer) -> Iterator[PwmSetting]:
    """List an 8-bit timer's settings: 256 counts of each prescaled clock, the fastest first."""
    for prescaler in timer.prescalers:
        counts = 1 << timer.bits
        yield PwmSetting(prescaler, counts, clock_hz / (prescaler * counts))


def pwm_setting(board: Board, output: PwmOutput) -> PwmSetting:
    """Find the setting nearest to the output's frequency, on the timer of its pin.

    An 8-bit timer counts to 256 (fast PWM, mode 3); a 16-bit one to any number (mode 14), here with
    the smallest prescaler that makes the period, for the finest steps. Raises ValueError: the pin
    has no timer.
    """
    pin = board.pins[output.pin]
    if pin.pwm is None:
        raise ValueError(f"{output.pin} has no compare output")
    timer = board.timers[pin.pwm[0]]
    if timer.bits == 8:
        settings = pwm_settings(board.clock_hz, timer)
        return min(settings, key=lambda each: _distance(each.frequency_hz, output.frequency_hz))
    for prescaler in timer.prescalers:
        counts = round(board.clock_hz / (prescaler * output.frequency_hz))
        if counts < 1 << timer.bits:
            break
    counts = min(max(counts, FEWEST_COUNTS), (1 << timer.bits) - 1)
    return PwmSetting(prescaler, counts, board.clock_hz / (prescaler * counts))


def _distance(frequency_hz: float, wanted_hz: float) -> float:
    """Return the ratio of the higher of two frequencies to the lower one."""
    return max(frequency_hz / wanted_hz, wanted_hz / frequency_hz)


def keeps_frequency(setting: PwmSetting, wanted_hz: float) -> bool:
    """Return whether a setting's frequency is within a resonator's tolerance of the wanted one."""
    return _distance(setting.frequency_hz, wanted_hz) <= 1 + FREQUENCY_TOLERANCE


def settings_by_interrupts(
    clock_hz: int, timer: Timer, frequencies_hz: Collection[float]
) -> tuple[PwmSetting, ...]:
    """Make several frequencies with one free-running 16-bit timer, each on a channel of its own.

    The smallest prescaler that keeps every period within MOST_COUNTS_BY_INTERRUPTS serves all.
    Empty if there is none, or if it leaves a period too few counts or an inexact frequency.
    """
    for prescaler in timer.prescalers:
        settings = tuple(
            PwmSetting(prescaler, counts, clock_hz / (prescaler * counts))
            for counts in (round(clock_hz / (prescaler * each)) or 1 for each in frequencies_hz)
        )
        if all(each.counts <= MOST_COUNTS_BY_INTERRUPTS for each in settings):
            fine = all(
                made.counts >= FEWEST_COUNTS and keeps_frequency(made, wanted_hz)
                for made, wanted_hz in zip(settings, frequencies_hz, strict=True)
            )
            return settings if fine else ()
    return ()


class TimerProblem(NamedTuple):
    """A frequency that the timers cannot make: the reason and the remedy."""

    path: Path
    reason: str
    remedy: str
    because_of: tuple[Path, ...]


class PwmChannel(NamedTuple):
    """The compare channel that makes an output's PWM, and how."""

    timer: int
    channel: str
    prescaler: int
    counts: int
    frequency_hz: float
    by_interrupts: bool


class PwmTimers(NamedTuple):
    """The channel that makes each PWM output, and the outputs that no timer can make."""

    channels: Mapping[str, PwmChannel]
    problems: tuple[TimerProblem, ...]

    @property
    def taken(self) -> frozenset[int]:
        """Numbers of the timers in use."""
        return frozenset(channel.timer for channel in self.channels.values())


def share_pwm(controller: Controller) -> PwmTimers:
    """Decide which timer makes each PWM output; outputs without a digital pin are left out."""
    board = controller.board
    outputs = {
        name: output
        for name, output in controller.outputs.items()
        if isinstance(output, PwmOutput)
        and output.pin in board.pins
        and board.pins[output.pin].digital
    }
    channels = dict(_by_timers(board, outputs))
    left = {name: output for name, output in outputs.items() if name not in channels}
    slow = {n: each for n, each in left.items() if each.frequency_hz <= FASTEST_BY_INTERRUPTS_HZ}
    taken = {channel.timer for channel in channels.values()}
    made, unplaced = _by_interrupts(board, slow, taken)
    fast = (name for name in left if name not in slow)
    problems = [_not_by_timer(board, name, left[name], channels, outputs) for name in fast]
    problems += [_no_channel(board, name, outputs[name]) for name in unplaced]
    return PwmTimers({**channels, **made}, tuple(problems))


def _by_timers(board: Board, outputs: Mapping[str, PwmOutput]) -> Iterator[tuple[str, PwmChannel]]:
    """List the PWM outputs that the timers of their own pins generate.

    All outputs of a timer have one frequency: that of the first output which is too fast for
    interrupts or, without one, of the first output.
    """
    able: dict[int, dict[str, tuple[str, PwmSetting, float]]] = {}
    for name, output in outputs.items():
        pin = board.pins[output.pin]
        if pin.pwm is not None:
            setting = pwm_setting(board, output)
            if keeps_frequency(setting, output.frequency_hz):
                timer, channel = pin.pwm
                able.setdefault(timer, {})[name] = (channel, setting, output.frequency_hz)
    for timer, users in able.items():
        wanted = [frequency_hz for _, _, frequency_hz in users.values()]
        fast = [each for each in wanted if each > FASTEST_BY_INTERRUPTS_HZ]
        chosen = (fast or wanted)[0]
        for name, (channel, setting, frequency_hz) in users.items():
            if frequency_hz == chosen:
                yield name, PwmChannel(timer, channel, *setting, by_interrupts=False)


def _by_interrupts(
    board: Board, outputs: Mapping[str, PwmOutput], taken: set[int]
) -> tuple[dict[str, PwmChannel], list[str]]:
    """Put outputs on channels of free 16-bit timers, the last timer first; list the others."""
    free = [
        number
        for number, timer in sorted(board.timers.items(), reverse=True)
        if timer.bits == 16 and number not in taken
    ]
    groups: dict[int, list[str]] = {number: [] for number in free}
    unplaced = []
    for name in outputs:
        for number, group in groups.items():
            if _settings(board, board.timers[number], outputs, [*group, name]):
                group.append(name)
                break
        else:
            unplaced.append(name)
    made = {}
    for number, group in groups.items():
        timer = board.timers[number]
        settings = _settings(board, timer, outputs, group)
        for name, channel, setting in zip(group, timer.channels, settings, strict=False):
            made[name] = PwmChannel(number, channel, *setting, by_interrupts=True)
    return made, unplaced


def _settings(
    board: Board, timer: Timer, outputs: Mapping[str, PwmOutput], names: list[str]
) -> tuple[PwmSetting, ...]:
    if len(names) > len(timer.channels):
        return ()
    wanted = [outputs[name].frequency_hz for name in names]
    return settings_by_interrupts(board.clock_hz, timer, wanted)


def _no_channel(board: Board, name: str, output: PwmOutput) -> TimerProblem:
    pin = board.pins[output.pin]
    return TimerProblem(
        ("outputs", name, "frequency"),
        f"{_why_by_interrupts(board, pin, output)}; it would be made by interrupts, and no channel "
        f"of a 16-bit timer of {board.name} is left for it",
        "Use the kind time_proportional, the frequency of another output on its timer, or a board "
        "with more timers",
        (("controller",), ("outputs",)),
    )


def _why_by_interrupts(board: Board, pin: Pin, output: PwmOutput) -> str:
    wanted = hertz(output.frequency_hz)
    if pin.pwm is None:
        return f"no timer drives {pin.label}"
    if not keeps_frequency(pwm_setting(board, output), output.frequency_hz):
        return f"the timer of {output.pin} cannot make {wanted}"
    return f"the timer of {output.pin} makes another frequency than {wanted}"


def _not_by_timer(
    board: Board,
    name: str,
    output: PwmOutput,
    channels: Mapping[str, PwmChannel],
    outputs: Mapping[str, PwmOutput],
) -> TimerProblem:
    """Explain why an output that is too fast for interrupts cannot be made."""
    pin = board.pins[output.pin]
    below = f"at most {hertz(FASTEST_BY_INTERRUPTS_HZ)}, which interrupts make on any pin"
    wanted = hertz(output.frequency_hz)
    if pin.pwm is None:
        able = [each for each, other in board.pins.items() if other.pwm and each == other.name]
        return TimerProblem(
            ("outputs", name, "pin"),
            f"no timer drives {pin.label} of {board.name}, and interrupts cannot make {wanted}",
            f"Use {listed(able)}, or {below}",
            (("controller", "board"), ("outputs", name, "frequency")),
        )
    number = pin.pwm[0]
    timer = board.timers[number]
    if not keeps_frequency(pwm_setting(board, output), output.frequency_hz):
        return TimerProblem(
            ("outputs", name, "frequency"),
            f"the timer of {output.pin} cannot make {wanted}"
            f"{' in 100 steps' if timer.bits == 16 else ''}",
            _nearest(board, timer, output.frequency_hz)
            + (f", or {below}" if timer.bits == 8 else ""),
            (("controller",), ("outputs", name, "pin")),
        )
    other = next(
        each for each, channel in channels.items()
        if channel.timer == number and not channel.by_interrupts
    )  # fmt: skip
    return TimerProblem(
        ("outputs", name, "frequency"),
        f"{output.pin} shares timer {number} with outputs.{other}, which is at "
        f"{hertz(outputs[other].frequency_hz)}",
        "Give both the same frequency, or use a pin of another timer",
        (("controller",), ("outputs", other), ("outputs", name, "pin")),
    )


def _nearest(board: Board, timer: Timer, wanted_hz: float) -> str:
    if timer.bits == 16:
        slowest = board.clock_hz / (timer.prescalers[-1] << 16)
        fastest = board.clock_hz / FEWEST_COUNTS
        return f"Use {hertz(max(slowest, SLOWEST_PWM_HZ))} to {hertz(fastest)}"
    able = [setting.frequency_hz for setting in pwm_settings(board.clock_hz, timer)]
    below = [each_hz for each_hz in able if each_hz < wanted_hz]
    above = [each_hz for each_hz in able if each_hz > wanted_hz]
    nearest = ([max(below)] if below else []) + ([min(above)] if above else [])
    return f"Use {listed([hertz(each_hz) for each_hz in nearest])}"
