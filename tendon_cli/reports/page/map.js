// The map: any quantity over any two axes, a slider for each of the other axes, and a cell cursor
// for mouse and keyboard. With one axis it is a line.

const cursor = { i: 0, j: 0 };
// Colours of numbers: dark is more, and a negative margin is orange, as in the figures.
const BLUES = [
  [0, "#d1e6f2"],
  [0.33, "#69acd2"],
  [0.67, "#0072b2"],
  [1, "#003f62"],
];
const SIGNED = [
  [0, "#753400"],
  [0.17, "#d55e00"],
  [0.33, "#e6a06b"],
  [0.48, "#f7e2d1"],
  [0.5, "#f7f6f4"],
  [0.52, "#d1e6f2"],
  [0.67, "#69acd2"],
  [0.83, "#0072b2"],
  [1, "#003f62"],
];

const mapped = { z: [], values: null }; // the rows of the map, and all values of its quantity

// --- What is on the map ---

function hasMap() {
  return page.axes.length > 0 && page.quantities.length > 0;
}

// True if the map is a line, since there is no axis to go up.
function isLine() {
  return view.y >= page.axes.length;
}

function quantityOnMap() {
  return page.quantities[view.quantity];
}

function axisAcross() {
  return page.axes[view.x];
}

function axisUp() {
  return page.axes[view.y];
}

function shownAxes() {
  return isLine() ? [axisAcross()] : [axisAcross(), axisUp()];
}

// Returns the numbers of the axes that have a slider.
function hiddenAxes() {
  const all = page.axes.map((_, axis) => axis);
  return all.filter((axis) => axis !== view.x && axis !== view.y);
}

function rowsOfMap() {
  return isLine() ? 1 : lengthOf(axisUp());
}

// Returns the cell of the table at a place on the map.
function cellOf(i, j) {
  const position = [...view.at];
  position[view.x] = i;
  if (!isLine()) {
    position[view.y] = j;
  }
  return cellAt(position);
}

// Returns true if a row of the table is a point of the grid; other choices lie between its points.
function isOnMap(row) {
  return row < cellsOf(page.axes);
}

// Cuts the rows of the map out of the values of its quantity.
function cutMap() {
  const length = lengthOf(axisAcross());
  const start = cellOf(0, 0);
  const dx = strides[view.x];
  const dy = isLine() ? 0 : strides[view.y];
  const valueAt = (i, j) => mapped.values[start + j * dy + i * dx];
  const row = (j) => Float32Array.from({ length }, (_, i) => valueAt(i, j));
  mapped.z = Array.from({ length: rowsOfMap() }, (_, j) => row(j));
}

// --- What is drawn ---

// Returns the trace under the map: one colour for all cells, seen where a quantity has no value. It
// also gives the cells of a map without any value their edges.
function emptyTrace() {
  const x = axisAcross();
  const y = axisUp();
  const none = colour("none");
  return {
    type: "heatmap",
    x: ticksOf(x),
    y: ticksOf(y),
    z: mapped.z.map((row) => Array.from(row, () => 0)),
    colorscale: [
      [0, none],
      [1, none],
    ],
    showscale: false,
    zsmooth: false,
    hovertemplate: `${x.label} %{x}<br>${y.label} %{y}<br>${quantityOnMap().none}<extra></extra>`,
  };
}

// Returns the trace of the map: a colour for each cell that has a value.
function heatTrace() {
  const quantity = quantityOnMap();
  const x = axisAcross();
  const y = axisUp();
  const places = `${x.label} %{x}<br>${y.label} %{y}<br>`;
  const trace = {
    type: "heatmap",
    x: ticksOf(x),
    y: ticksOf(y),
    z: mapped.z,
    hoverongaps: false,
    zsmooth: false,
    hovertemplate: `${places}${quantity.label} %{z:.5g} ${quantity.unit}<extra></extra>`,
  };
  if (quantity.classes) {
    return { ...trace, ...classColours(x, y, quantity.classes) };
  }
  const bar = { title: { text: quantity.unit } };
  if (isNarrow()) {
    Object.assign(bar, { orientation: "h", y: 1.02, yanchor: "bottom", thickness: 12 });
  }
  const hasNone = quantity.low === null;
  const isSigned = quantity.name === "margin" && quantity.low < 0;
  const most = Math.max(Math.abs(quantity.low), Math.abs(quantity.high));
  const isSingle = quantity.low === quantity.high; // one value, or none, needs no colour bar
  const beside = isSingle ? 1 : 0;
  return {
    ...trace,
    colorscale: isSigned ? SIGNED : BLUES,
    visible: !hasNone,
    zmin: isSigned ? -most : quantity.low - beside,
    zmax: isSigned ? most : quantity.high + beside,
    showscale: !isSingle,
    colorbar: bar,
  };
}

