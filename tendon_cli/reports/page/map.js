// The map: any quantity over any two axes, a slider for each of the others, and a cell cursor for mouse and keyboard.

const cursor = { i: 0, j: 0 };
const mapped = { z: [], values: null };

const chosen = () => page.quantities[view.quantity];
const others = () => page.axes.map((_, at) => at).filter((at) => at !== view.x && at !== view.y);
const hasMap = () => page.axes.length > 0 && page.quantities.length > 0;
const isLine = () => view.y >= page.axes.length;
const rowsOfMap = () => (isLine() ? 1 : lengthOf(page.axes[view.y]));

function cellOf(i, j) {
  const at = [...view.at];
  at[view.x] = i;
  if (!isLine()) at[view.y] = j;
  return cellAt(at);
}

const along = (axis) => axis.names || axis.values;

function sliced() {
  const [length, start, dx, dy] = [lengthOf(page.axes[view.x]), cellOf(0, 0), strides[view.x], isLine() ? 0 : strides[view.y]];
  const row = (j) => Float32Array.from({ length }, (_, i) => mapped.values[start + j * dy + i * dx]);
  mapped.z = Array.from({ length: rowsOfMap() }, (_, j) => row(j));
}

function heat() {
  const quantity = chosen();
  const [x, y] = [page.axes[view.x], page.axes[view.y]];
  const trace = { type: "heatmap", x: along(x), y: along(y), z: mapped.z, hoverongaps: true, zsmooth: false };
  trace.hovertemplate = `${x.label} %{x}<br>${y.label} %{y}<br>${quantity.label} %{z:.5g} ${quantity.unit}<extra></extra>`;
  const bar = { title: { text: quantity.unit }, ...(narrow() ? { orientation: "h", y: -0.28, yanchor: "top", thickness: 12 } : {}) };
  const single = quantity.low === quantity.high; // needs no colour bar
  if (!quantity.classes) return { ...trace, colorscale: "Cividis", zmin: quantity.low - single, zmax: quantity.high + single, showscale: !single, colorbar: bar };
  const count = quantity.classes.length;
  const scale = quantity.classes.flatMap((kind, at) => [[at / count, colour(kind.colour)], [(at + 1) / count, colour(kind.colour)]]);
  trace.hovertemplate = `${x.label} %{x}<br>${y.label} %{y}<extra></extra>`; // the class is said below the map
  return { ...trace, colorscale: scale, zmin: -0.5, zmax: count - 0.5, showscale: false };
}

// Signs on a coarse grid of cells name a class without its colour.
function signs() {
  const quantity = chosen();
  if (!quantity.classes) return [];
  const [columns, rows] = [lengthOf(page.axes[view.x]), rowsOfMap()];
  const spread = (count, most) => Array.from({ length: Math.min(count, most) }, (_, k) => Math.floor(((k + 0.5) * count) / Math.min(count, most)));
  const [x, y, text] = [[], [], []];
  for (const j of spread(rows, 9)) {
    for (const i of spread(columns, narrow() ? 7 : 14)) {
      const at = mapped.z[j][i];
      if (!Number.isFinite(at)) continue;
      x.push(along(page.axes[view.x])[i]);
      y.push(along(page.axes[view.y])[j]);
      text.push(quantity.classes[at].sign);
    }
  }
  return [{ type: "scatter", mode: "text", x, y, text, textfont: { color: colour("on-class"), size: 12 }, hoverinfo: "skip", showlegend: false }];
}

// The key of the classes; a map of numbers has its colour bar.
function drawKey() {
  const item = (kind) => make("span", {}, make("span", { class: "swatch", style: `background: var(--${kind.colour})` }, kind.sign), ` ${kind.label} `);
  place("map-key").replaceChildren(...(chosen().classes || []).map(item));
}

const isOnMap = (row) => row < page.axes.reduce((product, axis) => product * lengthOf(axis), 1); // others lie between the points of the grid

function brushedCells() {
  if (!view.brushed || isLine()) return [];
  const hidden = others();
  const [x, y] = [[], []];
  for (const cell of view.brushed.filter(isOnMap)) {
    const at = positionOf(cell);
    if (hidden.some((axis) => at[axis] !== view.at[axis])) continue;
    x.push(along(page.axes[view.x])[at[view.x]]);
    y.push(along(page.axes[view.y])[at[view.y]]);
  }
  const marker = { symbol: "square-open", size: 11, color: colour("mark"), line: { width: 2 } };
  return [{ type: "scatter", mode: "markers", x, y, marker, hoverinfo: "skip", showlegend: false, name: "brushed" }];
}

function lineOfMap() {
  const { classes } = chosen();
  const y = Array.from(mapped.z[0], (at) => (!classes ? at : Number.isFinite(at) ? classes[at].label : null));
  return { type: "scatter", mode: "lines+markers", x: along(page.axes[view.x]), y, line: { color: colour("flexor") } };
}

