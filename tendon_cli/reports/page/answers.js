// Of a design run: windows of pretension along an axis of choices, the front with its brush, and people left out.

async function column(name) {
  return unpack(page.design.columns[name].array);
}

async function drawWindows() {
  const axis = page.axes[view.x];
  const [from, to] = [await column("pretension_from"), await column("pretension_to")];
  const { from_by: lower, to_by: upper } = page.design.texts;
  const [x, low, high, by] = [[], [], [], []];
  const top = 1.1 * Math.max(...from.filter(Number.isFinite), ...to.filter(Number.isFinite), 1);
  for (let i = 0; i < lengthOf(axis); i++) {
    const row = cellOf(i, cursor.j);
    const none = !Number.isFinite(from[row]) || from[row] > to[row];
    x.push(along(axis)[i]);
    low.push(none ? null : from[row]);
    high.push(none ? null : Number.isFinite(to[row]) ? to[row] : top);
    by.push(none ? ["no window", "no window"] : [lower[row], upper[row] || "nothing bounds it"]);
  }
  const common = { type: "scatter", mode: "lines+markers", x, customdata: by };
  const traces = [
    { ...common, y: low, name: "from", line: { color: colour("extensor") }, marker: { symbol: "triangle-up", size: 9 }, hovertemplate: "from %{y:.5g} N: %{customdata[0]}<extra></extra>" },
    { ...common, y: high, name: "to", fill: "tonexty", fillcolor: colour("band"), line: { color: colour("flexor"), dash: "dash" }, marker: { symbol: "triangle-down", size: 9 }, hovertemplate: "to %{y:.5g} N: %{customdata[1]}<extra></extra>" },
  ];
  const up = { title: { text: `${page.design.pretension} [N]` }, rangemode: "tozero" };
  await draw("windows", drawWindows, traces, "Window of pretension", axisOf(axis), up);
  asTable("windows", [named(axis), "from [N]", "bound by", "to [N]", "bound by"], () => x.map((_, i) => [valueOf(axis, i), low[i] === null ? "none" : number(low[i]), by[i][0], high[i] === null ? "none" : number(high[i]), by[i][1]]));
}

const front = { x: 0, y: 1, names: [] };

async function drawFront() {
  const [x, y] = [page.design.columns[front.names[front.x]], page.design.columns[front.names[front.y]]];
  const [xs, ys, on] = [await unpack(x.array), await unpack(y.array), await column("on_front")];
  const rows = Array.from(xs.keys()).filter((row) => Number.isFinite(xs[row]) && Number.isFinite(ys[row]));
  const inFront = rows.filter((row) => on[row] > 0).sort((a, b) => xs[a] - xs[b]);
  const points = (chosen, more) => ({ type: "scatter", x: chosen.map((row) => xs[row]), y: chosen.map((row) => ys[row]), customdata: chosen, hovertemplate: `${x.label} %{x:.5g} ${x.unit}<br>${y.label} %{y:.5g} ${y.unit}<extra></extra>`, ...more });
  const traces = [
    points(rows.filter((row) => !(on[row] > 0)), { mode: "markers", name: "choices", marker: { color: colour("faint"), size: 8 } }),
    points(inFront, { mode: "lines+markers", name: "on the front", line: { color: colour("flexor"), dash: "dot" }, marker: { symbol: "diamond", size: 10, color: colour("flexor") } }),
  ];
  await draw("front", drawFront, traces, "Choices; drag a box to mark them on the map", named(x), named(y), { dragmode: "select" });
  asTable("front", [named(x), named(y), "on the front"], () => rows.map((row) => [number(xs[row]), number(ys[row]), on[row] > 0 ? "yes" : "no"]));
}

// Marks choices, drawn in a box or passed by the table's filter, on the map and in the table.
function brush(rows) {
  view.brushed = rows;
  const text = rows === null ? "Nothing is marked." : `${rows.length} choices are marked, ${rows.filter(isOnMap).length} of them on the map's grid.`;
  for (const id of ["brush-says", "mark-says"]) if (place(id)) place(id).textContent = text;
  if (hasMap()) redraw();
  drawTable();
}

async function startAnswers() {
  if (!page.design) return;
  if (place("front")) await startFront();
  if (hasMap() && place("windows")) await drawWindows();
  if (page.people) await drawPeople();
  if (page.between) await drawBetween();
}

async function startFront() {
  front.names = page.design.goals;
  [front.x, front.y] = page.design.display;
  const labels = front.names.map((name) => page.design.columns[name].label);
  place("front-axes").append(select("across ", labels, front.x, (at) => { front.x = at; drawFront(); }), select("up ", labels, front.y, (at) => { front.y = at; drawFront(); }));
  await drawFront();
  place("front").on("plotly_selected", (event) => brush(event ? event.points.map((point) => point.customdata) : null));
  place("front").on("plotly_deselect", () => brush(null));
}

// The bodies that the best choice leaves out, over two measures of the body.
async function drawPeople() {
  const { x, y, served } = page.people;
  const [xs, ys, ok] = [await unpack(x.array), await unpack(y.array), await unpack(served.array)];
  const group = (wanted, name, marker) => {
    const rows = Array.from(xs.keys()).filter((row) => ok[row] > 0 === wanted);
    return { type: "scatter", mode: "markers", name, x: rows.map((row) => xs[row]), y: rows.map((row) => ys[row]), marker };
  };
  const traces = [group(true, "served", { color: colour("flexor"), size: 5, opacity: 0.6 }), group(false, "not served", { color: colour("extensor"), size: 8, symbol: "x" })];
  await draw("people", drawPeople, traces, page.people.title, named(x), named(y));
  asTable("people", [named(x), named(y), "served"], () => Array.from(xs.keys()).map((row) => [number(xs[row]), number(ys[row]), ok[row] > 0 ? "yes" : "no"]));
}

// What each limit asks of the pretension at each angle, for the choice named first: its window is what is left at all angles.
async function drawBetween() {
  const { angles, lines, samples, window, top, says } = page.between;
  place("between-says").textContent = says;
  const kinds = ["flexor", "extensor", "motor", "joint", "mark"];
  const traces = lines.map(({ label, end, values }, at) => ({
    type: "scatter", mode: "lines", x: angles, y: values, name: label, line: { color: colour(kinds[at % kinds.length]), dash: end === "from" ? "solid" : "dash" },
    hovertemplate: `%{x:.4g}°: ${end} %{y:.5g} N<extra>${label}</extra>`,
  }));
  traces.push({ type: "scatter", mode: "markers", x: samples.x, y: samples.y, name: "angle of the study", marker: { color: colour("text"), size: 5 }, hovertemplate: "%{x:.4g}°: %{y:.5g} N<extra></extra>" });
  const band = { type: "rect", xref: "paper", x0: 0, x1: 1, y0: window[0], y1: Math.min(window[1] ?? top, top), fillcolor: colour("band"), line: { width: 0 }, layer: "below" };
  const up = { title: { text: `${page.design.pretension} [N]` }, range: [0, top] };
  await draw("between", drawBetween, traces, "The window over the angle", `${page.angle} [deg]`, up, { shapes: [band] });
  asTable("between", [`${page.angle} [deg]`, ...lines.map(({ label, end }) => `${label}, ${end} [N]`)], () => angles.map((angle, at) => [number(angle), ...lines.map(({ values }) => (values[at] === null ? "none" : number(values[at])))]));
}
