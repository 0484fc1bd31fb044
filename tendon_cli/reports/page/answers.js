// Figures of an answer: windows of pretension along an axis of choices, the front with its brush,
// the people left out, and the window over the motion.

// Returns the values of a column of the choices.
async function choiceValues(name) {
  return unpack(page.design.columns[name].array);
}

// Returns a bound on the pretension, N, as a text; "none" for null.
function boundText(value) {
  return value === null ? "none" : formatNumber(value);
}

// Returns the bars from the lower to the upper ends of windows, for the trace of the lower ones.
function barsBetween(low, high) {
  const array = low.map((end, i) => (end === null ? 0 : high[i] - end));
  const arrayminus = low.map(() => 0);
  const bar = { color: colour("band"), thickness: 8, width: 0 };
  return { error_y: { type: "data", symmetric: false, array, arrayminus, ...bar } };
}

// --- Windows of pretension along the axis across the map ---

async function drawWindows() {
  const axis = axisAcross();
  const from = await choiceValues("pretension_from");
  const to = await choiceValues("pretension_to");
  const { from_by: lower, to_by: upper } = page.design.texts;
  const ends = [...from.filter(Number.isFinite), ...to.filter(Number.isFinite)];
  const top = 1.1 * ends.reduce((most, end) => Math.max(most, end), 1);
  const x = ticksOf(axis);
  const low = [];
  const high = [];
  const boundBy = []; // the limits that bound the window, below and above
  for (let i = 0; i < lengthOf(axis); i++) {
    const row = cellOf(i, cursor.j);
    const hasWindow = Number.isFinite(from[row]) && !(from[row] > to[row]);
    if (hasWindow) {
      low.push(from[row]);
      high.push(Number.isFinite(to[row]) ? to[row] : top);
      boundBy.push([lower[row], upper[row] || "nothing bounds it"]);
    } else {
      low.push(null);
      high.push(null);
      boundBy.push(["no window", "no window"]);
    }
  }
  const common = { type: "scatter", mode: modeAlong(axis), x, customdata: boundBy };
  const between = isListed(axis) ? barsBetween(low, high) : {};
  const band = isListed(axis) ? {} : { fill: "tonexty", fillcolor: colour("band") };
  const traces = [
    {
      ...common,
      y: low,
      name: "from",
      ...between,
      line: { color: colour("extensor") },
      marker: { symbol: "triangle-up", size: 9, color: colour("extensor") },
      hovertemplate: "from %{y:.5g} N: %{customdata[0]}<extra></extra>",
    },
    {
      ...common,
      y: high,
      name: "to",
      ...band,
      line: { color: colour("flexor"), dash: "dash" },
      marker: { symbol: "triangle-down", size: 9, color: colour("flexor") },
      hovertemplate: "to %{y:.5g} N: %{customdata[1]}<extra></extra>",
    },
  ];
  const up = { title: { text: `${page.design.pretension} (N)` }, rangemode: "tozero" };
  const title = "Window of pretension";
  const isEmpty = low.every((end) => end === null);
  const more = isEmpty ? saying("no choice on this line has a window") : {};
  await drawFigure("windows", drawWindows, traces, title, plotlyAxis(axis), up, more);
  const heads = [titleOf(axis), "from (N)", "bound by", "to (N)", "bound by"];
  const row = (_, i) => [
    valueText(axis, i),
    boundText(low[i]),
    boundBy[i][0],
    boundText(high[i]),
    boundBy[i][1],
  ];
  fillTable("windows", heads, () => x.map(row));
}

// --- The front of two goals ---

const front = { x: 0, y: 1, names: [] }; // the goals across and up, among the names of all goals

async function drawFront() {
  const x = page.design.columns[front.names[front.x]];
  const y = page.design.columns[front.names[front.y]];
  const xs = await unpack(x.array);
  const ys = await unpack(y.array);
  const onFront = await choiceValues("on_front");
  const hasBoth = (row) => Number.isFinite(xs[row]) && Number.isFinite(ys[row]);
  const rows = Array.from(xs.keys()).filter(hasBoth);
  const others = rows.filter((row) => !(onFront[row] > 0));
  const frontRows = rows.filter((row) => onFront[row] > 0);
  frontRows.sort((first, second) => xs[first] - xs[second]);

  const across = `${x.label} %{x:.5g} ${x.unit}`;
  const up = `${y.label} %{y:.5g} ${y.unit}`;
  const trace = (selected) => ({
    type: "scatter",
    x: selected.map((row) => xs[row]),
    y: selected.map((row) => ys[row]),
    customdata: selected,
    hovertemplate: `${across}<br>${up}<extra></extra>`,
  });
  const traces = [
    {
      ...trace(others),
      mode: "markers",
      name: "choices",
      marker: { color: colour("faint"), size: 8 },
    },
    {
      ...trace(frontRows),
      mode: page.axes.some(isListed) ? "markers" : "lines+markers",
      name: "on the front",
      line: { color: colour("flexor"), dash: "dot" },
      marker: { symbol: "diamond", size: 10, color: colour("flexor") },
    },
  ];
  const title = "Choices; drag a box to mark them on the map";
  const more = { dragmode: "select" };
  await drawFigure("front", drawFront, traces, title, titleOf(x), titleOf(y), more);
  const tableRow = (row) => [
    formatNumber(xs[row]),
    formatNumber(ys[row]),
    onFront[row] > 0 ? "yes" : "no",
  ];
  fillTable("front", [titleOf(x), titleOf(y), "on the front"], () => rows.map(tableRow));
}

