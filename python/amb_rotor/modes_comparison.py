"""A model against measured natural frequencies (data sets of kind modes): as believed, and with the uncertain values
fitted on the runs to fit. Errors are root mean squares over the measurements' standard deviations."""
from __future__ import annotations

import numpy

from amb_rotor import models
from amb_rotor.cli import common
from amb_rotor.errors import InputError

# Relative step of the derivatives, and the share of a number that a fit may leave or add.
LIMITS = (0.2, 5.0)


def predicted(model, dataset, index: int) -> list[float]:
    from amb_rotor import modal
    point = dataset.points[index]
    there = dataset.model_at(model, index)
    found = modal.distinct([mode.frequency_hz for mode in modal.modes(there, point["speed_hz"])], dataset.mode_count)
    return found + [float("nan")] * (dataset.mode_count - len(found))


def predictions(model, dataset) -> numpy.ndarray:
    return numpy.array([predicted(model, dataset, index) for index in range(len(dataset.points))])


def fit(model, dataset):
    """The model with its uncertain values fitted on the runs to fit, and their values with standard deviations."""
    import scipy.optimize
    fields = model.fields
    names = [f"rig.{name}" for name, std in model.uncertainty.items() if f"rig.{name}" in fields and std > 0
             and fields[f"rig.{name}"] != 0.0 and name not in dataset.conditions]
    believed = numpy.array([fields[name] for name in names])
    std = numpy.array([model.uncertainty[name.removeprefix("rig.")] for name in names])
    chosen = [index for index, point in enumerate(dataset.points) if point["use"] == "fit"]
    if not names or not chosen:
        return model, {}
    measured = numpy.array([dataset.points[index]["frequency_hz"] for index in chosen])
    noise = numpy.array([dataset.points[index]["std_hz"] for index in chosen])

    def with_values(factors):
        return model.with_overrides([f"{name}={value!r}" for name, value in zip(names, (factors * believed).tolist())])

    def residual(factors):
        trial = with_values(factors)
        there = numpy.array([predicted(trial, dataset, index) for index in chosen])
        return numpy.concatenate([((there - measured) / noise).ravel(), (factors - 1.0) / std])

    result = scipy.optimize.least_squares(residual, numpy.ones(len(names)), bounds=LIMITS, x_scale=std, diff_step=1e-4)
    covariance = numpy.linalg.pinv(result.jac.T @ result.jac)
    values = {name.removeprefix("rig."): {"value": float(factor * value), "std": float(abs(value) * deviation)}
              for name, factor, value, deviation in zip(names, result.x, believed, numpy.sqrt(numpy.diag(covariance)))}
    return with_values(result.x), values


def rms(values) -> float | None:
    values = numpy.asarray(values)
    return float(numpy.sqrt(numpy.mean(values ** 2))) if values.size else None


def errors(table: numpy.ndarray, dataset) -> dict:
    """The fields of `amb compare --json`; a mode is a channel here."""
    measured = numpy.array([point["frequency_hz"] for point in dataset.points])
    noise = numpy.array([point["std_hz"] for point in dataset.points])
    scaled = (table - measured) / noise
    runs = list(dict.fromkeys(point["run"] for point in dataset.points))
    rows = {run: [index for index, point in enumerate(dataset.points) if point["run"] == run] for run in runs}
    held_out = [index for index, point in enumerate(dataset.points) if point["use"] == "validate"]
    by_mode = {f"mode_{k + 1}": rms(scaled[:, k]) for k in range(dataset.mode_count)}
    error = rms(list(rms(scaled[index]) for index in rows.values()))
    return {"error": error, "error_free": error, "error_contact": None, "noise_floor": 1.0,
            "by_run": {run: rms(scaled[index]) for run, index in rows.items()}, "by_channel": by_mode,
            "by_regime": {"standstill": error} if not any(point["speed_hz"] for point in dataset.points) else {},
            "by_harmonic": {}, "by_speed": [{"speed_hz": float(speed), "error": rms(
                [scaled[i] for i, point in enumerate(dataset.points) if point["speed_hz"] == speed])}
                for speed in sorted({point["speed_hz"] for point in dataset.points})],
            "validation_error": rms(scaled[held_out]), "difference_hz": (table - measured).tolist()}


def sentences(before: dict, after: dict, dataset) -> list[str]:
    """Where the model fails, as believed and after the fit."""
    difference = numpy.array(before["difference_hz"])
    worst = int(numpy.argmax([rms(difference[:, k]) for k in range(dataset.mode_count)]))
    row = int(numpy.argmax(numpy.abs(difference[:, worst])))
    size = numpy.abs(difference[:, worst])
    condition = ", ".join(f"{name} = {value:g}" for name, value in
                          zip(dataset.conditions, dataset.points[row]["condition"]))
    said = [f"As believed the model fails most in mode {worst + 1}: by {size.min():.1f} to {size.max():.1f} Hz, most at "
            f"{condition or 'measurement ' + str(row + 1)} ({difference[row, worst]:+.1f} Hz)."]
    others = [k for k in range(dataset.mode_count) if k != worst]
    for k in others:
        said.append(f"Mode {k + 1}: by {numpy.abs(difference[:, k]).min():.1f} to {numpy.abs(difference[:, k]).max():.1f} Hz.")
    left = numpy.array(after["difference_hz"])
    said.append(f"With the uncertain values fitted, the error on held-out measurements goes from "
                f"{_text(before['validation_error'])} to {_text(after['validation_error'])} times its standard deviation; "
                f"what stays: mode {worst + 1} by up to {numpy.max(numpy.abs(left[:, worst])):.1f} Hz.")
    return said


