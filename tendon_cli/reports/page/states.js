// The states of one design: curves over the elbow angle, or over the time of a motion in time, and
// the arm at a place that a slider moves.

// The cell asked for, the figure and the place by index, and the position of the design shown.
const shown = { cell: 0, group: 0, angle: 0, position: [] };

const DASHES = ["solid", "dash"]; // of flexion and extension
const MARK = "mark"; // of a trace that is an area, not values: the range of the torque, the ends
const SYMBOLS = ["circle", "square-open"];

// Returns the index of the value nearest to the one wanted.
function nearest(values, wanted) {
  let best = 0;
  values.forEach((value, index) => {
    if (Math.abs(value - wanted) < Math.abs(values[best] - wanted)) {
      best = index;
    }
  });
  return best;
}

// Returns the number of the design nearest to a cell among those whose states the page has, and
// notes its position on the page's axes.
function nearestDesign(cell) {
  const { kept } = page.states; // positions on each axis that have states
  const places = positionOf(cell).map((index, axis) => nearest(kept[axis], index));
  shown.position = places.map((place, axis) => kept[axis][place]);
  return places.reduce((sum, place, axis) => sum * kept[axis].length + place, 0);
}

function groupShown() {
  return page.states.groups[shown.group];
}

// Returns the angle shown, in degrees.
function angleShown() {
  return page.states.angles[shown.angle];
}

// Returns true if the states are those of a motion in time.
function isInTime() {
  return page.states.times !== null;
}

// Returns the places across: times in seconds, or angles in degrees.
function placesAcross() {
  return page.states.times || page.states.angles;
}

// Returns the place shown as a text.
function placeText() {
  const angle = `${formatNumber(angleShown())}°`;
  return isInTime() ? `${formatNumber(placesAcross()[shown.angle])} s, ${angle}` : angle;
}

// Returns the title of the axis across.
function acrossTitle() {
  return isInTime() ? "time (s)" : `${page.angle} (deg)`;
}

// --- Curves ---

// Returns the traces of values, without those that are areas.
function valueTraces(traces) {
  return traces.filter((trace) => trace.meta !== MARK);
}

// Returns a trace for each line of the figure in each direction.
async function stateTraces() {
  const { directions } = page.states;
  const places = placesAcross();
  const group = groupShown();
  const start = nearestDesign(shown.cell) * directions.length * places.length;
  const at = isInTime() ? "%{x:.4g} s" : "%{x}°";
  const traces = [];
  for (const line of group.lines) {
    const values = await unpack(line.array);
    directions.forEach((direction, number) => {
      const from = start + number * places.length;
      const name = [line.label, direction].filter(Boolean).join(", ");
      traces.push({
        type: "scatter",
        mode: isInTime() ? "lines" : "lines+markers",
        x: places,
        y: Array.from(values.subarray(from, from + places.length)),
        name,
        line: { color: colour(line.colour), dash: DASHES[number % 2] },
        marker: { symbol: SYMBOLS[number % 2], size: 7, maxdisplayed: 12 },
        hovertemplate: `${at}: %{y:.5g} ${group.unit}<extra>${name}</extra>`,
      });
    });
    if (line.other) {
      const others = await unpack(line.other);
      const trace = traces.at(-1);
      trace.other = Array.from(others.subarray(start, start + places.length));
      traces.push(bandTrace(trace));
    }
  }
  if (isInTime()) {
    const values = valueTraces(traces).flatMap((trace) => trace.y.filter(Number.isFinite));
    const heights = [Math.min(...values, 0), Math.max(...values, 0)];
    traces.push(endsTrace(page.states.ends, places, ...heights));
  }
  return traces;
}

// Returns the area between a line and its values with friction the other way, while the sheath
// turns.
function bandTrace(trace) {
  const { ends } = page.states;
  const isTurning = (at) => Number.isFinite(trace.other[at]) && !ends[at];
  const bound = trace.y.map((value, at) => (isTurning(at) ? trace.other[at] : value));
  return {
    type: "scatter",
    mode: "lines",
    meta: MARK,
    x: trace.x,
    y: bound,
    name: "the torque lies in this band",
    fill: "tonexty",
    fillcolor: colour("band"),
    line: { width: 0 },
    hoverinfo: "skip",
  };
}

// Returns the first and the last place of each stretch in which something holds.
function stretchesOf(holds, places) {
  const stretches = [];
  holds.forEach((value, at) => {
    if (value && !holds[at - 1]) {
      stretches.push([places[Math.max(at - 1, 0)], places[at]]);
    }
    if (value) {
      stretches.at(-1)[1] = places[Math.min(at + 1, places.length - 1)];
    }
  });
  return stretches;
}

