"""What must hold of an interrupted firing; known are the EEPROM's bytes and the temperature."""

from collections import Counter, deque
from collections.abc import Iterator

from interrupted_firing import Instant
from storage_firing import IDLE, INTERRUPTED, PAUSED, RETURNING, RUNNING
from storage_format import FAST, HOLD, OVER, RATE, Memory, Progress, Segment

from heatwright.spec import Controller

FINISHED, STOPPED, TOO_FAR = 1, 2, 4
TARGETED = (OVER, RATE, FAST)
ABOVE_K = 10.0
COAST_S = 60
"""In which the element gives off what it held when it went off: four of its time constants."""
OFF_S = 120
RISE_K = 0.5
LATE_S = 2  # in which a record is written: one of 0.45 s may be under way, and a fault's goes first
AGE_S = 16  # the mean's temperature, before a fault that took up to eight periods to be told
STEP_K = 0.01
NEAR_K = 0.02  # what single precision and the sensor's steps may make of a temperature
PLACE = (
    "number", "segment", "program_crc", "first_c", "from_c", "setpoint_c", "elapsed", "clock",
    "segment_clock",
)  # fmt: skip


class Oracle:
    def __init__(self, controller: Controller) -> None:
        programs = controller.programs
        assert programs is not None
        self._memory = Memory(controller)
        self._after = programs.after_power_loss
        self.tally: Counter[str] = Counter()
        self._image = b""
        self.begin()

    def begin(self) -> None:
        self._record: Progress | None = None
        self._sequence = self._age_s = self._off_s = 0
        self._lowest_c = 0.0
        self._latched_s, self._was_cut = 0, False
        self._felt: deque[float] = deque(maxlen=AGE_S)
        self._tops: deque[float] = deque(maxlen=COAST_S)

    def problems(self, now: Instant) -> Iterator[str]:
        before_c = self._felt[-1] if self._felt else now.felt_c
        self._felt.append(now.felt_c)
        self._age_s += now.powered
        if now.image != self._image:
            self._image = now.image
            yield from self._looked_at(now.image)
        self._was_cut |= not now.powered
        if now.powered:
            yield from self._latched(now.image)
        yield from self._heat(now.felt_c, before_c)

    def _looked_at(self, image: bytes) -> Iterator[str]:
        found = self._memory.progress(image)
        if found is None or found[0] == self._sequence:
            return
        last, (self._sequence, record) = self._record, found
        if last is not None:
            yield from self._followed(last, record)
        self._record, self._age_s, self._was_cut = record, 0, False

    def _followed(self, last: Progress, now: Progress) -> Iterator[str]:
        if last.state != IDLE and now.state == IDLE:
            self.tally[f"ended {now.ended}"] += last.state == INTERRUPTED
            self.tally["stopped"] += now.ended == STOPPED
            if now.ended not in {FINISHED, STOPPED, TOO_FAR}:
                yield f"{last} ended as {now}"
        if now.state == INTERRUPTED and last.state in {RUNNING, RETURNING}:
            self.tally["interrupted"] += 1
            yield from self._caught(last, now)
        if last.state == INTERRUPTED:
            yield from self._left(last, now)

    def _caught(self, last: Progress, now: Progress) -> Iterator[str]:
        """Interrupted where it was: its clock has run since the record before, and no farther."""
        if not 0 <= now.clock - last.clock <= self._age_s + LATE_S:
            yield f"{self._age_s} s after {last} it is {now}"
        least = last.clock + self._age_s - LATE_S
        if last.state == RUNNING and now.clock < least and not self._was_cut:
            yield f"{self._age_s} s after {last} it is {now}"
        if now.segment != last.segment and now.segment_clock > LATE_S:
            yield f"behind {last} it is {now}"
        wanted_c = self._setpoint_c(now, now.elapsed)
        if abs(now.setpoint_c - wanted_c) > NEAR_K and last.state == RUNNING:
            yield f"the setpoint of {now} is not {wanted_c}"
        felt = [last.temperature_c] if self._was_cut else self._felt
        if not min(felt) - NEAR_K <= now.temperature_c <= max(felt) + NEAR_K:
            yield f"{now.temperature_c} °C was felt neither before the fault nor at it"

    def _left(self, last: Progress, now: Progress) -> Iterator[str]:
        """It went on from its place, or has ended, by the temperature."""
        gone = [abs(felt_c - last.temperature_c) for felt_c in list(self._felt)[-6:]]
        within_k = self._after.resume_within_k
        far, near = max(gone) >= within_k - NEAR_K, min(gone) <= within_k + NEAR_K
        if now.state in {RETURNING, PAUSED, INTERRUPTED} and any(
            getattr(last, name) != getattr(now, name) for name in PLACE
        ):
            yield f"it was {last} and goes on as {now}"
        may = {
            RETURNING: near,
            PAUSED: far and self._after.otherwise == "pause",
            IDLE: now.ended == STOPPED or (far and self._after.otherwise == "stop"),
        }
        self.tally[f"to {now.state}"] += 1
        if not may.get(now.state, False):
            yield f"{last} became {now}, {gone} K away"

    def _latched(self, image: bytes) -> Iterator[str]:
        """Once a fault is kept, no record says for long that something goes on."""
        kept = self._memory.settings(image)
        self._latched_s = self._latched_s + 1 if kept and kept.code else 0
        works = self._record is not None and self._record.state in {RUNNING, RETURNING}
        if works and self._latched_s > LATE_S + 1:
            yield f"a fault is latched, and {self._record} goes on"

    def _setpoint_c(self, record: Progress, elapsed: float) -> float:
        """Where the setpoint of a record's segment is, after so many periods of it."""
        segment = self._segment(record)
        to_c = segment.to_dc / 10 if segment.kind in TARGETED else record.from_c
        if segment.kind == RATE:
            length = max(1, round(abs(to_c - record.from_c) * 36000 / segment.amount))
        elif segment.kind in {OVER, HOLD}:
            length = segment.amount
        else:
            return to_c
        return record.from_c + (to_c - record.from_c) * min(1.0, elapsed / length)

    def _segment(self, record: Progress) -> Segment:
        program = self._memory.program(self._image, record.number)
        assert program is not None
        return program.segments[record.segment - 1]

    def _heat(self, felt_c: float, before_c: float) -> Iterator[str]:
        record = self._record
        works = record is not None and record.state in {RUNNING, RETURNING}
        if record is not None and (works or record.state != IDLE):
            ahead = record.elapsed + self._age_s + LATE_S
            ahead_c = self._setpoint_c(record, ahead) if record.state == RUNNING else -300.0
            self._tops.append(max(record.setpoint_c, ahead_c))
        elif self._tops:
            self._tops.append(self._tops[-1])
        top_c = max(self._tops, default=felt_c) + ABOVE_K
        if felt_c > top_c and felt_c > before_c + STEP_K:
            yield f"{felt_c:.2f} °C, rising, above {top_c:.2f} °C of {record}"
        self._off_s = 0 if works else self._off_s + 1
        self._lowest_c = felt_c if self._off_s <= OFF_S else min(self._lowest_c, felt_c)
        if felt_c > self._lowest_c + RISE_K:
            yield f"{felt_c:.2f} °C after {self._lowest_c:.2f} °C though {record}"
