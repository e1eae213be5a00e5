"""What is found elsewhere in the language, or not built: refused, with these words."""

from __future__ import annotations

ELSEWHERE = {
    ("Analog", "quantity"): "Use kind: current for the current of a heater",
    ("TimeProportionalOutput", "current"): "Measure the current of a digital or pwm output",
    ("Event", "setpoint"): "Write it as a master: write: {LOOP.setpoint: 50 °C}",
    ("Segment", "rate"): "Write at:, as in {to: 540 °C, at: 150 K/h}",
}
"""Keys that somebody may look for in a model, and what does it in their place."""

NOT_BUILT = "is a planned part of the language that is not built yet"