// Returns the hatched areas of the ends of the record between two heights.
function endsTrace(ends, places, low, high) {
  const x = [];
  const y = [];
  for (const [first, last] of stretchesOf(ends, places)) {
    x.push(first, first, last, last, null);
    y.push(low, high, high, low, null);
  }
  return {
    type: "scatter",
    mode: "none",
    meta: MARK,
    x,
    y,
    name: "end of the record, counts for nothing",
    fill: "toself",
    fillcolor: "rgba(0, 0, 0, 0)",
    fillpattern: { shape: "\\", fgcolor: colour("faint"), size: 8, solidity: 0.2 },
    hoverinfo: "skip",
  };
}

// Returns the shaded areas of the time in which the sheath turns in the design shown.
async function turningShapes() {
  if (!isInTime()) {
    return [];
  }
  const count = placesAcross().length;
  const start = nearestDesign(shown.cell) * count;
  const turning = await unpack(page.states.turning[groupShown().arm]);
  const { ends } = page.states;
  const holds = Array.from(turning.subarray(start, start + count));
  const inside = holds.map((value, at) => value > 0 && !ends[at]);
  return stretchesOf(inside, placesAcross()).map(([x0, x1], at) => ({
    type: "rect",
    xref: "x",
    yref: "paper",
    x0,
    x1,
    y0: 0,
    y1: 1,
    fillcolor: colour("faint"),
    opacity: 0.25,
    line: { width: 0 },
    layer: "below",
    name: "the tendons turn",
    showlegend: at === 0,
  }));
}

async function drawStates() {
  const group = groupShown();
  const traces = await stateTraces();
  const place = placesAcross()[shown.angle];
  const placeLine = {
    type: "line",
    xref: "x",
    yref: "paper",
    x0: place,
    x1: place,
    y0: 0,
    y1: 1,
    line: { color: colour("mark"), dash: "dot" },
  };
  const across = acrossTitle();
  const label = isNarrow() ? "" : group.label.split(",")[0];
  const up = titleOf({ label, unit: group.unit });
  const more = { shapes: [placeLine, ...(await turningShapes())] };
  await drawFigure("states", drawStates, traces, titleOf(group), across, up, more);
  const values = valueTraces(traces);
  const heads = [across, ...values.map((trace) => `${trace.name} (${group.unit})`)];
  const row = (at, index) => [at, ...values.map((trace) => trace.y[index])].map(formatNumber);
  fillTable("states", heads, () => placesAcross().map(row));
}

// --- The arm ---

// Returns the measures of the design's arm, in m; some are the same for all designs.
function armShown() {
  const number = nearestDesign(shown.cell);
  const measures = page.arms[groupShown().arm];
  const arm = {};
  for (const [name, values] of Object.entries(measures)) {
    arm[name] = values.length === 1 ? values[0] : values[number];
  }
  return arm;
}

// Makes an element of a drawing.
function makeSvg(name, attributes) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) {
    element.setAttribute(key, value);
  }
  return element;
}

function makeLine([x1, y1], [x2, y2], kind) {
  return makeSvg("line", { x1, y1, x2, y2, class: kind });
}

function makeCircle([cx, cy], r, kind) {
  return makeSvg("circle", { cx, cy, r, class: kind });
}

