// The states of one design: curves over the elbow angle, and the arm drawn at an angle that one can move.

const shown = { cell: 0, group: 0, angle: 0, position: [] };

function keptCell(cell) {
  const kept = page.states.kept;
  const at = positionOf(cell).map((index, axis) => nearest(kept[axis], index));
  shown.position = at.map((index, axis) => kept[axis][index]);
  return at.reduce((sum, index, axis) => sum * kept[axis].length + index, 0);
}

function nearest(values, wanted) {
  let best = 0;
  values.forEach((value, at) => { if (Math.abs(value - wanted) < Math.abs(values[best] - wanted)) best = at; });
  return best;
}

const DASHES = ["solid", "dash"];
const SYMBOLS = ["circle", "square-open"];

async function curves() {
  const { angles, directions } = page.states;
  const group = page.states.groups[shown.group];
  const start = keptCell(shown.cell) * directions.length * angles.length;
  const traces = [];
  for (const line of group.lines) {
    const values = await unpack(line.array);
    directions.forEach((direction, d) => {
      const from = start + d * angles.length;
      traces.push({
        type: "scatter", mode: "lines+markers", x: angles, y: Array.from(values.subarray(from, from + angles.length)),
        name: `${line.label}, ${direction}`, line: { color: colour(line.colour), dash: DASHES[d % 2] },
        marker: { symbol: SYMBOLS[d % 2], size: 7, maxdisplayed: 12 },
        hovertemplate: `%{x}°: %{y:.5g} ${group.unit}<extra>${line.label}, ${direction}</extra>`,
      });
    });
  }
  return traces;
}

async function drawStates() {
  const group = page.states.groups[shown.group];
  const traces = await curves();
  const line = { type: "line", xref: "x", yref: "paper", x0: angleNow(), x1: angleNow(), y0: 0, y1: 1, line: { color: colour("mark"), dash: "dot" } };
  const up = named({ label: narrow() ? "" : group.label.split(",")[0], unit: group.unit });
  await draw("states", drawStates, traces, named(group), `${page.angle} [deg]`, up, { shapes: [line] });
  const heads = [`${page.angle} [deg]`, ...traces.map((trace) => `${trace.name} [${group.unit}]`)];
  asTable("states", heads, () => page.states.angles.map((angle, at) => [number(angle), ...traces.map((trace) => number(trace.y[at]))]));
}

const angleNow = () => page.states.angles[shown.angle];

function armNow() {
  const arm = {}, cell = keptCell(shown.cell);
  for (const [name, given] of Object.entries(page.arms[page.states.groups[shown.group].arm])) {
    arm[name] = given.length === 1 ? given[0] : given[cell];
  }
  return arm;
}

function svg(name, attributes, text) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text) element.textContent = text;
  return element;
}

function drawArm() {
  const arm = armNow();
  if (arm.b1 === undefined) { // measured travels have no anchors to draw
    place("arm").replaceChildren(make("p", {}, "This joint is known by its travels, not by anchors: they are among the curves, as \"travel\"."));
    return;
  }
  const theta = (angleNow() * Math.PI) / 180;
  const [sine, cosine] = [Math.sin(theta), Math.cos(theta)];
  const at = (x, y) => [x, -y]; // up the page is up the arm
  const r = at(arm.a1, arm.b1);
  const q = at(arm.b2 * sine + arm.a2 * cosine, -arm.b2 * cosine + arm.a2 * sine);
  const hand = at(arm.load_distance * sine, -arm.load_distance * cosine);
  const size = Math.max(arm.b1, arm.load_distance);
  const reach = Math.max(...page.states.angles.map((angle) => -arm.load_distance * Math.cos((angle * Math.PI) / 180)));
  const [left, top] = [-arm.elbow_radius - 0.08 * size, -Math.max(arm.b1 * 1.15, reach + 0.08 * size)];
  const box = [left, top, arm.load_distance * 1.1 - left, Math.max(arm.load_distance, arm.b2) * 1.1 - top];
  const line = (from, to, kind) => svg("line", { x1: from[0], y1: from[1], x2: to[0], y2: to[1], class: kind });
  const R = arm.elbow_radius;
  const end = at(-R * cosine - sine * -arm.b2, -R * sine - cosine * arm.b2);
  const wrapped = `M ${-R} ${-arm.b1} L ${-R} 0 A ${R} ${R} 0 0 0 ${-R * cosine} ${R * sine} L ${end[0]} ${end[1]}`;
  const picture = svg("svg", { viewBox: box.join(" "), role: "img", "aria-label": `The arm at ${number(angleNow())} degrees` });
  picture.append(
    line([0, -arm.b1 * 1.1], [0, 0], "bone"), line([0, 0], hand, "bone"),
    line([0, r[1]], r, "anchor"), line(at(arm.b2 * sine, -arm.b2 * cosine), q, "anchor"),
    svg("circle", { cx: 0, cy: 0, r: R, class: "pulley" }), svg("path", { d: wrapped, class: "extensor" }), line(r, q, "flexor"),
    svg("circle", { cx: r[0], cy: r[1], r: size * 0.018, class: "pin" }), svg("circle", { cx: q[0], cy: q[1], r: size * 0.018, class: "pin" }),
    svg("circle", { cx: hand[0], cy: hand[1], r: size * 0.04, class: "load" }),
  );
  place("arm").replaceChildren(picture);
}

function drawAngle() {
  place("angle-says").textContent = `${number(angleNow())}°`;
  drawArm();
  const { unit } = page.states.groups[shown.group];
  const values = place("states").data.map((line) => make("li", {}, `${line.name}: ${withUnit(line.y[shown.angle], unit)}`));
  place("arm-values").replaceChildren(...values);
  Plotly.relayout(place("states"), { "shapes[0].x0": angleNow(), "shapes[0].x1": angleNow() });
}

async function showDesign(cell) {
  if (!page.states) return;
  shown.cell = cell;
  keptCell(cell);
  const exact = shown.position.every((index, axis) => index === positionOf(cell)[axis]);
  const where = page.axes.map((axis, at) => `${axis.label} ${valueOf(axis, shown.position[at])}`).join(", ") || "the only design";
  place("design-says").textContent = exact ? where : `${where} (the nearest whose states this page keeps)`;
  await drawStates();
  drawAngle();
}

// A slider of the map moves the states along its axis, too.
function moveStates(axis, index) {
  if (!page.states) return;
  const at = positionOf(shown.cell);
  at[axis] = index;
  showDesign(cellAt(at));
}

function startStates() {
  if (!page.states) return;
  const names = page.states.groups.map((group) => group.label);
  place("groups").append(select("Show ", names, 0, async (at) => { shown.group = at; await drawStates(); drawAngle(); }));
  const slide = place("angle");
  slide.max = page.states.angles.length - 1;
  shown.angle = Math.floor((page.states.angles.length - 1) * 0.6);
  slide.value = shown.angle;
  slide.addEventListener("input", () => { shown.angle = Number(slide.value); slide.setAttribute("aria-valuetext", `${number(angleNow())} degrees`); drawAngle(); });
  return showDesign(cellAt(view.at));
}