// Returns the colours of a trace of classes: a band of one colour for each class.
function classColours(x, y, classes) {
  const count = classes.length;
  const scale = classes.flatMap((kind, index) => [
    [index / count, kind.colour],
    [(index + 1) / count, kind.colour],
  ]);
  return {
    colorscale: scale,
    zmin: -0.5,
    zmax: count - 0.5,
    showscale: false,
    // The class is named below the map.
    hovertemplate: `${x.label} %{x}<br>${y.label} %{y}<extra></extra>`,
  };
}

// Returns at most `most` indices, spread evenly over an axis of `count` values.
function spread(count, most) {
  const length = Math.min(count, most);
  return Array.from({ length }, (_, k) => Math.floor(((k + 0.5) * count) / length));
}

// Returns signs on a coarse grid of cells, which show the classes without colours.
function signTraces() {
  const quantity = quantityOnMap();
  if (!quantity.classes) {
    return [];
  }
  const x = [];
  const y = [];
  const text = [];
  const inks = [];
  for (const j of spread(rowsOfMap(), 9)) {
    for (const i of spread(lengthOf(axisAcross()), isNarrow() ? 7 : 14)) {
      const kind = mapped.z[j][i];
      if (Number.isFinite(kind)) {
        x.push(ticksOf(axisAcross())[i]);
        y.push(ticksOf(axisUp())[j]);
        text.push(quantity.classes[kind].sign);
        inks.push(inkOn(quantity.classes[kind].colour));
      }
    }
  }
  return [
    {
      type: "scatter",
      mode: "text",
      x,
      y,
      text,
      textfont: { color: inks, size: 12 },
      hoverinfo: "skip",
      showlegend: false,
    },
  ];
}

// Returns frames around the marked rows that the map shows.
function brushTraces() {
  if (!view.brushed || isLine()) {
    return [];
  }
  const hidden = hiddenAxes();
  const x = [];
  const y = [];
  for (const cell of view.brushed.filter(isOnMap)) {
    const position = positionOf(cell);
    if (hidden.every((axis) => position[axis] === view.at[axis])) {
      x.push(ticksOf(axisAcross())[position[view.x]]);
      y.push(ticksOf(axisUp())[position[view.y]]);
    }
  }
  const marker = { symbol: "square-open", size: 11, color: colour("mark"), line: { width: 2 } };
  return [
    {
      type: "scatter",
      mode: "markers",
      x,
      y,
      marker,
      hoverinfo: "skip",
      showlegend: false,
      name: "brushed",
    },
  ];
}

// Returns the trace of a map that is a line; classes are drawn by their names.
function lineTrace() {
  const { classes } = quantityOnMap();
  let y = Array.from(mapped.z[0]);
  if (classes) {
    y = y.map((kind) => (Number.isFinite(kind) ? classes[kind].label : null));
  }
  return {
    type: "scatter",
    mode: modeAlong(axisAcross()),
    x: ticksOf(axisAcross()),
    y,
    line: { color: colour("flexor") },
    marker: { color: colour("flexor") },
  };
}

// Returns the shape of the cursor: a frame around its cell, or an upright line if the map is one.
function cursorShape() {
  const points = byId("map").calcdata[0]; // of the first trace, which every map has
  const line = { color: colour("mark"), width: 3 };
  if (isLine()) {
    const x = points[cursor.i].x;
    return { type: "line", xref: "x", yref: "paper", x0: x, x1: x, y0: 0, y1: 1, line };
  }
  const edges = points[0];
  return {
    type: "rect",
    x0: edges.x[cursor.i],
    x1: edges.x[cursor.i + 1],
    y0: edges.y[cursor.j],
    y1: edges.y[cursor.j + 1],
    line,
  };
}

const LONGEST_NAME = 32; // signs of the name of a tick
const LONGEST_ON_PHONE = 11;
const MOST_NAMES = 40; // names that are all written

// Returns a name as a tick has it: on a phone without what is in brackets, and cut in its middle.
function tickName(name) {
  const most = isNarrow() ? LONGEST_ON_PHONE : LONGEST_NAME;
  const text = isNarrow() ? name.replace(/ \(.*\)$/, "") : name;
  const half = Math.floor(most / 2);
  return text.length > most ? `${text.slice(0, half)}…${text.slice(-half)}` : text;
}

