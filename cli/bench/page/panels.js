// SPDX-License-Identifier: GPL-3.0-or-later
// One panel for each kind of interface: what it shows, and its controls.

export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (typeof value === "boolean") made.toggleAttribute(key, value);
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

// Returns a list of figures, and the element of each value by the curve's key. Each curve is an
// array that begins with its key, name and color.
export function figuresOf(curves) {
  const list = element("dl", { class: "figures" });
  const cells = {};
  for (const [key, text, color] of curves) {
    const mark = element("i", { "aria-hidden": "true" });
    mark.style.borderColor = `var(${color})`;
    cells[key] = element("dd", {}, "–");
    list.append(element("div", {}, element("dt", {}, mark, text), cells[key]));
  }
  return { list, cells };
}

// Keeps a WebSocket to the server: calls began(line) for each new one, took(data) for each message.
export function connect(took, began = () => {}) {
  const lost = document.getElementById("lost");
  const line = new WebSocket(new URL("live", location.href.replace(/^http/, "ws")));
  began(line);
  line.addEventListener("open", () => { lost.hidden = true; });
  line.addEventListener("message", (event) => took(JSON.parse(event.data)));
  line.addEventListener("close", () => {
    lost.hidden = false;
    setTimeout(() => connect(took, began), 1000);
  });
}

// Calls down(event) when a finger presses a button, down() for Enter or Space, and up(seconds) on
// release, even if the finger has left the button.
export function holdable(button, down, up) {
  let since = null;
  const begin = (event) => {
    if (since !== null) return;
    since = performance.now();
    down(event);
  };
  const end = () => {
    if (since === null) return;
    up((performance.now() - since) / 1000);
    since = null;
  };
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    begin(event);
    for (const name of ["pointerup", "pointercancel"]) document.addEventListener(name, end, { once: true });
  });
  button.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    if (!event.repeat) begin();
  });
  button.addEventListener("keyup", (event) => {
    if (event.key === "Enter" || event.key === " ") end();
  });
  button.addEventListener("blur", end);
  button.addEventListener("click", (event) => {
    if (event.detail !== 0 || event.pointerId > 0) return; // the pointer events have handled it
    begin();
    end();
  });
}

function section(title, ...children) {
  return element("section", { "aria-label": title }, element("h2", {}, title), ...children);
}

const KEYS = { ArrowUp: "up", ArrowDown: "down", ArrowLeft: "left", ArrowRight: "right" };
const KEY_ORDER = ["left", "up", "down", "right", "select"];
const KEY_TEXTS = { left: "◀ LEFT", up: "▲ UP", down: "▼ DOWN", right: "RIGHT ▶", select: "SELECT" };

function showRows(lcd, rows) {
  const text = rows.join("\n");
  if (lcd.textContent === text) return;
  lcd.textContent = text;
  lcd.setAttribute("aria-label", `Display: ${rows.map((row) => row.trim()).join(", ")}`);
}

// The panel of a kind that another package provides: it shows only rows of text.
function outside(about) {
  const lcd = element("pre", { class: "lcd", role: "img" });
  return { panel: section(about.kind, lcd), show(state) { showRows(lcd, state.rows ?? []); } };
}

function lcdKeypad(about, order) {
  const lcd = element("pre", { class: "lcd", role: "img" });
  const buttons = {};
  const keys = element("div", { class: "keys", role: "group", "aria-label": "Keys" });
  const press = (key, more) => order({ do: "at", interface: about.number, key, ...more });
  for (const key of KEY_ORDER) {
    const button = element("button", { type: "button" }, KEY_TEXTS[key]);
    holdable(button, () => press(key, { down: true }), (held_s) => press(key, { down: false, held_s }));
    buttons[key] = button;
    keys.append(button);
  }
  keys.addEventListener("keydown", (event) => {
    const key = KEYS[event.key];
    if (!key) return;
    event.preventDefault();
    if (!event.repeat) {
      press(key, { down: true });
      const since = performance.now();
      const end = (released) => {
        if (released.key !== event.key) return;
        document.removeEventListener("keyup", end);
        press(key, { down: false, held_s: (performance.now() - since) / 1000 });
      };
      document.addEventListener("keyup", end);
    }
  });
  const panel = section("Display and keys", lcd, keys,
    element("p", { class: "soft" }, "With a key in focus, the arrow keys press UP, DOWN, LEFT and RIGHT."));
  return {
    panel,
    show(state) {
      showRows(lcd, state.rows);
      for (const [key, button] of Object.entries(buttons)) button.classList.toggle("on", state.held === key);
    },
  };
}