// Draws the arm at the angle shown: the upper arm up the page, the forearm turned about the elbow.
function drawArm() {
  const arm = armShown();
  if (arm.b1 === undefined) {
    const text =
      "This joint is given by its travels, not by anchors: " +
      'the curves show them as "travel".';
    byId("arm").replaceChildren(make("p", {}, text));
    return;
  }
  const theta = (angleShown() * Math.PI) / 180;
  const sine = Math.sin(theta);
  const cosine = Math.cos(theta);
  const at = (x, y) => [x, -y]; // up the page is up the arm
  const shoulder = [0, -arm.b1 * 1.1];
  const elbow = [0, 0];
  const upperAnchor = at(arm.a1, arm.b1);
  const lowerFoot = at(arm.b2 * sine, -arm.b2 * cosine);
  const lowerAnchor = at(
    arm.b2 * sine + arm.a2 * cosine,
    -arm.b2 * cosine + arm.a2 * sine,
  );
  const hand = at(arm.load_distance * sine, -arm.load_distance * cosine);
  const size = Math.max(arm.b1, arm.load_distance);

  // The picture has room for the hand at every angle.
  const heights = page.states.angles.map(
    (angle) => -arm.load_distance * Math.cos((angle * Math.PI) / 180),
  );
  const highest = Math.max(...heights);
  const left = -arm.elbow_radius - 0.08 * size;
  const top = -Math.max(arm.b1 * 1.15, highest + 0.08 * size);
  const width = arm.load_distance * 1.1 - left;
  const height = Math.max(arm.load_distance, arm.b2) * 1.1 - top;

  // The extensor runs down behind the upper arm, around the elbow, and along the forearm.
  const radius = arm.elbow_radius;
  const extensorEnd = at(
    -radius * cosine - sine * -arm.b2,
    -radius * sine - cosine * arm.b2,
  );
  const extensor = [
    `M ${-radius} ${-arm.b1}`,
    `L ${-radius} 0`,
    `A ${radius} ${radius} 0 0 0 ${-radius * cosine} ${radius * sine}`,
    `L ${extensorEnd[0]} ${extensorEnd[1]}`,
  ].join(" ");

  const picture = makeSvg("svg", {
    viewBox: [left, top, width, height].join(" "),
    role: "img",
    "aria-label": `The arm at ${formatNumber(angleShown())} degrees`,
  });
  picture.append(
    makeLine(shoulder, elbow, "bone"),
    makeLine(elbow, hand, "bone"),
    makeLine([0, upperAnchor[1]], upperAnchor, "anchor"),
    makeLine(lowerFoot, lowerAnchor, "anchor"),
    makeCircle(elbow, radius, "pulley"),
    makeSvg("path", { d: extensor, class: "extensor" }),
    makeLine(upperAnchor, lowerAnchor, "flexor"),
    makeCircle(upperAnchor, size * 0.018, "pin"),
    makeCircle(lowerAnchor, size * 0.018, "pin"),
    makeCircle(hand, size * 0.04, "load"),
  );
  byId("arm").replaceChildren(picture);
}

// --- Both ---

// Shows the place: the arm, the values at it, and its line through the curves.
function drawAngle() {
  byId("angle-says").textContent = placeText();
  drawArm();
  const { unit } = groupShown();
  const items = valueTraces(byId("states").data).map((trace) => {
    const value = formatWithUnit(trace.y[shown.angle], unit);
    const other = trace.other ? trace.other[shown.angle] : NaN;
    const range = Number.isFinite(other) ? ` to ${formatWithUnit(other, unit)}, turning` : "";
    return make("li", {}, `${trace.name}: ${value}${range}`);
  });
  byId("arm-values").replaceChildren(...items);
  const place = placesAcross()[shown.angle];
  const line = { "shapes[0].x0": place, "shapes[0].x1": place };
  Plotly.relayout(byId("states"), line);
}

// Shows the states of the design at a cell, or of the nearest design that has any.
async function showDesign(cell) {
  if (!page.states) {
    return;
  }
  shown.cell = cell;
  nearestDesign(cell);
  const wanted = positionOf(cell);
  const isExact = shown.position.every((index, axis) => index === wanted[axis]);
  const places = page.axes.map(
    (axis, at) => `${axis.label} ${valueText(axis, shown.position[at])}`,
  );
  const text = places.join(", ") || "the only design";
  const place = isExact ? text : `${text} (the nearest whose states this page keeps)`;
  await drawStates();
  const drawn = valueTraces(byId("states").data);
  const hasStates = drawn.some((trace) => trace.y.some(Number.isFinite));
  const reason = page.design ? "it has no pretension" : "it has no equilibrium";
  byId("design-says").textContent = hasStates ? place : `${place}: no states, because ${reason}`;
  drawAngle();
}

// Shows the design at another index of an axis, when a slider of the map moves.
function moveStates(axis, index) {
  if (!page.states) {
    return;
  }
  const position = positionOf(shown.cell);
  position[axis] = index;
  showDesign(cellAt(position));
}

function startStates() {
  if (!page.states) {
    return;
  }
  const names = page.states.groups.map((group) => group.label);
  const chooseGroup = async (group) => {
    shown.group = group;
    await drawStates();
    drawAngle();
  };
  byId("groups").append(makeSelect("Show ", names, 0, chooseGroup));
  const slider = byId("angle");
  const last = page.states.angles.length - 1;
  if (isInTime()) {
    byId("angle-name").textContent = "Time";
  }
  slider.max = last;
  shown.angle = Math.floor(last * 0.6);
  slider.value = shown.angle;
  slider.addEventListener("input", () => {
    shown.angle = Number(slider.value);
    slider.setAttribute("aria-valuetext", placeText());
    drawAngle();
  });
  return showDesign(cellAt(view.at));
}
