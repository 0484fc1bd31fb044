"use strict";
// The data of the page, and what all its figures share: colours, labels, tables.

const page = JSON.parse(document.getElementById("data").textContent);

// The quantity on the map, the axes across and up, a position on every axis, and rows marked.
const view = { quantity: 0, x: 0, y: 1, at: page.axes.map(() => 0), brushed: null };

const NARROW = 640; // width of a window, in pixels, below which figures are laid out for a phone
const MOST_ROWS = 500; // largest number of rows of the table under a figure

// --- Packed numbers ---

const NUMBERS = { f4: [Uint32Array, Float32Array], f8: [BigUint64Array, Float64Array] };

// Returns packed numbers as an array, and keeps them: base64 of deflated little-endian numbers, of
// which "u1" are classes, "f4" and "f8" numbers as `_encoded_steps` of `data.py` writes them.
async function unpack(packed) {
  if (packed.values) {
    return packed.values;
  }
  const bytes = Uint8Array.from(atob(packed.data), (sign) => sign.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const content = new Uint8Array(await new Response(stream).arrayBuffer());
  const isClasses = packed.type === "u1";
  packed.values = isClasses ? Float32Array.from(content) : joinSteps(content, packed.type);
  packed.data = null;
  return packed.values;
}

// Returns numbers from the differences of their bits, all first bytes of which come first.
function joinSteps(content, type) {
  const [Bits, Numbers] = NUMBERS[type];
  const size = Bits.BYTES_PER_ELEMENT;
  const count = content.length / size;
  const ordered = new Uint8Array(content.length);
  for (let byte = 0; byte < size; byte += 1) {
    for (let at = 0; at < count; at += 1) {
      ordered[at * size + byte] = content[byte * count + at];
    }
  }
  const bits = new Bits(ordered.buffer);
  for (let at = 1; at < count; at += 1) {
    bits[at] += bits[at - 1]; // beyond the largest whole number it goes on from 0
  }
  return new Numbers(ordered.buffer);
}

// --- Elements of the page ---

// Returns the element with an id.
function byId(id) {
  return document.getElementById(id);
}

// Makes an element; attributes such as "onclick" add a listener, null and false are left out.
function make(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) {
      element.addEventListener(key.slice(2), value);
    } else if (value !== null && value !== false) {
      element.setAttribute(key, value === true ? "" : value);
    }
  }
  element.append(...children);
  return element;
}

// Makes a list to choose from; `change` is called with the index of the choice.
function makeSelect(label, options, selected, change) {
  const list = make("select", { onchange: (event) => change(Number(event.target.value)) });
  options.forEach((text, index) => {
    list.append(make("option", { value: index, selected: index === selected }, text));
  });
  return make("label", {}, label, list);
}

// Says at the top that something could not be drawn.
function showFault(fault) {
  const hint = "Its tables are in the run's folder.";
  byId("fault").textContent = `This page could not be drawn: ${fault.message}. ${hint}`;
  console.error(fault);
}

// --- Numbers and names as texts ---

// Returns a number with five digits.
function formatNumber(value) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(5))) : "none";
}

// Returns a number with its unit, which may be empty.
function formatWithUnit(value, unit) {
  const text = formatNumber(value);
  return Number.isFinite(value) && unit ? `${text} ${unit}` : text;
}

// Returns the label of a class, and "none" for a value that is not a number.
function classLabel(classes, value) {
  return (classes[value] || { label: "none" }).label;
}

// Returns the label of an axis or a quantity, with its unit.
function titleOf(column) {
  return column.unit ? `${column.label} (${column.unit})` : column.label;
}

// --- Axes and cells ---

// Returns the values along an axis: names or numbers.
function ticksOf(axis) {
  return axis.names || axis.values;
}

// Returns true if there is nothing between two values of an axis: names, and listed numbers.
function isListed(axis) {
  return axis.is_list;
}

// Returns how points along an axis are drawn: only those of a range are joined.
function modeAlong(axis) {
  return isListed(axis) ? "markers" : "lines+markers";
}

function lengthOf(axis) {
  return ticksOf(axis).length;
}

// Returns one value of an axis as a text.
function valueText(axis, index) {
  return axis.names ? axis.names[index] : formatWithUnit(axis.values[index], axis.unit);
}

// Returns the product of the lengths of some axes.
function cellsOf(axes) {
  return axes.reduce((product, axis) => product * lengthOf(axis), 1);
}