function nextion(about, order) {
  const picture = element("img", { alt: "Touch display", draggable: "false" });
  const screen = element("div", { class: "screen" }, picture);
  screen.style.aspectRatio = `${about.width} / ${about.height}`;
  const texts = element("p", { class: "soft" });
  let drawn = 0;
  let touchable = "";
  const touch = (more) => order({ do: "at", interface: about.number, ...more });
  const spot = (event) => {
    const box = screen.getBoundingClientRect();
    const share = (at, from, size, pixels) => Math.min(pixels - 1, Math.max(0, Math.floor(((at - from) / size) * pixels)));
    return { x: share(event.clientX, box.left, box.width, about.width), y: share(event.clientY, box.top, box.height, about.height) };
  };
  const lift = () => touch({ down: false });
  holdable(picture, (event) => event && touch({ ...spot(event), down: true }), lift);
  const place = (part) => {
    const button = element("button", { type: "button", "data-name": part.name }, part.text);
    const share = (value, whole) => `${(100 * value) / whole}%`;
    button.style.left = share(part.x, about.width);
    button.style.top = share(part.y, about.height);
    button.style.width = share(part.w, about.width);
    button.style.height = share(part.h, about.height);
    holdable(button, (event) => touch({ ...(event ? spot(event) : { name: part.name }), down: true }), lift);
    return button;
  };
  return {
    panel: section("Touch display", screen, texts),
    show(state) {
      const fresh = JSON.stringify(state.touchable);
      if (fresh !== touchable) {
        touchable = fresh;
        const focused = document.activeElement?.dataset?.name;
        screen.replaceChildren(picture, ...state.touchable.map(place));
        if (focused) screen.querySelector(`[data-name="${focused}"]`)?.focus();
      }
      texts.textContent = state.page ? `Page ${state.page}` : "The display is dark.";
      picture.alt = state.page ? `Page ${state.page}: ${state.texts.join(", ")}` : "The display is dark";
    },
    pictured(version) {
      if (version === drawn) return;
      drawn = version;
      picture.src = `display/${about.number}.png?${version}`;
    },
  };
}

const MOST_SHOWN = 500;

// Appends lines to a list, and scrolls to its end, unless the user has scrolled up.
export function roll(list, lines, write) {
  const follows = list.scrollTop + list.clientHeight >= list.scrollHeight - 4;
  for (const line of lines.slice(-MOST_SHOWN)) {
    const item = write(line);
    if (item) list.append(item);
  }
  while (list.children.length > MOST_SHOWN) list.firstChild.remove();
  if (follows) list.scrollTop = list.scrollHeight;
}

export const moment = (seconds) => element("span", { class: "at" }, `${seconds.toFixed(2)} s `);

function terminal(title, about, order) {
  const list = element("ol", { class: "roll", tabindex: "0", "aria-label": `${title}: lines` });
  const parts = [list];
  const polls = element("input", { type: "checkbox" });
  if (about.types) {
    const typed = [];
    let back = 0;
    const id = `type-${about.number}`;
    const input = element("input", {
      id, type: "text", autocomplete: "off", spellcheck: "false", list: `${id}-hints`, "aria-label": `${title}: type a line`,
    });
    const hints = element("datalist", { id: `${id}-hints` }, ...about.hints.map((value) => element("option", { value })));
    const form = element("form", {
      class: "prompt",
      onsubmit: (event) => {
        event.preventDefault();
        if (!input.value.trim()) return;
        order({ do: "at", interface: about.number, line: input.value });
        typed.push(input.value);
        back = typed.length;
        input.value = "";
      },
    }, input, hints, element("button", {}, "Send"));
    input.addEventListener("keydown", (event) => {
      if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
      back = Math.min(typed.length, Math.max(0, back + (event.key === "ArrowUp" ? -1 : 1)));
      input.value = typed[back] ?? "";
      event.preventDefault();
    });
    parts.push(form);
  }
  if (about.polls) {
    parts.push(element("label", { class: "check soft" }, polls, "Show the requests that the host repeats by itself"));
  }
  return {
    panel: section(title, ...parts),
    show() {},
    took(lines) {
      roll(list, lines, ([time, sent, text, byItself]) => byItself && !polls.checked ? null :
        element("li", sent ? {} : { class: "mine" }, moment(time), sent ? text : `> ${text}`));
    },
  };
}