def _text(value) -> str:
    return "-" if value is None else f"{value:.2f}"


def _picture(path, dataset, before, after):
    import matplotlib.pyplot as plt
    from amb_rotor.plots.maps import save
    column = [point["condition"][0] if point["condition"] else index for index, point in enumerate(dataset.points)]
    order = numpy.argsort(column)
    column = numpy.array(column)[order]
    figure, panes = plt.subplots(1, dataset.mode_count, figsize=(4.6 * dataset.mode_count, 4.0), constrained_layout=True,
                                 squeeze=False)
    for k, axes in enumerate(panes[0]):
        for use, marker, label in (("fit", "o", "measured, used to fit"), ("validate", "s", "measured, held out")):
            points = [(i, p) for i, p in zip(column, [dataset.points[j] for j in order]) if p["use"] == use]
            axes.errorbar([x for x, _ in points], [p["frequency_hz"][k] for _, p in points],
                          yerr=[p["std_hz"][k] for _, p in points], fmt=marker, ms=5, color="#333333", capsize=2,
                          mfc="#333333" if use == "fit" else "white", label=label)
        axes.plot(column, before[order, k], color="#c9541b", label="model as believed")
        axes.plot(column, after[order, k], color="#1f6fb4", label="uncertain values fitted")
        axes.set_title(f"mode {k + 1}")
        axes.set_xlabel(dataset.conditions[0] if dataset.conditions else "measurement")
        axes.set_ylabel("natural frequency [Hz]")
    panes[0][0].legend(frameon=False, fontsize=8)
    return save(figure, path)


def run_modes(args, model_path, folder) -> int:
    import json
    from amb_rotor import _core
    from amb_rotor.report import write_report
    dataset = _core.read_modes_dataset(str(folder))
    model = models.loaded(model_path, args.overrides, dataset.belief)
    if model.amb_model != dataset.belief.amb_model and dataset.conditions:
        raise InputError(f"{model_path}: rig.amb.model must be {dataset.belief.amb_model}, as the data set sets "
                         + ", ".join(dataset.conditions))
    out = common.out_path(args, "compare", models.stem(folder))
    before = predictions(model, dataset)
    fitted, values = (model, {}) if args.no_refit else fit(model, dataset)
    after = predictions(fitted, dataset)
    first, last = errors(before, dataset), errors(after, dataset)
    said = sentences(first, last, dataset)
    print(f"model {model.name} ({model.hash}) against {dataset.name}, {len(dataset.points)} measurements of "
          f"{dataset.mode_count} modes")
    for sentence in said:
        print(sentence)
    for remark in model.remarks:
        print(f"remark: {remark}")
    for name, value in values.items():
        print(f"  {name} = {value['value']:.5g} +- {value['std']:.2g}")
    result = {**last, "worst": said[0], "as_believed": first, "nuisance": values, "dataset": dataset.name,
              "model": model.name, "model_hash": fitted.hash, "sentences": said, "remarks": model.remarks}
    common.write_json(args, result)
    out.mkdir(parents=True, exist_ok=True)
    common.atomic_write(out / "comparison.json", json.dumps(common._plain(result), indent=2) + "\n")
    rows = [[p["run"] + ": " + ", ".join(f"{v:g}" for v in p["condition"])]
            + [f"{p['frequency_hz'][k]:.1f} / {before[i, k]:.1f} / {after[i, k]:.1f}" for k in range(dataset.mode_count)]
            for i, p in enumerate(dataset.points)]
    picture = _picture(out / "modes.png", dataset, before, after)
    report = write_report(
        out / "report.html", f"{model.name} against {dataset.name}", f"model {model.hash}; natural frequencies", [],
        pictures=[(picture, "Measured and predicted natural frequencies")], notes=said,
        tables=[{"title": "Measured / as believed / fitted [Hz]",
                 "columns": ["measurement"] + [f"mode {k + 1}" for k in range(dataset.mode_count)], "rows": rows},
                {"title": "Fitted values", "columns": ["value", "believed", "fitted", "std"],
                 "rows": [[name, f"{model.fields['rig.' + name]:.5g}", f"{value['value']:.5g}", f"{value['std']:.2g}"]
                          for name, value in values.items()]}])
    common.report_line(report)
    error = last["validation_error"] or last["error"]
    return 1 if args.limit is not None and error > args.limit else 0
