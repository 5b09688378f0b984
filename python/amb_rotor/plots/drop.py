"""A drop as the thesis draws it (figures 4.16 to 4.18): orbit, spectrum and time history of the rotor's end b."""
from __future__ import annotations

import numpy

from amb_rotor.plots.maps import save
from amb_rotor.plots.motion import FREE, clearance_circle, coloured_orbit


def drop(path, columns: dict, clearance: float, from_s: float, title: str):
    import matplotlib.pyplot as plt
    time, x, y = columns["t_s"], columns["aux_bx_m"] / clearance, columns["aux_by_m"] / clearance
    touching = columns["normal_b_N"] > 0.0
    part = time >= from_s
    figure = plt.figure(figsize=(11.0, 4.6), constrained_layout=True)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.5))
    orbit, spectrum, history = (figure.add_subplot(place) for place in (grid[:, 0], grid[0, 1], grid[1, 1]))
    clearance_circle(orbit, label="clearance")
    coloured_orbit(orbit, x, y, touching)
    orbit.set(xlabel="x / clearance [-]", ylabel="y / clearance [-]", title=title)
    orbit.legend(fontsize=8, loc="upper right", frameon=False)
    signal = columns["aux_bx_m"][part]
    window = numpy.hanning(len(signal))
    amplitude = numpy.abs(numpy.fft.rfft((signal - signal.mean()) * window)) * 2.0 / window.sum()
    rate = (part.sum() - 1) / (time[part][-1] - time[part][0])
    frequency = numpy.fft.rfftfreq(len(signal), 1.0 / rate)
    shown = frequency <= 500.0
    spectrum.semilogy(frequency[shown], 1e6 * numpy.maximum(amplitude[shown], 1e-9), color=FREE, lw=1.0)
    spectrum.axvline(float(columns["speed_Hz"][part].mean()), color="#999999", lw=0.8, ls="--", label="the speed")
    spectrum.set(xlabel="frequency [Hz]", ylabel="x, amplitude [µm]", title=f"spectrum from {from_s:g} s on")
    spectrum.set_ylim(bottom=0.1)
    spectrum.legend(fontsize=8, frameon=False)
    last = time >= max(from_s, time[-1] - 0.15)
    history.plot(time[last], x[last], color=FREE, lw=1.0)
    history.set(xlabel="time [s]", ylabel="x / clearance [-]", title="time history, horizontal")
    return save(figure, path)
