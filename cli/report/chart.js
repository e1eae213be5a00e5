// Draws the charts of a page: panels over one time axis, with a cross-hair that reads all curves.
// Dragging zooms in, a double click shows everything again, the legend hides curves.
"use strict";

const LEFT = 56, RIGHT = 12, TOP = 10, BOTTOM = 6, AXIS = 22;

function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((each) => each * power).find((each) => each >= rough);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9) + (step / power === 2.5 ? 1 : 0));
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high + step * 1e-9; value += step) {
    found.push([value, value.toFixed(digits)]);
  }
  return found;
}

// Index of the last point at or before a time, -1 before the first.
function at(times, time) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1; else high = middle;
  }
  return low - 1;
}

function rule(pen, fromX, fromY, toX, toY) {
  pen.beginPath();
  pen.moveTo(fromX, fromY);
  pen.lineTo(toX, toY);
  pen.stroke();
}

class Panel {
  constructor(chart, data, last) {
    Object.assign(this, { chart, data, last, hidden: new Set() });
    this.element = document.createElement("div");
    this.element.className = "panel";
    this.legend = document.createElement("div");
    this.legend.className = "legend";
    this.canvas = document.createElement("canvas");
    this.height = data.height + (last ? AXIS : 0);
    this.canvas.style.height = `${this.height}px`;
    this.element.append(this.legend, this.canvas);
    this.values = data.series.map((series) => this.entry(series));
    chart.listen(this.canvas);
  }

  entry(series) {
    const button = document.createElement("button");
    const swatch = document.createElement("i");
    const value = document.createElement("b");
    swatch.style.borderTopColor = series.colour;
    swatch.style.borderTopStyle = series.dashed ? "dashed" : "solid";
    button.append(swatch, series.name, value);
    button.onclick = () => {
      if (!this.hidden.delete(series)) this.hidden.add(series);
      button.classList.toggle("hidden");
      this.chart.draw();
    };
    this.legend.append(button);
    return value;
  }

  range() {
    if (this.data.range) return this.data.range;
    const [from, to] = this.chart.view;
    let low = Infinity, high = -Infinity;
    for (const series of this.data.series.filter((each) => !this.hidden.has(each))) {
      const first = Math.max(0, at(series.t, from));
      const last = Math.min(series.t.length - 1, at(series.t, to) + 1);
      for (let index = first; index <= last; index++) {
        low = Math.min(low, series.v[index]);
        high = Math.max(high, series.v[index]);
      }
    }
    if (!(low <= high)) return [0, 1];
    const room = 0.06 * (high - low) || 0.5;
    return [low - room, high + room];
  }

