// SPDX-License-Identifier: GPL-3.0-or-later
// The chart of one loop: it scrolls with the time, unless the user has zoomed or moved back.

import { element } from "./panels.js";

const CURVES = [
  { label: "measured", color: "--measured", width: 2, scale: "c" },
  { label: "machine", color: "--machine", width: 1, scale: "c", dash: [5, 4] },
  { label: "setpoint", color: "--setpoint", width: 1.5, scale: "c" },
  { label: "duty", color: "--duty", width: 1, scale: "percent", fill: true },
];
const WINDOWS = [["1 min", 60], ["10 min", 600], ["1 h", 3600], ["all", Infinity]];
const STEPS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 28800, 86400, 864000];
const HEIGHT = 320;
const LEAST_S = 5;
const LEAST_SPAN_K = 4;

const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function clock(seconds) {
  const sign = seconds < 0 ? "−" : "";
  const whole = Math.round(Math.abs(seconds));
  const two = (number) => String(number).padStart(2, "0");
  return `${sign}${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

// A chart in an element; draw() draws the points that were added since the last frame.
export class Chart {
  constructor(place, loop) {
    this.columns = [[], [], [], [], []];
    this.span = 600; // length of the shown time, s
    this.end = null; // end of the shown time; null: now
    this.now = 0;
    this.changed = true;
    this.buttons = this.windows(place);
    this.frame = element("div", { class: "chart", tabindex: "0", role: "img", onkeydown: (event) => this.key(event) });
    this.loop = loop;
    place.append(this.frame, element("p", { class: "soft" },
      "Drag to zoom in, double-click to follow. Keys: + and − zoom, ← and → move, End follows."));
    this.plot = new window.uPlot(this.options(), this.columns, this.frame);
    new ResizeObserver(() => this.resize()).observe(this.frame);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.plot.redraw(false, true));
  }

  windows(place) {
    const buttons = WINDOWS.map(([text, seconds]) =>
      [element("button", { type: "button", onclick: () => this.show(seconds, null) }, text), seconds]);
    place.append(element("p", { class: "row", role: "group", "aria-label": "Time shown" }, ...buttons.map(([button]) => button)));
    return buttons;
  }

  options() {
    const axis = { stroke: () => ink("--soft"), grid: { stroke: () => ink("--line"), width: 1 }, ticks: { show: false } };
    return {
      width: Math.max(240, this.frame.clientWidth), height: HEIGHT, legend: { show: false },
      cursor: { drag: { x: true, y: false, setScale: false }, bind: { dblclick: () => () => this.show(this.span, null) } },
      hooks: { setSelect: [(plot) => this.select(plot)] },
      scales: {
        x: { time: false, range: () => this.range() },
        c: { range: (_, low, high) => around(low, high) },
        percent: { range: () => [0, 300] },
      },
      axes: [
        { ...axis, values: (_, all) => all.map(clock), space: 70, size: 32, incrs: STEPS_S },
        {
          ...axis, scale: "c", size: 48, filter: (plot, all) => all.map((each) => (each < floor(plot) ? null : each)),
          values: (_, all) => all.map((each) => (each === null ? "" : `${each}°`)),
        },
        {
          ...axis, scale: "percent", side: 1, grid: { show: false }, size: 46,
          splits: () => [0, 50, 100], values: (_, all) => all.map((each) => `${each} %`),
        },
      ],
      series: [{}, ...CURVES.map((curve) => ({
        label: curve.label, scale: curve.scale, width: curve.width, dash: curve.dash,
        stroke: () => ink(curve.color), points: { show: false },
        fill: curve.fill ? () => `${ink(curve.color)}40` : undefined,
      }))],
    };
  }

  // Adds points; fresh: they replace all earlier ones.
  add({ fresh, points }) {
    if (fresh) this.columns = [[], [], [], [], []];
    for (const point of points) point.forEach((value, place) => this.columns[place].push(value));
    this.changed = true;
  }

  at(time) {
    this.now = time;
    if (this.end === null) this.changed = true;
  }

  draw() {
    if (!this.changed) return;
    this.changed = false;
    this.plot.setData(this.columns);
    for (const [button, seconds] of this.buttons) {
      button.setAttribute("aria-pressed", String(this.end === null && seconds === this.span));
    }
    const last = this.columns[0].length - 1;
    const said = (place) => this.columns[place][last]?.toFixed(1) ?? "nothing";
    this.frame.setAttribute("aria-label", last < 0 ? `${this.loop}: no readings yet` :
      `${this.loop}: measured ${said(1)} °C, setpoint ${said(3)} °C, duty ${said(4)} %`);
  }

  range() {
    const first = this.columns[0][0] ?? 0;
    const least = this.span === Infinity ? LEAST_S : first + this.span; // start at the first point
    const end = this.end ?? Math.max(this.now, least);
    return [this.span === Infinity ? first : end - this.span, end];
  }

  show(span, end) {
    this.span = Math.max(LEAST_S, span);
    this.end = end;
    this.changed = true;
    this.draw();
  }

  select(plot) {
    const { left, width } = plot.select;
    if (width < 4) return;
    const [from, to] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.show(to - from, to);
  }

  key(event) {
    const [from, to] = this.range();
    const span = to - from;
    const moves = {
      "+": () => this.show(span / 2, this.end === null ? null : to - span / 4),
      "-": () => this.show(span * 2, this.end),
      ArrowLeft: () => this.show(span, to - span / 4),
      ArrowRight: () => this.show(span, to + span / 4 >= this.now ? null : to + span / 4),
      End: () => this.show(span, null),
    };
    if (!moves[event.key]) return;
    event.preventDefault();
    moves[event.key]();
  }

  resize() {
    const width = this.frame.clientWidth;
    if (width && width !== this.plot.width) this.plot.setSize({ width, height: HEIGHT });
  }
}

// Returns the lowest temperature that the axis shows; the duty is drawn below it.
function floor(plot) {
  const { min, max } = plot.scales.c;
  return min + (max - min) / 3;
}

function around(low, high) {
  if (low === null || high === null) return [0, 100];
  const spare = Math.max(LEAST_SPAN_K - (high - low), 0.1 * (high - low)) / 2;
  return [low - spare - 0.5 * (high - low + 2 * spare), high + spare];
}
