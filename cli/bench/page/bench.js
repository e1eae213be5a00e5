// SPDX-License-Identifier: GPL-3.0-or-later
// The page of `bench`: it shows the data from the WebSocket, and sends the user's actions as commands.

import { Chart } from "./chart.js";
import { connect, element, figuresOf, moment, panelOf, roll } from "./panels.js";

const find = (id) => document.getElementById(id);
const FIRST_OPEN = ["sensor", "heater", "processor"];
const MOST_VARIABLES = 200;

let line = null;
let about = null;
let number = 0;
let speed = "1"; // the speed after a pause
let panels = [];
let charts = {};
let sliders = [];
let state = {};
let variables = {};

function order(what) {
  if (line?.readyState === WebSocket.OPEN) line.send(JSON.stringify({ ...what, number: ++number }));
}

function refused(error) {
  find("refused").textContent = error;
  find("refused").hidden = !error;
}

// ---- built once, from the data that never change -------------------------------------------

function build(what) {
  about = what;
  document.title = `${about.name} – bench`;
  find("title").textContent = about.title;
  find("subtitle").textContent = `${about.spec} on ${about.board}, in the simulated board`;
  find("interfaces").replaceChildren();
  panels = about.interfaces.map((each) => panelOf(each, order));
  for (const { panel } of panels) find("interfaces").append(panel);
  find("courses").replaceChildren();
  charts = {};
  for (const loop of Object.keys(about.loops)) buildLoop(loop);
  buildFaults();
  buildAround();
  find("journal").replaceChildren();
  watch();
}

const CURVES = [["temperature_c", "measured", "--measured", "°C"], ["machine_c", "machine", "--machine", "°C"],
  ["setpoint_c", "setpoint", "--setpoint", "°C"], ["duty_percent", "duty", "--duty", "%"]];
const loops = {};

function buildLoop(loop) {
  const { list, cells } = figuresOf(CURVES);
  const why = element("div", { class: "why" });
  const place = element("section", { "aria-label": loop }, element("h2", {}, loop), list, why);
  find("courses").append(place);
  charts[loop] = new Chart(place, loop);
  loops[loop] = { cells, why, said: "" };
}

function buildFaults() {
  const groups = new Map();
  for (const fault of about.faults) {
    const name = fault.id.startsWith(`${fault.loop}.`) ? `${fault.part} of ${fault.loop}` : fault.part;
    if (!groups.has(name)) groups.set(name, { part: fault.part, faults: [] });
    groups.get(name).faults.push(fault);
  }
  find("faults").replaceChildren(...[...groups].map(([name, group], place) => {
    const list = element("ul", {}, ...group.faults.map(faultItem));
    const count = element("span", { class: "count" });
    const open = FIRST_OPEN.includes(group.part) && place < 8;
    return element("details", { class: "part", open }, element("summary", {}, name, " ", count), list);
  }));
}

function faultItem(fault) {
  const text = fault.id.replace(/^.*\./, "").replaceAll("_", " ");
  const send = (on) => order({ do: "fault", fault: fault.id, on });
  if (!fault.lasts) {
    const button = element("button", {
      type: "button", "data-fault": fault.id, onclick: () => send(!state.faults.includes(fault.id)),
    }, text);
    return element("li", { "data-text": text }, button);
  }
  const box = element("input", { type: "checkbox", "data-fault": fault.id, onchange: () => send(box.checked) });
  return element("li", { "data-text": text }, element("label", { class: "check" }, box, text));
}

function buildAround() {
  sliders = [
    slider("Surroundings", "°C", -40, 80, 1, (now) => now.ambient_c, (ambient_c) => ({ do: "ambient", ambient_c })),
    slider("Voltage of the heaters’ supply", "%", 0, 130, 1, (now) => now.supply_percent, (percent) => ({ do: "supply", percent })),
    ...Object.entries(about.heaters_w).map(([heater, power]) => slider(`Load: heat removed at ${heater}`, "W", 0, power, power / 100,
      (now) => now.taken_w[heater], (watts) => ({ do: "load", heater, watts }))),
  ];
  if (about.feeds) {
    sliders.push(slider("Load: feed of filament", "mm/s", 0, 20, 0.1, (now) => now.feed_mm_per_s, (mm_per_s) => ({ do: "feed", mm_per_s })));
  }
  find("around").replaceChildren(...sliders.map(({ place }) => place));
}

function slider(text, unit, min, max, step, read, write) {
  let touched = -Infinity; // not 0: the clock of a page begins at 0
  let waiting = null;
  const id = `slider-${++number}`;
  const output = element("output", { for: id });
  const input = element("input", { id, type: "range", min, max, step });
  const label = element("div", { class: "slider" }, element("label", { for: id }, text), output, input);
  const shown = (value) => `${Number(value.toPrecision(4))} ${unit}`;
  input.addEventListener("input", () => {
    touched = performance.now();
    output.textContent = shown(Number(input.value));
    clearTimeout(waiting);
    waiting = setTimeout(() => order(write(Number(input.value))), 80);
  });
  return {
    place: label,
    show(now) {
      if (performance.now() - touched < 600) return;
      input.value = read(now);
      output.textContent = shown(read(now));
    },
  };
}

// ---- new data ------------------------------------------------------------------------------

function show(fresh) {
  state = { ...state, ...fresh };
  if (fresh.time_s !== undefined || fresh.rate !== undefined) showClock();
  if (fresh.speed !== undefined) showSpeed();
  if (fresh.loops || fresh.nodes_c) for (const loop of Object.keys(about.loops)) showLoop(loop);
  if ("fault" in fresh) showFault();
  if (fresh.faults) showFaults();
  if (fresh.interfaces) fresh.interfaces.forEach((each, place) => panels[place].show(each));
  if (fresh.pictures) for (const [place, version] of Object.entries(fresh.pictures)) panels[place].pictured?.(version);
  for (const each of sliders) each.show(state);
  for (const chart of Object.values(charts)) chart.at(state.time_s);
}

