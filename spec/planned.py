"""Parts of the language that have their place but are not built: refused, with these words."""

from __future__ import annotations

KINDS = {
    "Sensor": "max31856",
    "Interface": "nextion",
}
"""Kinds by the union they will join."""

KEYS = {
    "Controller": "programs",
    "Ds18b20": "moving_average",
    "Thermistor": "moving_average",
    "Rtd": "moving_average",
    "Analog": "moving_average",
    "TimeProportionalOutput": "current supply",
    "Safety": "relay",
    "ThermalNetwork": "radiation",
    "Event": "loop setpoint",
}
"""Keys by the model they will join."""

INSTEAD = {("Sense", "of"): "node"}
"""Keys by model and by the planned key that takes their place: not missing beside it."""

NOT_BUILT = "is a planned part of the language that is not built yet"


def kind(union: str, word: str) -> bool:
    """Tell whether `word` will be a kind of `union`."""
    return word in KINDS.get(union, "").split()


def key(model: str, word: str) -> bool:
    """Tell whether `word` will be a key of `model`."""
    return word in KEYS.get(model, "").split()