// Cells from one value of each axis to the next: the last axis is the fastest.
const strides = page.axes.map((_, at) => cellsOf(page.axes.slice(at + 1)));

// Returns the cell at a position on every axis.
function cellAt(position) {
  return position.reduce((sum, index, axis) => sum + index * strides[axis], 0);
}

// Returns the index of a cell along one axis.
function indexAlong(axis, cell) {
  return Math.floor(cell / strides[axis]) % lengthOf(page.axes[axis]);
}

// Returns the position of a cell on every axis.
function positionOf(cell) {
  return page.axes.map((_, axis) => indexAlong(axis, cell));
}

// --- Figures ---

// Returns a colour of the page's style by its name.
function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

function isNarrow() {
  return window.innerWidth < NARROW;
}

// Returns the layout of a figure in the page's colours; `more` is its own layout.
function layout(more) {
  const axis = {
    gridcolor: colour("line"),
    zerolinecolor: colour("line"),
    linecolor: colour("line"),
    automargin: true,
  };
  return {
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { color: colour("text"), family: "inherit", size: 13 },
    margin: { l: 64, r: 16, t: 34, b: 52 },
    hoverlabel: { bgcolor: colour("panel"), font: { color: colour("text") } },
    // Below the title of the axis, however long the names of its ticks are.
    legend: { orientation: "h", yref: "container", y: 0, yanchor: "bottom" },
    ...more,
    xaxis: { ...axis, ...(more.xaxis || {}) },
    yaxis: { ...axis, ...(more.yaxis || {}) },
  };
}

const redraws = new Map(); // functions that draw each figure again when the colours change, by id

// No button leads out of the page: nothing is uploaded, and there is no server to upload it to.
const settings = {
  displaylogo: false,
  responsive: true,
  showSendToCloud: false,
  plotlyServerURL: "",
  showTips: false,
  modeBarButtonsToRemove: ["lasso2d", "autoScale2d", "sendChartToCloud"],
};

// Returns what a figure has with its texts as they stand: Plotly reads tags in them, but names of
// parts and conditions are the user's. A template has tags of the page's own.
function withPlainTexts(given, key = "") {
  if (typeof given === "string" && key !== "hovertemplate") {
    return given.replace(/&/g, "&amp;").replace(/</g, "&lt;");
  }
  if (Array.isArray(given)) {
    return typeof given[0] === "number" ? given : given.map((item) => withPlainTexts(item));
  }
  if (given && given.constructor === Object) {
    const entries = Object.entries(given).map(([name, item]) => [name, withPlainTexts(item, name)]);
    return Object.fromEntries(entries);
  }
  return given;
}

// Draws a figure. An axis is its title or a Plotly axis; `again` draws the figure anew.
async function drawFigure(id, again, traces, title, x, y, more = {}) {
  redraws.set(id, again);
  const asAxis = (given) => (typeof given === "string" ? { title: { text: given } } : given);
  const ownLayout = {
    title: { text: title, x: 0.02, font: { size: 14 } },
    xaxis: asAxis(x),
    yaxis: asAxis(y),
    ...more,
  };
  const shown = withPlainTexts([traces, layout(ownLayout)]);
  await Plotly.react(byId(id), ...shown, settings);
}

// The layout of a figure that is empty, with a sentence in its middle that says why.
function saying(sentence) {
  const middle = { xref: "paper", yref: "paper", x: 0.5, y: 0.5, showarrow: false };
  return { annotations: [{ ...middle, text: sentence, font: { size: 14 } }] };
}

// Lets the numbers of a figure be read as a table; `rows` returns them when it is opened.
function fillTable(id, heads, rows) {
  const details = byId(`${id}-table`);
  const fill = () => {
    if (!details.open) {
      return;
    }
    const headCells = heads.map((text) => make("th", { scope: "col" }, text));
    const allRows = rows();
    const body = allRows.slice(0, MOST_ROWS).map((row) => {
      const cells = row.map((text) => make("td", {}, String(text)));
      return make("tr", {}, ...cells);
    });
    const head = make("thead", {}, make("tr", {}, ...headCells));
    const contents = [make("table", {}, head, make("tbody", {}, ...body))];
    if (allRows.length > MOST_ROWS) {
      const note = `The first ${MOST_ROWS} of ${allRows.length} rows.`;
      contents.push(make("p", {}, note));
    }
    details.querySelector(".rows").replaceChildren(...contents);
  };
  details.ontoggle = fill;
  fill();
}