// The frame of a cell where it is drawn, or the place on a line.
function cursorShape() {
  const [drawn] = place("map").calcdata[0];
  const line = { color: colour("mark"), width: 3 };
  if (isLine()) {
    const x = place("map").calcdata[0][cursor.i].x;
    return [{ type: "line", xref: "x", yref: "paper", x0: x, x1: x, y0: 0, y1: 1, line }];
  }
  return [{ type: "rect", x0: drawn.x[cursor.i], x1: drawn.x[cursor.i + 1], y0: drawn.y[cursor.j], y1: drawn.y[cursor.j + 1], line }];
}

const axisOf = (axis) => ({ title: { text: named(axis) }, type: axis.names ? "category" : axis.is_log ? "log" : "linear" });

async function drawMap() {
  mapped.values = await unpack(chosen().array);
  sliced();
  const traces = isLine() ? [lineOfMap()] : [heat(), ...signs(), ...brushedCells()];
  const y = isLine() ? named(chosen()) : { ...axisOf(page.axes[view.y]), showgrid: false };
  const more = narrow() && !chosen().classes ? { margin: { l: 56, r: 8, t: 34, b: 96 } } : {};
  drawKey();
  await draw("map", drawMap, traces, named(chosen()), { ...axisOf(page.axes[view.x]), showgrid: false }, y, more);
  asTable("map", [...shownAxes().map(named), named(chosen())], tabled);
  moveCursor(cursor.i, cursor.j);
}

const shownAxes = () => (isLine() ? [page.axes[view.x]] : [page.axes[view.x], page.axes[view.y]]);

function tabled() {
  const { classes } = chosen();
  const places = (i, j) => shownAxes().map((axis, at) => valueOf(axis, [i, j][at]));
  return mapped.z.flatMap((row, j) => Array.from(row, (value, i) => [...places(i, j), classes ? classOf(classes, value) : number(value)]));
}

function say(cell = cellOf(cursor.i, cursor.j)) {
  const value = mapped.values[cell];
  const quantity = chosen();
  const where = page.axes.map((axis, at) => `${axis.label} ${valueOf(axis, positionOf(cell)[at])}`);
  const what = quantity.classes ? classOf(quantity.classes, value) : withUnit(value, quantity.unit);
  place("map-says").textContent = `${where.join(", ")}: ${quantity.label} ${what}`;
}

function moveCursor(i, j) {
  cursor.i = Math.min(Math.max(i, 0), lengthOf(page.axes[view.x]) - 1);
  cursor.j = Math.min(Math.max(j, 0), rowsOfMap() - 1);
  Plotly.relayout(place("map"), { shapes: cursorShape() });
  say();
}

const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

function onKey(event) {
  if (KEYS[event.key]) {
    const far = event.shiftKey ? 10 : 1;
    moveCursor(cursor.i + far * KEYS[event.key][0], cursor.j + far * KEYS[event.key][1]);
  } else if (event.key === "Enter") showDesign(cellOf(cursor.i, cursor.j));
  else return;
  event.preventDefault();
}

function sliders() {
  const boxes = others().map((at) => {
    const axis = page.axes[at];
    const shows = make("output", {}, valueOf(axis, view.at[at]));
    const input = make("input", { type: "range", min: 0, max: lengthOf(axis) - 1, value: view.at[at], "aria-label": named(axis), "aria-valuetext": valueOf(axis, view.at[at]) });
    input.addEventListener("input", () => {
      view.at[at] = Number(input.value);
      shows.textContent = valueOf(axis, view.at[at]);
      input.setAttribute("aria-valuetext", shows.textContent);
      redraw();
      moveStates(at, view.at[at]);
    });
    return make("label", { class: "slider" }, `${axis.label} `, input, shows);
  });
  place("sliders").replaceChildren(...boxes);
}

function choosers() {
  const names = page.axes.map((axis) => axis.label);
  const take = (which, other) => (at) => {
    if (view[other] === at) view[other] = view[which];
    view[which] = at;
    cursor.i = cursor.j = 0;
    choosers();
    sliders();
    redraw();
  };
  const boxes = [select("Show ", page.quantities.map((quantity) => quantity.label), view.quantity, (at) => { view.quantity = at; redraw(); })];
  if (page.axes.length > 1) boxes.push(select("across ", names, view.x, take("x", "y")), select("up ", names, view.y, take("y", "x")));
  place("choosers").replaceChildren(...boxes);
}

let waiting = false;
function redraw() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(async () => {
    waiting = false;
    await drawMap();
    if (place("windows")) drawWindows();
  });
}

async function startMap() {
  if (!hasMap()) return;
  view.at = page.start || view.at;
  [cursor.i, cursor.j] = [view.at[view.x], isLine() ? 0 : view.at[view.y]];
  choosers();
  sliders();
  await drawMap();
  const frame = place("map-frame");
  frame.addEventListener("keydown", onKey);
  const under = (event, use) => {
    const point = event.points.find((each) => each.data.type === "heatmap" || page.axes.length === 1);
    if (!point) return;
    const [j, i] = Array.isArray(point.pointIndex) ? point.pointIndex : [0, point.pointIndex];
    use(i, j);
  };
  place("map").on("plotly_hover", (event) => under(event, (i, j) => say(cellOf(i, j))));
  place("map").on("plotly_unhover", () => say());
  place("map").on("plotly_click", (event) => under(event, (i, j) => { moveCursor(i, j); showDesign(cellOf(i, j)); }));
}
