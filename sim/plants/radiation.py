"""Radiation between surfaces: σ·ε·A·(Ta⁴ − Tb⁴), T in kelvin.

The difference of fourth powers is a product, (Ta² + Tb²)·(Ta + Tb)·(Ta − Tb): a conductance that
depends on the temperatures. It changes slowly compared with a step of time, but computing a matrix
exponential for each of its values would dominate the run time. So the conductance is rounded to a
grid, and the rest, at most a hundredth of it, is a heat that is constant over the step. In the
steady state the sum of both is exact.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from heatwright.spec import Radiation

STEFAN_BOLTZMANN = 5.670374419e-8
"""W/(m²·K⁴), CODATA 2018."""
ZERO_C_K = 273.15
LOG_GRID = math.log(1.02)


class Surface(NamedTuple):
    """Two states of the plant that radiate to each other."""

    here: int
    there: int
    factor: float
    """σ·ε·A, W/K⁴."""

    @classmethod
    def of(cls, radiation: Radiation, places: Sequence[int]) -> "Surface":
        """Create a surface from its spec."""
        here, there = places
        return cls(here, there, STEFAN_BOLTZMANN * radiation.emissivity * radiation.area_m2)

    def now(self, temperatures_c: Sequence[float]) -> tuple[float, float]:
        """Return the conductance on the grid, W/K, and the remaining heat towards `here`, W."""
        here_c, there_c = temperatures_c[self.here], temperatures_c[self.there]
        here_k, there_k = here_c + ZERO_C_K, there_c + ZERO_C_K
        exact = self.factor * (here_k * here_k + there_k * there_k) * (here_k + there_k)
        if exact <= 0:
            return 0.0, 0.0
        grid = on_grid(exact)
        return grid, (exact - grid) * (there_c - here_c)

    def slope(self, temperature_c: float) -> float:
        """Return the derivative of one end's radiation by its temperature, W/K."""
        return 4 * self.factor * (temperature_c + ZERO_C_K) ** 3


def on_grid(conductance: float) -> float:
    """Return the grid's value that is nearest to a conductance above 0, W/K."""
    return math.exp(round(math.log(conductance) / LOG_GRID) * LOG_GRID)
