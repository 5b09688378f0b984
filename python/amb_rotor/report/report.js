"use strict";
(function () {
  const D = JSON.parse(document.getElementById("data").textContent);
  const first = D.stages[0], last = D.stages[D.stages.length - 1], diagnosis = D.diagnosis;
  const head = document.getElementById("head"), rest = document.getElementById("rest");
  const CHANNELS = ["ax", "ay", "bx", "by", "iax", "iay", "ibx", "iby"];
  const drawn = [];

  const has = v => v !== null && v !== undefined;
  const num = (v, d) => {
    if (!has(v)) return "–";
    const size = Math.abs(v), digits = d || 3;
    if (size !== 0 && (size < 1e-3 || size >= 1e6)) return Number(v).toExponential(digits - 1);
    return String(Number(Number(v).toPrecision(digits)));
  };
  const err = v => has(v) ? (v >= 100 ? Number(v).toFixed(0) : Number(v).toFixed(2)) : "–";
  const words = s => s.replace(/_/g, " ");
  const colour = name => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

  function add(parent, tag, content, className) {
    const element = document.createElement(tag);
    if (className) element.className = className;
    if (has(content)) element.textContent = content;
    parent.appendChild(element);
    return element;
  }
  function section(title, explanation) {
    const s = add(rest, "section");
    add(s, "h2", title);
    if (explanation) add(s, "p", explanation, "soft");
    return s;
  }
  function card(parent, title, explanation) {
    const c = add(parent, "div", null, "card");
    add(c, "h3", title);
    if (explanation) add(c, "p", explanation, "soft");
    return c;
  }

  // ---- pictures: each is a function that gives traces and layout, so that it can be drawn again in another theme
  function base() {
    const axis = () => ({gridcolor: colour("line"), zerolinecolor: colour("line"), linecolor: colour("line"),
                         tickcolor: colour("line"), automargin: true});
    return {paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: {color: colour("ink"), size: 12},
            margin: {l: 56, r: 14, t: 14, b: 44}, xaxis: axis(), yaxis: axis(), showlegend: false,
            legend: {orientation: "h", y: 1.02, yanchor: "bottom", x: 0}, hovermode: "closest"};
  }
  function merge(target, source) {
    for (const [key, value] of Object.entries(source)) {
      if (value && typeof value === "object" && !Array.isArray(value) && target[key]) merge(target[key], value);
      else target[key] = value;
    }
    return target;
  }
  function plot(parent, height, make) {
    const place = add(parent, "div");
    place.style.height = height + "px";
    const draw = () => {
      const made = make();
      Plotly.react(place, made.traces, merge(base(), made.layout || {}), {responsive: true, displaylogo: false,
        displayModeBar: false});
    };
    drawn.push(draw);  // drawn when the page is complete: only then are the widths known
    return () => { if (document.body.dataset.ready) draw(); };
  }
  const floorLine = (axis) => ({type: "line", [axis === "x" ? "yref" : "xref"]: "paper",
    [axis === "x" ? "y0" : "x0"]: 0, [axis === "x" ? "y1" : "x1"]: 1, [axis + "0"]: 1, [axis + "1"]: 1,
    line: {color: colour("soft"), width: 1, dash: "dash"}});

  function bars(parent, title, explanation, labels, pick, xtitle) {
    const c = card(parent, title, explanation);
    plot(c, 250, () => ({
      traces: D.stages.map((s, i) => ({type: "bar", name: words(s.label), x: labels.map(words), y: labels.map(l => pick(s, l)),
        marker: {color: i === 0 ? colour(D.stages.length > 1 ? "orange" : "blue") : colour("blue")},
        hovertemplate: "%{x}: %{y:.2f}<extra>" + s.label + "</extra>"})),
      layout: {barmode: "group", bargap: 0.25, showlegend: D.stages.length > 1, xaxis: {title: {text: xtitle}, type: "category"},
               yaxis: {title: {text: "error / noise [-]"}, rangemode: "tozero"}, shapes: [floorLine("y")]}}));
  }

  // ---- first page
  function firstPage() {
    add(head, "h1", D.title);
    add(head, "p", D.subtitle, "soft");
    const steps = diagnosis ? diagnosis.steps.map(s => words(s.added)) : [];
    let verdict = "Model against measurement", kind = "compare";
    if (diagnosis) {
      kind = diagnosis.verdict;
      verdict = kind === "effect" ? "Missing effect: " + steps.join(", then ")
        : kind === "none" ? "No effect is missing" : "Something is missing that the catalogue has no name for";
    }
    add(head, "div", verdict, "verdict " + kind);
    const said = add(head, "ul", null, "said");
    const sentences = diagnosis && diagnosis.sentences.length ? diagnosis.sentences.slice() : [];
    // where it fails comes first: the sentences of the model as it stood before
    if (first && first.errors.worst) sentences.unshift(...first.errors.worst.split(/(?<=\.) (?=[A-Z])/));
    if (diagnosis && diagnosis.verdict === "effect" && diagnosis.steps.length) {
      const end = diagnosis.steps[diagnosis.steps.length - 1];
      sentences.push("On runs that were not used to choose or to fit, the error falls from " +
        err(diagnosis.baseline.validation_error) + " to " + err(end.validation_error) + " times the noise.");
      const named = diagnosis.ranking.find(r => r.effect === diagnosis.steps[0].added);
      if (named && named.confounded_with.length)
        sentences.push("These runs hardly part it from " + named.confounded_with.map(words).join(", ") +
          (named.experiment ? ". What would: " + named.experiment : "") + ".");
    }
    if (diagnosis && diagnosis.verdict === "unknown") {
      const u = diagnosis.unexplained;
      if (u.depends_on.length) sentences.push("The missing force depends on " + u.depends_on.join(", ") +
        (u.shape ? ": " + u.shape : "") + ".");
    }
    D.notes.concat(sentences).forEach(s => add(said, "li", s));
    const tiles = add(head, "div", null, "tiles");
    const tile = (value, label) => { const t = add(tiles, "div", null, "tile"); add(t, "b", value); add(t, "span", label); };
    if (first) {
      // the diagnosis' own figures where there is one: a comparison refits once more
      const steps = diagnosis ? diagnosis.steps : [];
      const of = e => ({error: e.validation_error, error_free: e.validation_error_free, error_contact: e.validation_error_contact});
      const before = diagnosis ? of(diagnosis.baseline) : first.validation_errors;
      const after = steps.length ? of(steps[steps.length - 1]) : last.validation_errors;
      const two = D.stages.length > 1;
      const arrow = (a, b) => two ? err(a) + " → " + err(b) : err(a);
      tile(arrow(before.error, after.error), "error on held-out runs / noise");
      if (has(before.error_free) && has(before.error_contact)) tile(arrow(before.error_free, after.error_free), "… of runs without contact");
      if (has(before.error_contact)) tile(arrow(before.error_contact, after.error_contact), "… of runs with contact");
      tile(err(first.errors.noise_floor), "noise floor");
      tile(String(first.runs.length), "runs");
    } else if (diagnosis) {
      tile(err(diagnosis.baseline.validation_error), "error on held-out runs / noise");
    }
    const row = add(head, "div", null, "two row");
    if (D.revisions.length) revisions(row);
    if (diagnosis && diagnosis.ranking.length) rankingBars(row);
    if (first && (!diagnosis || !D.revisions.length)) heat(row);
  }

  function revisions(parent) {
    const c = card(parent, "Error by revision of the model", "Root mean square of the residual over its noise; 1 is the floor.");
    const rows = [["validation_error", "held-out runs", "blue", "solid"], ["validation_error_free", "without contact", "green", "dot"],
      ["validation_error_contact", "with contact", "orange", "dot"], ["fit_error", "runs to fit", "grey", "dash"]];
    plot(c, 300, () => ({
      traces: rows.filter(r => D.revisions.some(v => has(v[r[0]])))
        .filter(r => r[0] !== "validation_error_free" || D.revisions.some(v => has(v.validation_error_contact)))
        .map(r => ({x: D.revisions.map(v => words(v.label)), y: D.revisions.map(v => has(v[r[0]]) ? v[r[0]] : null), name: r[1],
          mode: r[0] === "validation_error" ? "lines+markers+text" : "lines+markers",
          text: D.revisions.map(v => err(v[r[0]])), textposition: "top right", cliponaxis: false,
          line: {color: colour(r[2]), dash: r[3], width: r[0] === "validation_error" ? 3 : 1.5}, marker: {size: 8}})),
      layout: {showlegend: true, yaxis: {title: {text: "error / noise [-]"}, rangemode: "tozero"},
               xaxis: {title: {text: "revision"}, type: "category"}, shapes: [floorLine("y")], margin: {r: 40}}}));
  }

  function rankingBars(parent) {
    const c = card(parent, "Which effect: evidence", "Natural logarithm of the odds against the model without it; best twelve.");
    const rows = diagnosis.ranking.filter(r => r.excited !== false).slice(0, 12).reverse();
    const adopted = diagnosis.steps.map(s => s.added);
    plot(c, 300, () => ({
      traces: [{type: "bar", orientation: "h", y: rows.map(r => words(r.effect)), x: rows.map(r => r.evidence),
        marker: {color: rows.map(r => adopted.includes(r.effect) ? colour("orange") : colour("grey"))},
        hovertemplate: "%{y}: %{x:.1f}<extra></extra>"}],
      layout: {xaxis: {title: {text: "evidence, ln odds [-]"}}, yaxis: {tickfont: {size: 11}}, margin: {l: 170}}}));
  }

  function heat(parent, stage) {
    const s = stage || first;
    const c = card(parent, "Where it fails: run by channel", "Error over noise" + (D.stages.length > 1 ? ", model " + words(s.label) : "") + ".");
    const ids = s.runs.map(r => r.id + (r.use === "validate" ? " (held out)" : ""));
    const z = s.runs.map(r => r.channel_errors);
    const top = Math.max(3, ...first.runs.flatMap(r => r.channel_errors.filter(has)));
    plot(c, Math.max(240, 60 + 21 * ids.length), () => ({
      traces: [{type: "heatmap", x: CHANNELS, y: ids, z: z, zmin: 1, zmax: top,
        colorscale: [[0, colour("card")], [1, colour("orange")]],
        colorbar: {title: {text: "error / noise", side: "right"}, thickness: 10, outlinewidth: 0}, xgap: 2, ygap: 2,
        hovertemplate: "%{y}, %{x}: %{z:.2f}<extra></extra>"}],
      layout: {yaxis: {autorange: "reversed", tickfont: {size: 11}}, xaxis: {title: {text: "channel"}}, margin: {l: 140}}}));
  }

  // ---- where it fails
  function where() {
    const s = section("Where the model fails",
      "The error that the sentences of the first page are about, cell by cell; 1 is the floor.");
    let row = add(s, "div", null, "two row");
    const runs = first.runs.map(r => r.id);
    const error = (stage, id) => stage.errors.by_run[id];
    bars(row, "By run", "All runs; the dashed line is the floor.", runs, error, "run");
    bars(row, "By channel", "ax … by: displacement; iax … iby: control current.", CHANNELS.filter(c => has(first.errors.by_channel[c])),
      (stage, c) => stage.errors.by_channel[c], "channel");
    row = add(s, "div", null, "two row");
    bars(row, "By regime", "What the rotor was doing.", Object.keys(first.errors.by_regime), (stage, r) => stage.errors.by_regime[r], "regime");
    const orders = Object.keys(first.errors.by_harmonic).map(Number).sort((a, b) => a - b).map(String);
    bars(row, "By harmonic of the speed", "Negative: backward. The error that taking it away would remove.", orders,
      (stage, h) => stage.errors.by_harmonic[h], "order [1/turn]");
    row = add(s, "div", null, "two row");
    if (first.errors.by_speed.length) {
      const c = card(row, "By speed");
      plot(c, 260, () => ({
        traces: D.stages.map((stage, i) => ({x: stage.errors.by_speed.map(b => b.speed_hz), y: stage.errors.by_speed.map(b => b.error),
          name: words(stage.label), mode: "lines+markers", line: {color: i === 0 && D.stages.length > 1 ? colour("orange") : colour("blue")}})),
        layout: {showlegend: D.stages.length > 1, xaxis: {title: {text: "speed [Hz]"}},
                 yaxis: {title: {text: "error / noise [-]"}, rangemode: "tozero"}, shapes: [floorLine("y")]}}));
    }
    if (D.stages.length > 1) heat(row, first);
  }

  // ---- overlays
  function choice(parent, label, options, change) {
    const l = add(parent, "label", label + " ");
    const s = add(l, "select");
    options.forEach((o, i) => { const e = add(s, "option", o); e.value = i; });
    s.addEventListener("change", () => change(Number(s.value)));
    return s;
  }
  function overlays() {
    const s = section("Measured against predicted",
      "A whole run is shown by the least and largest value of each interval. Runs with contact are predicted in windows of 10 ms, the others in one piece.");
    const picks = add(s, "div", null, "picks");
    const worst = first.runs.reduce((w, r, i) => r.error > first.runs[w].error ? i : w, 0);
    const state = {run: worst, channel: 0, stage: D.stages.length - 1, close: true};
    const names = () => Object.keys(D.stages[state.stage].runs[state.run].channels);
    let draw = () => {}, drawOrbit = () => {};
    const redraw = () => { draw(); drawOrbit(); };
    const runPick = choice(picks, "run", first.runs.map(r => `${r.id} (${r.use === "fit" ? "fit" : "held out"}, error ${err(r.error)})`),
      v => { state.run = v; state.channel = Math.min(state.channel, names().length - 1); redraw(); });
    runPick.value = worst;
    choice(picks, "channel", names(), v => { state.channel = v; redraw(); });
    if (D.stages.length > 1) {
      const p = choice(picks, "model", D.stages.map(t => t.label), v => { state.stage = v; redraw(); });
      p.value = state.stage;
    }
    choice(picks, "time", ["where the residual is largest", "the whole run"], v => { state.close = v === 0; redraw(); });
    draw = plot(s, 420, () => {
      const run = D.stages[state.stage].runs[state.run], name = names()[state.channel];
      const c = state.close ? run.channels[name].close : run.channels[name];
      const t = state.close ? c.measured.map((_, i) => c.from + i / run.sample_rate_hz) : run.t;
      const unit = name[0] === "i" ? "A" : "µm";
      const line = (y, label, colour_, more) => Object.assign({x: t, y: y, name: label, mode: "lines",
        line: {color: colour_, width: 1}}, more || {});
      return {traces: [line(c.measured, "measured", colour("ink")), line(c.predicted, "predicted", colour("blue")),
                       line(c.residual, "measured − predicted", colour("orange"), {yaxis: "y2"})],
              layout: {showlegend: true, yaxis: {domain: [0.42, 1], title: {text: name + " [" + unit + "]"}},
                       yaxis2: {domain: [0, 0.34], title: {text: "residual [" + unit + "]"}, gridcolor: colour("line"),
                                zerolinecolor: colour("line"), automargin: true},
                       xaxis: {title: {text: "time [s]"}, anchor: "y2"}}};
    });
    const row = add(s, "div", null, "two row");
    const ends = [0, 1].map(end => {
      const c = card(row, "Residual orbit, end " + "ab"[end], "Displacement that the model does not predict: mean over the shaft's angle (line), last samples (points).");
      return plot(c, 340, () => {
        const o = D.stages[state.stage].runs[state.run].orbits[end];
        const axis = {title: {text: "x [µm]"}};
        if (!o) return {traces: [], layout: {xaxis: axis, yaxis: {title: {text: "y [µm]"}},
          annotations: [{text: "no turning shaft in this run", showarrow: false, xref: "paper", yref: "paper", x: 0.5, y: 0.5}]}};
        return {traces: [{x: o.x, y: o.y, mode: "markers", marker: {size: 3, color: colour("grey"), opacity: 0.5}, name: "samples"},
                         {x: o.mean_x, y: o.mean_y, mode: "lines", line: {color: colour("orange"), width: 2.5}, name: "mean over a turn"}],
                layout: {showlegend: true, xaxis: axis, yaxis: {title: {text: "y [µm]"}, scaleanchor: "x"}}};
      });
    });
    drawOrbit = () => ends.forEach(f => f());
  }
  // The force that the model lacks, over what it may depend on.
  function forces() {
    if (!D.stages.some(stage => (stage.forces || []).some(f => f))) return;
    const s = section("The force that is missing", "From the residual of displacements and currents through the rotor's equation of motion, as if it acted at the magnetic bearings; means over all runs without contact.");
    const picks = add(s, "div", null, "picks");
    const state = {stage: 0, part: 0};
    const redraws = [];
    const redraw = () => redraws.forEach(f => f());
    if (D.stages.length > 1) choice(picks, "model", D.stages.map(t => t.label), v => { state.stage = v; redraw(); });
    choice(picks, "part", ["along the vector (pushes outwards where positive)", "across it (a quarter turn ahead)"], v => { state.part = v; redraw(); });
    const of = (end, what) => ((D.stages[state.stage].forces || [])[end] || {})[what];
    const nothing = {traces: [], layout: {annotations: [{text: "no runs for this picture", showarrow: false, xref: "paper", yref: "paper", x: 0.5, y: 0.5}]}};
    // one colour scale for all models and parts of a quantity
    const largest = what => Math.max(...D.stages.flatMap(t => (t.forces || []).flatMap(f => f && f[what] ?
      ["along", "across"].flatMap(p => f[what][p].flat().filter(has).map(Math.abs)) : [0])), 1e-9);
    [["position", "µm"], ["velocity", "mm/s"]].forEach(([what, unit]) => {
      const row = add(s, "div", null, "two row"), limit = largest(what);
      [0, 1].forEach(end => {
        const c = card(row, "Over " + what + ", end " + "ab"[end], "Mean force [N] in each cell; empty where the rotor hardly was.");
        redraws.push(plot(c, 340, () => {
          const m = of(end, what);
          if (!m) return nothing;
          return {traces: [{type: "heatmap", x: m.centres, y: m.centres, z: state.part ? m.across : m.along, zmin: -limit, zmax: limit,
                    colorscale: [[0, colour("blue")], [0.5, colour("card")], [1, colour("orange")]], colorbar: {title: {text: "N"}, thickness: 10, outlinewidth: 0},
                    hovertemplate: "%{x:.3g}, %{y:.3g} " + unit + ": %{z:.3g} N<extra></extra>"}],
                  layout: {xaxis: {title: {text: "x [" + unit + "]"}}, yaxis: {title: {text: "y [" + unit + "]"}, scaleanchor: "x"}}};
        }));
      });
    });
    const row = add(s, "div", null, "two row");
    [0, 1].forEach(end => {
      const c = card(row, "Over the shaft's angle, end " + "ab"[end], "Mean force in the stator's axes.");
      redraws.push(plot(c, 300, () => {
        const m = of(end, "angle");
        if (!m) return nothing;
        const line = (y, name, c_) => ({x: m.angle_deg, y: y, name: name, mode: "lines", line: {color: c_, width: 2}});
        return {traces: [line(m.x, "x", colour("blue")), line(m.y, "y", colour("orange"))],
                layout: {showlegend: true, xaxis: {title: {text: "shaft angle [deg]"}, range: [0, 360], dtick: 90}, yaxis: {title: {text: "force [N]"}}}};
      }));
    });
  }

  // ---- tables
  function table(parent, columns, rows) {
    const t = add(add(parent, "div", null, "scroll"), "table");
    const tr = add(add(t, "thead"), "tr");
    columns.forEach(c => add(tr, "th", c.title, c.n ? "n" : ""));
    const body = add(t, "tbody");
    rows.forEach(r => {
      const line = add(body, "tr", null, r.dim ? "dim" : "");
      columns.forEach(c => add(line, "td", c.value(r), c.n ? "n" : ""));
    });
  }
  function withStd(p) {
    // small lengths in micrometres
    const small = p.unit === "m" && Math.max(Math.abs(p.value), p.std || 0) < 1e-3;
    const f = small ? 1e6 : 1, unit = small ? "µm" : p.unit;
    return num(f * p.value, 4) + (p.std ? " ± " + num(f * p.std, 2) : "") + (unit && unit !== "1" ? " " + unit : "");
  }
  const list = parameters => Object.entries(parameters).map(([k, p]) => k + " " + withStd(p)).join("; ");

  function ranking() {
    const s = section("Which effect", "Every candidate was fitted together with all uncertain values of the rig, and judged on runs that it has not seen.");
    table(s, [
      {title: "effect", value: r => words(r.effect)},
      {title: "evidence", n: true, value: r => r.excited === false ? "–" : num(r.evidence, 4)},
      {title: "fit", n: true, value: r => err(r.fit_error)},
      {title: "held out", n: true, value: r => err(r.validation_error)},
      {title: "no contact", n: true, value: r => err(r.validation_error_free)},
      {title: "contact", n: true, value: r => err(r.validation_error_contact)},
      {title: "parameters ± standard deviation", value: r => list(r.parameters)},
      {title: "remarks", value: r => [r.excited === false ? "not excited by these runs" : "",
        r.plausible === false ? "not plausible: at a limit" : "",
        r.confounded_with.length ? "hardly parted from " + r.confounded_with.map(words).join(", ") : "", r.note || ""]
        .filter(x => x).join("; ")}
    ], diagnosis.ranking.map(r => Object.assign({dim: r.excited === false || r.plausible === false}, r,
      r.excited === false ? {fit_error: null, validation_error: null, validation_error_free: null,
                             validation_error_contact: null, parameters: {}} : {})));
    const proposed = diagnosis.ranking.filter(r => r.experiment);
    if (proposed.length) {
      add(add(s, "p"), "b", "What would part them");
      const ul = add(s, "ul", null, "said");
      proposed.forEach(r => add(ul, "li", words(r.effect) + ", " + r.experiment));
    }
    const experiments = diagnosis.experiments || [];
    if (experiments.length) {
      const t = section("Experiments that would part them", "Simulated with both models; what the wrong one leaves after its own refit, " +
        "over the noise, and the evidence to expect from it. The commands run both on the simulated rig.");
      table(t, [{title: "effects", value: r => words(r.effect) + " or " + words(r.against)}, {title: "run", value: r => r.what},
        {title: "left / noise", n: true, value: r => num(r.separation, 2)}, {title: "evidence", n: true, value: r => num(r.evidence, 3)}],
        experiments);
      add(t, "pre", experiments.flatMap(r => r.commands || []).join("\n"));
    }
    if (diagnosis.steps.length) {
      const t = section("Adopted, one after the other");
      table(t, [{title: "effect", value: r => words(r.added)}, {title: "held out", n: true, value: r => err(r.validation_error)},
        {title: "no contact", n: true, value: r => err(r.validation_error_free)},
        {title: "contact", n: true, value: r => err(r.validation_error_contact)},
        {title: "parameters ± standard deviation", value: r => list(r.parameters)}], diagnosis.steps);
    }
  }
  function unexplained() {
    const u = diagnosis.unexplained;
    if (!u.depends_on.length && !u.shape && !(u.terms || []).length) return;
    const t = section("What no effect of the catalogue explains", "A hypothesis, not a finding.");
    add(t, "p", "depends on " + (u.depends_on.join(", ") || "nothing that was measured") + (u.shape ? ": " + u.shape : ""));
    if (u.held_out_gain > 0) add(t, "p", "On the runs that it was not fitted to it takes " + num(100 * u.held_out_gain, 3) + " % of what is left above the noise.");
    if ((u.terms || []).length) table(t, [{title: "term", value: r => r.term}, {title: "coefficient", value: r => r.std === undefined ? num(r.coefficient) : withStd({value: r.coefficient, std: r.std})}],
      u.terms.concat(u.plane_z_m ? [{term: "plane z_m", coefficient: u.plane_z_m.value, std: u.plane_z_m.std}] : []).concat(u.step_width_m ? [{term: "width w of the step [m]", coefficient: u.step_width_m}] : [])
        .concat(u.step_width_A ? [{term: "width w of the step [A]", coefficient: u.step_width_A}] : []));
    law(t);
  }
  // The force of the law over each quantity that it depends on.
  function law(parent) {
    let row = null;
    D.law.forEach((one, i) => {
      if (i % 2 === 0) row = add(parent, "div", null, "two row");
      const signals = diagnosis.unexplained.place === "sensors";
      const c = card(row, "The law over the " + one.quantity, (signals ? "What a sensor adds to its signal, over that" : "Force at " +
        (diagnosis.unexplained.plane_z_m ? "that plane" :
          diagnosis.unexplained.place === "tilt" ? "bearing b, and its opposite at a, over half of b less a" : "bearing a")) +
        ", as far as the runs without contact went" +
        (one.curves.length > 1 ? "; dashed: the other quantities at the end of their range, solid: at 0." : "."));
      plot(c, 300, () => ({
        traces: one.curves.flatMap((curve, k) => [["x", "blue"], ["y", "orange"]].map(([axis, tone]) => ({x: one.at, y: curve[axis],
          name: (signals ? "" : "F") + axis + (curve.name ? ", " + curve.name : ""), mode: "lines", line: {color: colour(tone), width: 2, dash: k ? "dash" : "solid"}}))),
        layout: {showlegend: true, xaxis: {title: {text: one.axis}}, yaxis: {title: {text: signals ? "added to the signal [µm]" : "force [N]"}}}}));
    });
  }
  function nuisance() {
    const s = section("Values of the rig that were uncertain", "Fitted on the runs to fit.");
    const names = Object.keys(last.nuisance);
    const cell = (stage, n) => stage.nuisance[n] ? withStd(stage.nuisance[n]) : "–";
    table(s, [{title: "value", value: n => n}].concat(D.stages.map(stage => ({title: stage.label, value: n => cell(stage, n)}))), names);
    const remarks = [...new Set(D.stages.flatMap(t => t.remarks).concat(diagnosis ? diagnosis.remarks : []))];
    if (remarks.length) {
      add(add(s, "p"), "b", "Remarks on the data");
      const ul = add(s, "ul", null, "said");
      remarks.forEach(r => add(ul, "li", r));
    }
    D.stages.forEach(stage => {
      const d = add(s, "details");
      add(d, "summary", "model file: " + stage.label + " (" + stage.model_hash + ")");
      add(d, "pre", stage.model_text);
    });
  }

  firstPage();
  D.tables.forEach(t => table(section(t.title), t.columns.map((c, i) => ({title: c, n: i > 0, value: r => r[i]})), t.rows));
  if (first) where();
  if (diagnosis && diagnosis.ranking.length) ranking();
  if (diagnosis) unexplained();
  if (first) { overlays(); forces(); nuisance(); }
  drawn.forEach(draw => draw());
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn.forEach(draw => draw()));
  document.body.dataset.ready = "yes";
})();
