"use strict";
// The data of the page, and what all its figures share: colours, labels, tables.

const page = JSON.parse(document.getElementById("data").textContent);
const view = { quantity: 0, x: 0, y: 1, at: page.axes.map(() => 0), brushed: null };

// Packed numbers: base64 of deflated little-endian numbers; "u1" holds classes, "u2" steps from `low`, 65535 where there is none.
async function unpack(packed) {
  if (packed.values) return packed.values;
  const bytes = Uint8Array.from(atob(packed.data), (sign) => sign.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  if (packed.type === "u1") packed.values = Float32Array.from(new Uint8Array(buffer));
  else if (packed.type === "f4") packed.values = new Float32Array(buffer);
  else packed.values = Float32Array.from(new Uint16Array(buffer), (step) => (step === 65535 ? NaN : packed.low + packed.step * step));
  packed.data = null;
  return packed.values;
}

function make(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== null && value !== false) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

const place = (id) => document.getElementById(id);
const number = (value) => (Number.isFinite(value) ? String(Number(value.toPrecision(5))) : "none");
const withUnit = (value, unit) => (Number.isFinite(value) && unit ? `${number(value)} ${unit}` : number(value));
const classOf = (kinds, value) => (kinds[value] || { label: "none" }).label;
const named = (thing) => (thing.unit ? `${thing.label} [${thing.unit}]` : thing.label);
const valueOf = (axis, index) => (axis.names ? axis.names[index] : withUnit(axis.values[index], axis.unit));
const lengthOf = (axis) => (axis.names || axis.values).length;
const strides = page.axes.map((_, at) => page.axes.slice(at + 1).reduce((product, axis) => product * lengthOf(axis), 1));
const cellAt = (at) => at.reduce((sum, index, axis) => sum + index * strides[axis], 0);
const positionOf = (cell) => page.axes.map((axis, at) => Math.floor(cell / strides[at]) % lengthOf(axis));

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

const narrow = () => window.innerWidth < 640;

function layout(more) {
  const axis = { gridcolor: colour("line"), zerolinecolor: colour("line"), linecolor: colour("line"), automargin: true };
  const base = {
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { color: colour("text"), family: "inherit", size: 13 },
    margin: { l: 64, r: 16, t: 34, b: 52 },
    hoverlabel: { bgcolor: colour("panel"), font: { color: colour("text") } },
    legend: { orientation: "h", y: narrow() ? -0.4 : -0.25, yanchor: "top" },
    ...more,
  };
  for (const name of ["xaxis", "yaxis"]) base[name] = { ...axis, ...(more[name] || {}) };
  return base;
}

const drawn = new Map(); // what draws each figure again, when the colours change
// No button leads out of the page: nothing is uploaded, and there is no server to upload it to.
const settings = {
  displaylogo: false, responsive: true, showSendToCloud: false, plotlyServerURL: "", showTips: false,
  modeBarButtonsToRemove: ["lasso2d", "autoScale2d", "sendChartToCloud"],
};

// A figure with its title and the titles of its axes, or axes; `again` draws it anew.
async function draw(id, again, traces, title, x, y, more = {}) {
  drawn.set(id, again);
  const axis = (given) => (typeof given === "string" ? { title: { text: given } } : given);
  const texts = { title: { text: title, x: 0.02, font: { size: 14 } }, xaxis: axis(x), yaxis: axis(y) };
  await Plotly.react(place(id), traces, layout({ ...texts, ...more }), settings);
}

// The same numbers as a table, made when it is opened.
function asTable(id, heads, rows) {
  const details = place(`${id}-table`);
  const fill = () => {
    if (!details.open) return;
    const most = 500;
    const head = make("tr", {}, ...heads.map((text) => make("th", { scope: "col" }, text)));
    const given = rows();
    const body = given.slice(0, most).map((row) => make("tr", {}, ...row.map((text) => make("td", {}, String(text)))));
    const table = make("table", {}, make("thead", {}, head), make("tbody", {}, ...body));
    const rest = given.length > most ? [make("p", {}, `The first ${most} of ${given.length} rows.`)] : [];
    details.querySelector(".rows").replaceChildren(table, ...rest);
  };
  details.ontoggle = fill;
  fill();
}

function select(label, options, chosen, change) {
  const list = make("select", { onchange: (event) => change(Number(event.target.value)) });
  options.forEach((text, at) => list.append(make("option", { value: at, selected: at === chosen }, text)));
  return make("label", {}, label, list);
}