const TABLES = { coil: "coil", discrete_input: "discrete input", holding_register: "holding register", input_register: "input register" };
const COMMANDS = ["acknowledge", "store", "restore"];

function modbus(about, order) {
  const cells = {};
  const write = (name, value) => order({ do: "at", interface: about.number, name, value });
  const control = (register) => {
    if (!register.writable) return "";
    if (COMMANDS.includes(register.name)) {
      return element("button", { type: "button", "aria-label": `${register.name}: do`, onclick: () => write(register.name, true) }, "Do");
    }
    if (register.kind === "bit") {
      return element("form", { onsubmit: (event) => event.preventDefault() }, ...[["On", true], ["Off", false]].map(([text, value]) =>
        element("button", { type: "button", "aria-label": `${register.name}: ${text}`, onclick: () => write(register.name, value) }, text)));
    }
    const input = element("input", { type: "number", step: "any", "aria-label": `${register.name}${register.unit ? `, ${register.unit}` : ""}` });
    return element("form", {
      onsubmit: (event) => {
        event.preventDefault();
        if (input.value !== "") write(register.name, Number(input.value));
      },
    }, input, element("button", { "aria-label": `${register.name}: write` }, "Write"));
  };
  const rows = about.registers.map((register) => {
    const value = element("td", { class: "number" }, "–");
    cells[register.name] = value;
    return element("tr", {}, element("th", { scope: "row" }, register.name),
      element("td", {}, `${TABLES[register.table]} ${register.address}`), value,
      element("td", { class: "number" }, control(register)));
  });
  const heads = ["name", "place", "value", "write"].map((text) => element("th", { scope: "col" }, text));
  const table = element("table", {}, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...rows));
  const refused = element("p", { class: "soft", role: "status" });
  const read = element("button", { type: "button", onclick: () => order({ do: "at", interface: about.number, read: true }) }, "Read all");
  return {
    panel: section("Modbus registers", element("p", { class: "row" }, read, element("span", { class: "soft" }, "The master polls the input registers by itself.")),
      element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Registers" }, table), refused),
    show(state) {
      for (const [name, value] of Object.entries(state.values)) {
        const text = Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(7)));
        if (cells[name] && cells[name].textContent !== text) cells[name].textContent = text;
      }
      const last = state.refused.at(-1);
      refused.textContent = last ? `At ${last.time_s.toFixed(1)} s the slave refused ${last.name} (exception ${last.code}).` : "";
    },
  };
}

function indicators() {
  const list = element("ul", { class: "leds" });
  return {
    panel: section("LEDs", list),
    show(state) {
      while (list.children.length < state.leds.length) {
        list.append(element("li", {}, element("i", { "aria-hidden": "true" }), element("span")));
      }
      state.leds.forEach((led, number) => {
        const [lamp, text] = list.children[number].children;
        lamp.classList.toggle("bright", led.bright);
        const said = `${led.meaning} (${led.pin}): ${led.light}`;
        if (text.textContent !== said) text.textContent = said;
      });
    },
  };
}

const KINDS = {
  lcd_keypad: lcdKeypad,
  nextion,
  gcode: (about, order) => terminal("G-code", about, order),
  serial_log: (about, order) => terminal("Log", about, order),
  serial_plotter: (about, order) => terminal("Plotter", about, order),
  modbus_rtu: modbus,
  indicators,
};

// The panel of an interface: {panel, show(state)}; some kinds also have took(lines), pictured(version).
export function panelOf(about, order) {
  return (KINDS[about.kind] ?? outside)(about, order);
}
