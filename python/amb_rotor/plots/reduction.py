"""A reduction as PNG and SVG: Hankel singular values, transfer functions before and after, their difference."""
from __future__ import annotations

from amb_rotor.plots.maps import save

BEFORE, AFTER, ERROR = "#1f6fb4", "#c4442d", "#555555"


def reduction(path, title, frequencies, result):
    import matplotlib.pyplot as plt
    figure, (values, own, cross) = plt.subplots(1, 3, figsize=(13.0, 4.4), constrained_layout=True,
                                                width_ratios=(1.0, 1.3, 1.3))
    hankel, order = result["hankel_m_per_N"], result["order"]
    number = range(1, len(hankel) + 1)
    values.semilogy(number[:order], hankel[:order], "o", ms=3.5, color=AFTER, label="kept")
    values.semilogy(number[order:], hankel[order:], "o", ms=3.5, color=BEFORE, label="left out")
    values.set(xlabel="state", ylabel="Hankel singular value [m/N]", title=title)
    values.set_ylim(max(hankel.min(), 1e-13 * hankel.max()), 2.0 * hankel.max())
    values.legend(frameon=False, fontsize=8)
    for axes, sensor, text in ((own, 0, "AMB A to sensor A"), (cross, 1, "AMB A to sensor B")):
        axes.loglog(frequencies, result["before_m_per_N"][:, sensor, 0], color=BEFORE, lw=2.2, alpha=0.6,
                    label=f"before, {result['states']} states")
        axes.loglog(frequencies, result["after_m_per_N"][:, sensor, 0], "--", color=AFTER, lw=1.2,
                    label=f"after, {order} states")
        axes.loglog(frequencies, result["error_m_per_N"], color=ERROR, lw=0.8, label="largest error")
        if result["error_bound_m_per_N"] is not None:
            axes.axhline(result["error_bound_m_per_N"], color=ERROR, lw=0.8, ls=":", label="its bound")
        axes.set(xlabel="frequency [Hz]", ylabel="displacement over force [m/N]", title=text)
    own.legend(frameon=False, fontsize=8)
    return save(figure, path, ".svg")
