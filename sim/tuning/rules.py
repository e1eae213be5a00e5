"""Gains by rule, from a reduced model.

Both rules place a closed loop that answers a setpoint with one time constant, and cancel the
model's lags. SIMC (Skogestad 2003) shortens integral and derivative times where the lags are long,
so that a disturbance does not linger; lambda tuning does not (Dahlin 1968; Rivera, Morari &
Skogestad, Industrial & Engineering Chemistry Process Design and Development 25, 1986, table 1).
"""

from __future__ import annotations

from heatwright.sim.tuning.gains import Gains, Series
from heatwright.sim.tuning.process import Process
from heatwright.sim.tuning.reduced import Reduced, reduce

SLOWER = 3.0


def simc(model: Reduced, filter_s: float, closed_s: float | None = None) -> Gains:
    """Tune by SIMC.

    Args:
        model: the process.
        filter_s: time constant of the derivative's filter, s.
        closed_s: closed loop's time constant; the dead time if None: "tight" control.

    """
    closed_s = model.dead_s if closed_s is None else closed_s
    slow_s = closed_s + model.dead_s
    gain = model.lag_s / (model.gain * slow_s)
    integral_s, derivative_s = min(model.lag_s, 4 * slow_s), min(model.second_s, 4 * slow_s)
    if derivative_s < model.second_s:  # towards a double integrator (Skogestad, table 1)
        gain *= model.second_s / derivative_s
    return Series(gain, integral_s, derivative_s).parallel(filter_s)


def lambda_rule(model: Reduced, filter_s: float, closed_s: float | None = None) -> Gains:
    """Tune by lambda: as fast as asked.

    Without a wish the closed loop's time constant is three dead times. With both lags cancelled the
    open loop is exp(−θs)/((λ + θ)s), whose gain margin then is 2π = 6.3, its phase margin
    90° − 57.3°/4 = 76° (Skogestad 2003, section 5.1).
    """
    closed_s = SLOWER * model.dead_s if closed_s is None else closed_s
    gain = model.lag_s / (model.gain * (closed_s + model.dead_s))
    return Series(gain, model.lag_s, model.second_s).parallel(filter_s)


def model_for(process: Process, period_s: float, filter_s: float) -> Reduced:
    """Reduce a process to what a rule needs.

    To second order, with the derivative's filter as one more lag; to first order where that leaves
    the derivative nothing to do.
    """
    second = _reduced(process, period_s, [*process.lags_s, filter_s], 2)
    if second.second_s > filter_s:
        return second
    return _reduced(process, period_s, process.lags_s, 1)


def _reduced(process: Process, period_s: float, lags_s: list[float], order: int) -> Reduced:
    return reduce(
        gain=process.gain,
        lags_s=lags_s,
        leads_s=process.leads_s,
        late_s=process.late_s,
        period_s=period_s,
        order=order,
    )