  draw() {
    const scale = window.devicePixelRatio || 1;
    const width = this.canvas.clientWidth;
    this.canvas.width = width * scale;
    this.canvas.height = this.height * scale;
    const pen = this.canvas.getContext("2d");
    pen.scale(scale, scale);
    const [from, to] = this.chart.view, [low, high] = this.range();
    const bottom = this.data.height - BOTTOM;
    this.x = (time) => LEFT + ((time - from) / (to - from)) * (width - LEFT - RIGHT);
    this.y = (value) => bottom - ((value - low) / (high - low)) * (bottom - TOP);
    this.grid(pen, width, bottom, low, high);
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, TOP, width - LEFT - RIGHT, bottom - TOP);
    pen.clip();
    for (const band of this.data.bands || []) this.band(pen, band, width);
    for (const series of this.data.series) if (!this.hidden.has(series)) this.curve(pen, series);
    this.marks(pen, bottom);
    pen.restore();
    this.cursor(pen, bottom);
  }

  band(pen, [low, high], width) {
    pen.globalAlpha = 0.2;
    pen.fillStyle = getComputedStyle(document.body).getPropertyValue("--warm");
    pen.fillRect(LEFT, this.y(high), width - LEFT - RIGHT, Math.max(1, this.y(low) - this.y(high)));
    pen.globalAlpha = 1;
  }

  grid(pen, width, bottom, low, high) {
    const style = getComputedStyle(document.body);
    const line = style.getPropertyValue("--line"), text = style.getPropertyValue("--soft");
    pen.font = `12px ${style.fontFamily}`;
    pen.textBaseline = "middle";
    pen.lineWidth = 1;
    for (const [value, label] of ticks(low, high, this.data.height / 36)) {
      pen.strokeStyle = line;
      rule(pen, LEFT, this.y(value), width - RIGHT, this.y(value));
      pen.fillStyle = text;
      pen.textAlign = "right";
      pen.fillText(label, LEFT - 8, this.y(value));
    }
    const [from, to] = this.chart.view;
    const times = ticks(from, to, (width - LEFT) / 90);
    for (const [time, label] of times) {
      pen.strokeStyle = line;
      rule(pen, this.x(time), TOP, this.x(time), bottom);
      if (!this.last) continue;
      pen.fillStyle = text;
      pen.textAlign = "center";
      const unit = time === times[times.length - 1][0] ? ` ${this.chart.data.unit}` : "";
      pen.fillText(label + unit, Math.min(this.x(time), width - 24), bottom + 16);
    }
  }

  curve(pen, series) {
    const [from, to] = this.chart.view, { t, v } = series;
    const first = Math.max(0, at(t, from)), last = Math.min(t.length - 1, at(t, to) + 1);
    if (last < first) return;
    pen.beginPath();
    pen.moveTo(this.x(t[first]), this.y(v[first]));
    for (let index = first + 1; index <= last; index++) {
      if (series.kind !== "line") pen.lineTo(this.x(t[index]), this.y(v[index - 1]));
      pen.lineTo(this.x(t[index]), this.y(v[index]));
    }
    if (series.kind === "area") {
      pen.lineTo(this.x(t[last]), this.y(0));
      pen.lineTo(this.x(t[first]), this.y(0));
      pen.globalAlpha = 0.75;
      pen.fillStyle = this.colour(series);
      pen.fill();
      pen.globalAlpha = 1;
      return;
    }
    pen.setLineDash(series.dashed ? [5, 4] : []);
    pen.lineWidth = 1.5;
    pen.lineJoin = "round";
    pen.strokeStyle = this.colour(series);
    pen.stroke();
    pen.setLineDash([]);
  }

  // Some colours are variables of the page: dark blue would be hard to see on a dark page.
  colour(series) {
    const name = series.colour.match(/^var\((.*)\)$/);
    return name ? getComputedStyle(document.body).getPropertyValue(name[1]) : series.colour;
  }

  marks(pen, bottom) {
    const style = getComputedStyle(document.body);
    const rows = { above: [], below: [] };
    for (const mark of this.chart.data.marks) {
      pen.strokeStyle = pen.fillStyle = style.getPropertyValue(mark.fault ? "--bad" : "--soft");
      pen.setLineDash(mark.fault ? [] : [2, 3]);
      pen.lineWidth = mark.fault ? 1.5 : 1;
      rule(pen, this.x(mark.t), TOP, this.x(mark.t), bottom);
      pen.setLineDash([]);
      if (mark.fault) this.label(pen, mark, rows.below, bottom - 10, -14);
      else if (this.data.first) this.label(pen, mark, rows.above, TOP + 8, 14);
    }
  }

  // Places a label in the first row where it covers no other; left of its line near the right end.
  label(pen, mark, rows, first, height) {
    const end = this.canvas.clientWidth - RIGHT, time = this.x(mark.t);
    if (time < LEFT || time > end) return;
    const size = pen.measureText(mark.text).width + 8;
    const start = time + size > end ? time - size : time;
    const free = (row) => row.every(([from, to]) => start + size <= from || to <= start);
    let row = rows.findIndex(free);
    if (row < 0) row = rows.push([]) - 1;
    rows[row].push([start, start + size]);
    if ((row + 1) * Math.abs(height) > this.data.height - TOP - BOTTOM) return;
    pen.textAlign = "left";
    pen.fillText(mark.text, start + 4, first + row * height);
  }

  cursor(pen, bottom) {
    const time = this.chart.cursor;
    this.data.series.forEach((series, index) => {
      const place = time === null ? -1 : at(series.t, time);
      this.values[index].textContent = place < 0 ? "" : series.v[place].toFixed(series.digits);
    });
    if (time === null) return;
    pen.strokeStyle = getComputedStyle(document.body).getPropertyValue("--soft");
    pen.lineWidth = 1;
    rule(pen, this.x(time), TOP, this.x(time), bottom);
    if (this.chart.pressed === null) return;
    pen.globalAlpha = 0.15;
    pen.fillStyle = getComputedStyle(document.body).getPropertyValue("--ink");
    const start = this.x(this.chart.pressed);
    pen.fillRect(start, TOP, this.x(time) - start, bottom - TOP);
    pen.globalAlpha = 1;
  }
}

class Chart {
  constructor(figure) {
    this.data = JSON.parse(figure.querySelector("script").textContent);
    this.view = this.whole();
    this.cursor = this.pressed = null;
    const count = this.data.panels.length;
    this.data.panels[0].first = true;
    this.panels = this.data.panels.map((data, index) => new Panel(this, data, index === count - 1));
    figure.prepend(...this.panels.map((panel) => panel.element));
    new ResizeObserver(() => this.draw()).observe(figure);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  // The whole range of the axis; that of a histogram does not begin at 0.
  whole() {
    return [this.data.start || 0, this.data.duration];
  }

  time(event) {
    const box = event.target.getBoundingClientRect(), [from, to] = this.view;
    const share = (event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT);
    return from + Math.min(1, Math.max(0, share)) * (to - from);
  }

  listen(canvas) {
    const act = (work) => (event) => { work(event); this.draw(); };
    canvas.onpointermove = act((event) => { this.cursor = this.time(event); });
    canvas.onpointerleave = act(() => { if (this.pressed === null) this.cursor = null; });
    canvas.onpointerdown = act((event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pressed = this.time(event);
    });
    canvas.onpointerup = act((event) => {
      const ends = [this.pressed, this.time(event)].sort((a, b) => a - b);
      this.pressed = null;
      if (ends[1] - ends[0] > 0.005 * (this.view[1] - this.view[0])) this.view = ends;
    });
    canvas.ondblclick = act(() => { this.view = this.whole(); });
  }

  draw() {
    for (const panel of this.panels) panel.draw();
  }
}

document.querySelectorAll("figure.chart").forEach((figure) => new Chart(figure));
