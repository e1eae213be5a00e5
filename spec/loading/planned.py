"""Messages for keys that belong elsewhere in the language, or that are not built yet."""

ELSEWHERE = {
    ("Analog", "quantity"): "Use kind: current for the current of a heater",
    (
        "TimeProportionalOutput",
        "current",
    ): "Only the kinds digital and pwm have it: change kind, or delete current",
    ("Event", "setpoint"): "Use write: {LOOP.setpoint: 50 °C}, which needs an interface modbus_rtu",
    ("Segment", "rate"): "Write at:, as in {to: 540 °C, at: 150 K/h}",
}
"""Keys that a user may try in a model, with the keys to write instead."""

NOT_BUILT = "is a planned part of the language that is not built yet"