// Marks choices, drawn in a box or passed by the table's filter, on the map and in the table; null
// marks none.
function brush(rows) {
  view.brushed = rows;
  let text = "No choice is marked.";
  if (rows !== null) {
    const onMap = rows.filter(isOnMap).length;
    text = `${rows.length} choices are marked, ${onMap} of them on the map's grid.`;
  }
  for (const id of ["brush-says", "mark-says"]) {
    if (byId(id)) {
      byId(id).textContent = text;
    }
  }
  if (hasMap()) {
    redraw();
  }
  drawTable();
}

async function startFront() {
  front.names = page.design.goals;
  [front.x, front.y] = page.design.display;
  const labels = front.names.map((name) => page.design.columns[name].label);
  const chooseGoal = (which) => (goal) => {
    front[which] = goal;
    drawFront();
  };
  byId("front-axes").append(
    makeSelect("across ", labels, front.x, chooseGoal("x")),
    makeSelect("up ", labels, front.y, chooseGoal("y")),
  );
  await drawFront();
  const figure = byId("front");
  figure.on("plotly_selected", (event) => {
    brush(event ? event.points.map((point) => point.customdata) : null);
  });
  figure.on("plotly_deselect", () => brush(null));
}

// --- People ---

// Draws the persons that the best choice serves and leaves out, over two measures of the body.
async function drawPeople() {
  const { x, y, served, title } = page.people;
  const xs = await unpack(x.array);
  const ys = await unpack(y.array);
  const isServed = await unpack(served.array);
  const all = Array.from(xs.keys());
  const trace = (rows, name, marker) => ({
    type: "scatter",
    mode: "markers",
    name,
    x: rows.map((row) => xs[row]),
    y: rows.map((row) => ys[row]),
    marker,
  });
  const rowsServed = all.filter((row) => isServed[row] > 0);
  const rowsLeftOut = all.filter((row) => !(isServed[row] > 0));
  const traces = [
    trace(rowsServed, "served", { color: colour("flexor"), size: 5, opacity: 0.6 }),
    trace(rowsLeftOut, "not served", { color: colour("extensor"), size: 8, symbol: "x" }),
  ];
  byId("people-says").textContent = title;
  await drawFigure("people", drawPeople, traces, "Persons", titleOf(x), titleOf(y));
  const tableRow = (row) => [
    formatNumber(xs[row]),
    formatNumber(ys[row]),
    isServed[row] > 0 ? "yes" : "no",
  ];
  fillTable("people", [titleOf(x), titleOf(y), "served"], () => all.map(tableRow));
}

// --- The window over the motion ---

// Draws the pretension that each limit allows at each angle or time, for the choice named first;
// its window is the pretension that all limits allow at all of them.
async function drawBetween() {
  const { along, at_end: atEnd, lines, samples, window: ends, top, says } = page.between;
  const isInTime = atEnd !== null;
  const unit = isInTime ? " s" : "°";
  byId("between-says").textContent = says;
  const traces = lines.map(({ label, end, values, colour: name }) => ({
    type: "scatter",
    mode: "lines",
    x: along,
    y: values,
    name: label,
    line: {
      color: colour(name),
      dash: end === "from" ? "solid" : "dash",
    },
    hovertemplate: `%{x:.4g}${unit}: ${end} %{y:.5g} N<extra>${label}</extra>`,
  }));
  if (samples.x.length) {
    traces.push({
      type: "scatter",
      mode: "markers",
      x: samples.x,
      y: samples.y,
      name: "angle of the study",
      marker: { color: colour("text"), size: 5, maxdisplayed: 30 },
      hovertemplate: "%{x:.4g}°: %{y:.5g} N<extra></extra>",
    });
  }
  if (atEnd) {
    traces.push(endsTrace(atEnd, along, 0, top));
  }
  const [low, high] = ends;
  const band = {
    type: "rect",
    xref: "paper",
    x0: 0,
    x1: 1,
    y0: low,
    y1: Math.min(high ?? top, top), // null if nothing bounds it
    fillcolor: colour("band"),
    line: { width: 0 },
    layer: "below",
  };
  const across = isInTime ? "time (s)" : `${page.angle} (deg)`;
  const up = { title: { text: `${page.design.pretension} (N)` }, range: [0, top] };
  const title = isInTime ? "The window over time" : "The window over the angle";
  await drawFigure("between", drawBetween, traces, title, across, up, { shapes: [band] });
  const heads = [across, ...lines.map(({ label, end }) => `${label}, ${end} (N)`)];
  const tableRow = (place, at) => [
    formatNumber(place),
    ...lines.map(({ values }) => boundText(values[at])),
  ];
  fillTable("between", heads, () => along.map(tableRow));
}

async function startAnswers() {
  if (!page.design) {
    return;
  }
  if (byId("front")) {
    await startFront();
  }
  if (hasMap() && byId("windows")) {
    await drawWindows();
  }
  if (page.people) {
    await drawPeople();
  }
  if (page.between) {
    await drawBetween();
  }
}