// Returns an axis in the form that Plotly takes; listed values stand in cells of one size.
function plotlyAxis(axis) {
  const title = { text: titleOf(axis) };
  if (axis.names) {
    const isFew = axis.names.length <= MOST_NAMES;
    const ticks = { tickvals: axis.names, ticktext: axis.names.map(tickName) };
    return { title, type: "category", ...(isFew ? ticks : {}) };
  }
  if (isListed(axis)) {
    const ascending = [...axis.values].sort((first, second) => first - second);
    return { title, type: "category", categoryorder: "array", categoryarray: ascending };
  }
  return { title, type: axis.is_log ? "log" : "linear" };
}

// Returns black or white, whichever stands out from a colour such as "#d55e00" (WCAG 2).
function inkOn(shade) {
  const linear = (at) => {
    const share = parseInt(shade.slice(at, at + 2), 16) / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  };
  const luminance = 0.2126 * linear(1) + 0.7152 * linear(3) + 0.0722 * linear(5);
  return luminance > 0.18 ? "#000000" : "#ffffff";
}

// Makes an item of the key: a colour with a sign, and what it stands for.
function makeKeyItem({ colour: shade, sign, label }) {
  const ink = shade.startsWith("#") ? inkOn(shade) : "inherit";
  const style = `background: ${shade}; color: ${ink}`;
  const swatch = make("span", { class: "swatch", style }, sign);
  return make("span", {}, swatch, ` ${label} `);
}

// Writes the key of the classes, and of cells without a value; a map of numbers has a colour bar.
function drawKey() {
  const quantity = quantityOnMap();
  const items = (quantity.classes || []).map(makeKeyItem);
  const isEmpty = (row) => row.some((value) => !Number.isFinite(value));
  if (!quantity.classes && mapped.z.some(isEmpty)) {
    const label = isLine() ? `gaps: ${quantity.none}` : quantity.none;
    items.push(makeKeyItem({ colour: "var(--none)", sign: "–", label }));
  }
  byId("map-key").replaceChildren(...items);
}

// Returns the rows of the table under the map.
function mapAsRows() {
  const { classes } = quantityOnMap();
  const rows = [];
  mapped.z.forEach((values, j) => {
    values.forEach((value, i) => {
      const indices = [i, j];
      const places = shownAxes().map((axis, at) => valueText(axis, indices[at]));
      rows.push([...places, classes ? classLabel(classes, value) : formatNumber(value)]);
    });
  });
  return rows;
}

async function drawMap() {
  mapped.values = await unpack(quantityOnMap().array);
  cutMap();
  const title = titleOf(quantityOnMap());
  const x = { ...plotlyAxis(axisAcross()), showgrid: false };
  let traces = [];
  let y = title;
  if (isLine()) {
    traces = [lineTrace()];
  } else {
    traces = [emptyTrace(), heatTrace(), ...signTraces(), ...brushTraces()];
    y = { ...plotlyAxis(axisUp()), showgrid: false };
  }
  const more = {};
  if (isNarrow() && !quantityOnMap().classes) {
    // The colour bar stands where the title would, which the list above the map says.
    more.margin = { l: 56, r: 8, t: 52, b: 52 };
    more.title = { text: "" };
  }
  drawKey();
  await drawFigure("map", drawMap, traces, title, x, y, more);
  fillTable("map", [...shownAxes().map(titleOf), title], mapAsRows);
  moveCursor(cursor.i, cursor.j);
}

let isWaiting = false;

// Draws the map and the windows once, before the next picture, however often it is asked for.
function redraw() {
  if (isWaiting) {
    return;
  }
  isWaiting = true;
  requestAnimationFrame(async () => {
    isWaiting = false;
    try {
      await drawMap();
      if (byId("windows")) {
        await drawWindows();
      }
    } catch (fault) {
      showFault(fault);
    }
  });
}

// --- The cursor ---

// Returns a value of a quantity with its unit, or what it means that there is none.
function numberOrNone(value, quantity) {
  return Number.isFinite(value) ? formatWithUnit(value, quantity.unit) : quantity.none;
}

