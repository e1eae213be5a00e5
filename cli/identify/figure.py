"""Figure of a record and its fit: readings, their difference, power."""

from matplotlib.figure import Figure

from heatwright.sim.identify import Identified
from heatwright.sim.plots.plot import PANEL_IN, WIDTH_IN, dress
from heatwright.sim.plots.plot_data import FAULT, HEAT, READING, SETPOINT, time_axis
from heatwright.spec.quantity import about

HEIGHTS = (1.6, 0.8, 0.6)
FIT = "#e69f00"


def identified_figure(found: Identified, name: str) -> Figure:
    """Draw the readings and the fit, their difference, and the power."""
    record, wrong = found.record, found.left_out
    time = time_axis(record.duration_s)
    times = time(record.times_s)
    figure = Figure(figsize=(WIDTH_IN, PANEL_IN * sum(HEIGHTS)), layout="constrained")
    above, middle, below = figure.subplots(
        3, 1, sharex=True, gridspec_kw={"height_ratios": HEIGHTS}
    )
    above.plot(times, record.readings_c, ".", ms=3, color=READING, label="record")
    above.plot(times, found.model_c, color=FIT, lw=1.6, label="fit")
    if wrong.any():
        above.plot(
            times[wrong], record.readings_c[wrong], "x", color=FAULT, ls="", label="left out"
        )
        kept = record.readings_c[~wrong]
        above.set_ylim(*_with_room(float(kept.min()), float(kept.max())))
    above.set_ylabel("temperature [°C]")
    above.legend(loc="lower right", frameon=False)
    title = f"{name}: fit error {about(found.rms_k)} K rms, {about(found.worst_k)} K at most"
    above.set_title(title, loc="left", fontweight="bold", parse_math=False)
    middle.plot(times[~wrong], found.residuals_k, ".", ms=2, color=READING)
    middle.axhline(0.0, color=SETPOINT, lw=0.8)
    middle.set_ylabel("record − fit [K]")
    below.fill_between(times, record.powers_w, step="post", color=HEAT, alpha=0.8, lw=0)
    below.set_ylabel("power [W]")
    below.set_ylim(0, 1.05 * float(record.powers_w.max()))
    below.set_xlabel(f"time [{time.unit}]")
    below.set_xlim(0, float(times[-1]))
    for panel in (above, middle, below):
        dress(panel)
    return figure


def _with_room(low: float, high: float) -> tuple[float, float]:
    room = 0.05 * (high - low)
    return low - room, high + room
