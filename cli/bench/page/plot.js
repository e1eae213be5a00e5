// SPDX-License-Identifier: GPL-3.0-or-later
// The page of `plot`: the readings of one loop, from a serial line or a log.

import { Chart } from "./chart.js";
import { connect, element, figuresOf, roll } from "./panels.js";

const find = (id) => document.getElementById(id);
const FIGURES = [["temperature_c", "measured", "--measured", "°C"], ["setpoint_c", "setpoint", "--setpoint", "°C"],
  ["duty_percent", "duty", "--duty", "%"]];

let chart = null;
let cells = {};

function build(about) {
  document.title = `${about.title} – plot`;
  find("title").textContent = about.title;
  find("subtitle").textContent = about.source;
  find("said").hidden = !about.live;
  find("lines").replaceChildren();
  const figures = figuresOf(FIGURES);
  cells = figures.cells;
  const place = element("section", { "aria-label": about.loop }, element("h2", {}, about.loop), figures.list);
  find("courses").replaceChildren(place);
  chart = new Chart(place, about.loop);
  if (!about.live) chart.show(Infinity, null);
}

function show(state) {
  for (const [key, , , unit] of FIGURES) {
    if (state[key] !== undefined) cells[key].textContent = state[key] === null ? "–" : `${state[key].toFixed(1)} ${unit}`;
  }
  if (state.time_s !== undefined) chart.at(state.time_s);
}

function took(what) {
  if (what.about) build(what.about);
  if (what.state) show(what.state);
  if (what.charts) for (const points of Object.values(what.charts)) chart.add(points);
  for (const lines of Object.values(what.lines ?? {})) roll(find("lines"), lines, (text) => element("li", {}, text));
}

function draw() {
  chart?.draw();
  requestAnimationFrame(draw);
}

connect(took);
draw();