function showClock() {
  const seconds = state.time_s;
  const two = (value) => String(Math.floor(value)).padStart(2, "0");
  const clock = `${Math.floor(seconds / 3600)}:${two((seconds / 60) % 60)}:${two(seconds % 60)}`;
  find("clock").textContent = `${clock}  (${state.speed === 0 ? "paused" : `${Number(state.rate.toPrecision(3))} ×`})`;
}

function showSpeed() {
  const paused = state.speed === 0;
  find("pause").textContent = paused ? "Run" : "Pause";
  find("pause").setAttribute("aria-pressed", String(paused));
  if (paused) return;
  speed = String(state.speed);
  const choice = find("speed");
  if (![...choice.options].some((each) => each.value === speed)) choice.append(element("option", { value: speed }, `${speed} ×`));
  if (document.activeElement !== choice) choice.value = speed;
}

function showLoop(loop) {
  const { cells, why } = loops[loop];
  const now = state.loops[loop];
  for (const [key, , , unit] of CURVES) {
    const value = key === "machine_c" ? state.nodes_c[about.loops[loop].node] : now[key];
    const text = value === null || value === undefined ? "–" : `${value.toFixed(1)} ${unit}`;
    if (cells[key].textContent !== text) cells[key].textContent = text;
  }
  const heater = about.loops[loop].heater;
  // Pulses are too quick to read: show the duty instead.
  const pulses = now.heater_on ? now.duty_percent < 100 : now.missing[0].id === "pause";
  const on = now.heater_on || pulses;
  const head = pulses ? `${heater} is on for ${now.duty_percent.toFixed(0)} % of the time.` :
    now.heater_on ? `${heater} is on.` : `${heater} is off:`;
  const said = JSON.stringify([head, on || now.missing]);
  if (said === loops[loop].said) return;
  loops[loop].said = said;
  why.classList.toggle("on", on);
  why.replaceChildren(element("b", {}, head));
  if (!on) why.append(element("ul", {}, ...now.missing.map(({ id, text }) => element("li", { "data-id": id }, text))));
}

function showFault() {
  const banner = find("fault");
  banner.hidden = !state.fault;
  if (!state.fault) return;
  const { code, id, meaning, remedy } = state.fault;
  banner.replaceChildren(element("b", {}, `E${String(code).padStart(2, "0")} ${id}: ${meaning}`), remedy);
}

function showFaults() {
  for (const box of find("faults").querySelectorAll("input[data-fault]")) box.checked = state.faults.includes(box.dataset.fault);
  for (const button of find("faults").querySelectorAll("button[data-fault]")) button.classList.toggle("on", state.faults.includes(button.dataset.fault));
  for (const part of find("faults").querySelectorAll(".part")) {
    const count = part.querySelectorAll("input:checked, button.on").length;
    part.querySelector(".count").textContent = count ? `(${count} on)` : "";
  }
}

function showVariables() {
  const wanted = find("variable-filter").value.toLowerCase();
  const names = about.variables.filter((name) => name.toLowerCase().includes(wanted));
  const body = find("variables").querySelector("tbody");
  const shown = names.slice(0, MOST_VARIABLES);
  if (body.dataset.names !== shown.join()) {
    body.dataset.names = shown.join();
    body.replaceChildren(...shown.map((name) => element("tr", {}, element("th", { scope: "row" }, name), element("td", { class: "number" }))));
  }
  shown.forEach((name, place) => {
    const text = String(variables[name] ?? "–");
    const cell = body.children[place].lastChild;
    if (cell.textContent !== text) cell.textContent = text;
  });
  find("variables-more").textContent = names.length > shown.length ? `and ${names.length - shown.length} more` : "";
}

function took(what) {
  if (what.about) build(what.about);
  if (what.state) show(what.state);
  if (what.charts) for (const [loop, points] of Object.entries(what.charts)) charts[loop].add(points);
  if (what.lines) {
    for (const [name, lines] of Object.entries(what.lines)) {
      if (name === "journal") roll(find("journal"), lines, ([time, text]) => element("li", {}, moment(time), text));
      else panels[Number(name)].took?.(lines);
    }
  }
  if (what.variables) {
    variables = what.variables;
    showVariables();
  }
  if (what.error !== undefined) refused(what.error);
}

// ---- the WebSocket -------------------------------------------------------------------------

function watch() {
  order({ do: "watch", variables: find("variables").open });
}

function draw() {
  for (const chart of Object.values(charts)) chart.draw();
  requestAnimationFrame(draw);
}

find("pause").addEventListener("click", () => order({ do: "speed", speed: state.speed === 0 ? asked(speed) : 0 }));
find("step").addEventListener("click", () => order({ do: "step" }));
find("speed").addEventListener("change", () => order({ do: "speed", speed: asked(find("speed").value) }));
find("play").addEventListener("click", () => order({ do: "play" }));
find("variables").addEventListener("toggle", watch);
find("variable-filter").addEventListener("input", showVariables);
find("fault-filter").addEventListener("input", () => {
  const wanted = find("fault-filter").value.toLowerCase();
  for (const part of find("faults").children) {
    let shown = 0;
    for (const item of part.querySelectorAll("li")) {
      item.hidden = !item.dataset.text.includes(wanted);
      shown += !item.hidden;
    }
    part.hidden = shown === 0;
    if (wanted) part.open = true;
  }
});

function asked(value) {
  return value === "full" ? value : Number(value);
}

connect(took, (made) => { line = made; });
draw();
