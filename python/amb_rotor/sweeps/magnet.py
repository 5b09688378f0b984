"""Force of one magnet over current and gap (kind `magnet_force` of amb-figure/1), thesis 3.16 and figure 3.9.

F = N^2 mu0 A i^2/(4 g^2) cos f,  B = mu0 N i/(2 g): symbols, source and limits in model/magnet_dimensions.hpp, whose numbers these are. The
iron is taken as infinitely permeable: where B is above what iron carries, the force is not reached. `iron_T` says where.
"""
from __future__ import annotations

import pathlib

import numpy

from amb_rotor.sweeps.document import Document

KEYS = ("format", "name", "title", "source", "kind", "magnet", "iron_T", "current_A", "air_gap_m")
MAGNET = ("windings", "pole_area_m2", "force_angle_rad")
LINES = 5  # currents that get a line of their own


def read(path: pathlib.Path) -> dict:
    """@raise InputError: all faults of the file"""
    document = Document(path, "amb-figure/1")
    document.keys("", KEYS)
    found = dict(document.data, magnet=document.numbers("magnet", MAGNET),
                 iron_T=document.number("iron_T", "above 0", lambda value: value > 0.0))
    for key in ("current_A", "air_gap_m"):
        found[key] = document.axis(key)
        if not (found[key] > 0.0).all():
            document.fault(key, "must be above 0")
    document.done()
    return found


def run_figure(args, path: pathlib.Path) -> int:
    from amb_rotor import _core
    from amb_rotor.cli import common
    figure = read(path)
    folder = common.out_folder(args, "sweep", figure["name"])
    current, gap = numpy.meshgrid(figure["current_A"], figure["air_gap_m"], indexing="ij")
    force = _core.magnet_pull(**figure["magnet"], current_A=current, air_gap_m=gap)
    density = _core.magnet_flux_density(figure["magnet"]["windings"], current, gap)
    carried = density <= figure["iron_T"]
    numbers = {"smallest_N": float(force.min()), "largest_N": float(force.max()), "largest_T": float(density.max()),
               "share_within_iron": float(carried.mean()), "largest_within_iron_N": float(force[carried].max(initial=0.0))}
    print(f"force {numbers['smallest_N']:.1f} to {numbers['largest_N']:.1f} N, flux density up to "
          f"{numbers['largest_T']:.3f} T; within {figure['iron_T']:g} T on {100 * numbers['share_within_iron']:.1f} % of "
          f"the picture, to {numbers['largest_within_iron_N']:.1f} N")
    common.write_json(args, {"name": figure["name"], "kind": figure["kind"], **numbers})
    rows = zip(current.ravel(), gap.ravel(), force.ravel(), density.ravel())
    lines = ["current_A,air_gap_m,force_N,flux_density_T"] + [",".join(f"{value:.9g}" for value in row) for row in rows]
    common.atomic_write(folder / "data.csv", "\n".join(lines) + "\n")
    common.report_line(_draw(figure, force, density, folder))
    return 0


def _draw(figure: dict, force, density, folder):
    """Left the map of the force, right its lines over the gap; dashed: more flux than the iron carries."""
    from amb_rotor.sweeps.draw import _pyplot, save
    pyplot = _pyplot()
    picture, (left, right) = pyplot.subplots(1, 2, figsize=(9.5, 4.0), constrained_layout=True)
    millimetres = 1e3 * figure["air_gap_m"]
    shown = left.pcolormesh(millimetres, figure["current_A"], force, shading="gouraud", cmap="viridis")
    picture.colorbar(shown, ax=left, label="force [N]")
    left.contour(millimetres, figure["current_A"], density, levels=[figure["iron_T"]], colors="white", linestyles="--")
    left.set(xlabel="air gap [mm]", ylabel="current [A]", title=f"white: {figure['iron_T']:g} T in the gap")
    for index in numpy.linspace(0, len(figure["current_A"]) - 1, LINES).round().astype(int):
        within = density[index] <= figure["iron_T"]
        line, = right.plot(millimetres, numpy.where(within, force[index], numpy.nan), lw=1.4,
                           label=f"{figure['current_A'][index]:.2f} A")
        right.plot(millimetres, force[index], "--", lw=0.8, color=line.get_color())
    right.set(xlabel="air gap [mm]", ylabel="force [N]", title="dashed: not carried by the iron")
    right.legend(fontsize=8)
    right.grid(alpha=0.3)
    picture.suptitle(figure["title"])
    return save(picture, folder, "magnet_force")[0]
