"""Gains by rule, from a reduced model.

Both rules place a closed loop that answers a setpoint with one time constant: they cancel the
model's lags. SIMC (Skogestad 2003) shortens the integral time where the first lag is long, so that
a disturbance does not linger; lambda tuning does not (Dahlin 1968; Rivera, Morari & Skogestad,
Industrial & Engineering Chemistry Process Design and Development 25, 1986, table 1).
"""

from __future__ import annotations

from heatwright.sim.tuning.gains import Gains, Series
from heatwright.sim.tuning.process import Process
from heatwright.sim.tuning.reduced import Reduced, reduce


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
    return Series(gain, min(model.lag_s, 4 * slow_s), model.second_s).parallel(filter_s)


def lambda_rule(model: Reduced, filter_s: float, closed_s: float | None = None) -> Gains:
    """Tune by lambda: the closed loop as fast as the machine itself, or as asked.

    Åström & Hägglund (Advanced PID Control, 2006, section 6.5) call a lambda of one lag the
    aggressive choice, and of three the robust one.
    """
    closed_s = model.lag_s if closed_s is None else closed_s
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