// Describes a cell below the map, by default that of the cursor.
function describeCell(cell = cellOf(cursor.i, cursor.j)) {
  const value = mapped.values[cell];
  const quantity = quantityOnMap();
  const position = positionOf(cell);
  const places = page.axes.map((axis, at) => `${axis.label} ${valueText(axis, position[at])}`);
  const text = quantity.classes
    ? classLabel(quantity.classes, value)
    : numberOrNone(value, quantity);
  byId("map-says").textContent = `${places.join(", ")}: ${quantity.label}: ${text}`;
}

// Puts the cursor where the position on all axes is.
function placeCursor() {
  cursor.i = view.at[view.x];
  cursor.j = isLine() ? 0 : view.at[view.y];
}

// Moves the cursor to a cell, or to the nearest on the map.
function moveCursor(i, j) {
  cursor.i = Math.min(Math.max(i, 0), lengthOf(axisAcross()) - 1);
  cursor.j = Math.min(Math.max(j, 0), rowsOfMap() - 1);
  view.at[view.x] = cursor.i;
  if (!isLine()) {
    view.at[view.y] = cursor.j;
  }
  Plotly.relayout(byId("map"), { shapes: [cursorShape()] });
  describeCell();
}

const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const FAR = 10; // cells that an arrow moves the cursor by, with the shift key

// Moves the cursor by the arrow keys; Enter shows the states of its cell.
function onKey(event) {
  if (KEYS[event.key]) {
    const [di, dj] = KEYS[event.key];
    const cells = event.shiftKey ? FAR : 1;
    moveCursor(cursor.i + cells * di, cursor.j + cells * dj);
  } else if (event.key === "Enter") {
    showDesign(cellOf(cursor.i, cursor.j));
  } else {
    return;
  }
  event.preventDefault();
}

// Calls `use` with the indices across and up of the cell that an event of Plotly is at, if any.
function withPlace(event, use) {
  const isOfMap = (point) => point.data.type === "heatmap" || page.axes.length === 1;
  const point = event.points.find(isOfMap);
  if (!point) {
    return;
  }
  const [j, i] = Array.isArray(point.pointIndex) ? point.pointIndex : [0, point.pointIndex];
  use(i, j);
}

// --- Controls ---

// Makes the slider of an axis.
function makeSlider(at) {
  const axis = page.axes[at];
  const text = valueText(axis, view.at[at]);
  const output = make("output", {}, text);
  const input = make("input", {
    type: "range",
    min: 0,
    max: lengthOf(axis) - 1,
    value: view.at[at],
    "aria-label": titleOf(axis),
    "aria-valuetext": text,
  });
  input.addEventListener("input", () => {
    view.at[at] = Number(input.value);
    output.textContent = valueText(axis, view.at[at]);
    input.setAttribute("aria-valuetext", output.textContent);
    redraw();
    moveStates(at, view.at[at]);
  });
  return make("label", { class: "slider" }, `${axis.label} `, input, output);
}

function drawSliders() {
  byId("sliders").replaceChildren(...hiddenAxes().map(makeSlider));
}

// Puts an axis across ("x") or up ("y"); the two swap if it was already the other one.
function chooseAxis(which, axis) {
  const other = which === "x" ? "y" : "x";
  if (view[other] === axis) {
    view[other] = view[which];
  }
  view[which] = axis;
  placeCursor();
  drawChoosers();
  drawSliders();
  redraw();
}

// Makes the lists of quantities and axes to choose from.
function drawChoosers() {
  const quantities = page.quantities.map((quantity) => quantity.label);
  const chooseQuantity = (index) => {
    view.quantity = index;
    redraw();
  };
  const lists = [makeSelect("Show ", quantities, view.quantity, chooseQuantity)];
  if (page.axes.length > 1) {
    const names = page.axes.map((axis) => axis.label);
    lists.push(makeSelect("across ", names, view.x, (axis) => chooseAxis("x", axis)));
    lists.push(makeSelect("up ", names, view.y, (axis) => chooseAxis("y", axis)));
  }
  byId("choosers").replaceChildren(...lists);
}

async function startMap() {
  if (!hasMap()) {
    return;
  }
  view.at = page.start || view.at;
  placeCursor();
  drawChoosers();
  drawSliders();
  await drawMap();
  byId("map-frame").addEventListener("keydown", onKey);
  const map = byId("map");
  map.on("plotly_hover", (event) => withPlace(event, (i, j) => describeCell(cellOf(i, j))));
  map.on("plotly_unhover", () => describeCell());
  map.on("plotly_click", (event) => {
    withPlace(event, (i, j) => {
      moveCursor(i, j);
      showDesign(cellOf(i, j));
    });
  });
}
