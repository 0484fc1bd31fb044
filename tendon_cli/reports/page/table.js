// The table of designs or choices: sorted by any column, filtered by comparisons.

const FIRST_ROWS = 100;
const MORE_ROWS = 400;

// The column that sorts, the filters, how many rows are shown, and the columns with their values.
const listed = { sort: null, falling: false, filters: [], count: FIRST_ROWS, columns: [] };

// Returns the columns of the table, each with a function `value` that takes a row.
async function columnsOfTable() {
  const columns = [];
  for (const column of page.table.columns) {
    if (column.axis !== undefined) {
      columns.push(axisColumn(column.axis));
    } else if (column.texts) {
      columns.push({ ...column, value: (row) => column.texts[row] });
    } else {
      const source = column.array ? column : page.quantities[column.quantity];
      columns.push(await arrayColumn(source));
    }
  }
  return columns;
}

// Returns the column of an axis of the page.
function axisColumn(number) {
  const axis = page.axes[number];
  const ticks = ticksOf(axis);
  return { ...axis, value: (row) => ticks[indexAlong(number, row)] };
}

// Returns a column of packed numbers; classes are shown by their labels.
async function arrayColumn(source) {
  const values = await unpack(source.array);
  if (source.classes) {
    return { ...source, value: (row) => classLabel(source.classes, values[row]) };
  }
  return { ...source, value: (row) => values[row] };
}

// --- Filters, as on the command line: "margin > 5 N; load_mass in 3 kg, 5 kg; taut = yes" ---

const TRUTHS = { yes: 1, true: 1, 1: 1, no: 0, false: 0, 0: 0 };
const FILTER = /^(.+?)\s*(<=|>=|!=|==|=|<|>|\sin(?=\s|\[))\s*(.+)$/;
const MEASURE = /^([-+−]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)$/;
const AS_PRINTED = 1e-3; // share by which a value may differ from the digits that are shown
const ROUNDING = 1e-9;

// Returns the filters of a text; throws an Error that says what is wrong.
function parseFilters(text) {
  const parts = text.split(";").map((part) => part.trim());
  return parts.filter(Boolean).map(parseFilter);
}

function parseFilter(text) {
  const match = text.match(FILTER);
  if (!match) {
    const example = `${listed.columns[0].label} > 5`;
    throw new Error(`"${text}" is not a filter such as "${example}"`);
  }
  const sign = match[2].trim().replace("==", "=");
  const column = columnNamed(match[1]);
  let values = [match[3]];
  if (sign === "in") {
    values = match[3].replace(/^\[|\]$/g, "").split(",");
  }
  return { column, sign, wanted: values.map((value) => wantedOf(column, value.trim(), sign)) };
}

// Returns the column with a name, key or label, or whose label begins with the text.
function columnNamed(text) {
  const name = text.trim().toLowerCase();
  const words = name.replaceAll("_", " ");
  const { columns } = listed;
  const column =
    columns.find((one) => one.name === name || one.key === name) ||
    columns.find((one) => one.label.toLowerCase() === words) ||
    columns.find((one) => one.label.toLowerCase().startsWith(words));
  if (!column) {
    const hint = "the heads of the columns are their names";
    throw new Error(`no column is called "${text.trim()}"; ${hint}`);
  }
  return column;
}

// Returns the value that a filter asks for: yes and no as 1 and 0, a text, or a number in the unit
// of its column. A number without a unit is in that unit already.
function wantedOf(column, text, sign) {
  if (column.truth) {
    return wantedTruth(column, text.toLowerCase(), sign);
  }
  if (column.texts || column.names || column.classes) {
    return text.replace(/^["'](.*)["']$/, "$1");
  }
  const match = text.match(MEASURE);
  if (!match) {
    throw new Error(`"${text}" is not a number`);
  }
  const value = Number(match[1].replace("−", "-"));
  const symbol = match[2];
  if (symbol === "") {
    return value;
  }
  const unit = page.units[symbol]; // dimension and factor to SI
  if (!unit || unit[0] !== column.dimension) {
    const example = column.unit ? `, such as ${column.unit}` : "";
    throw new Error(`"${symbol}" is no unit of ${column.label}${example}`);
  }
  return (value * unit[1]) / column.factor;
}

function wantedTruth(column, text, sign) {
  const hasOrder = "<>".includes(sign[0]);
  if (!(text in TRUTHS) || hasOrder) {
    throw new Error(`${column.label} is yes or no`);
  }
  return TRUTHS[text];
}

// Returns true if a row passes a filter; a row without a number passes none.
function passes(row, { column, sign, wanted }) {
  const value = column.value(row);
  const isText = typeof value === "string";
  if (!isText && !Number.isFinite(value)) {
    return false;
  }
  const isEqual = (other) => {
    if (isText) {
      return value === other;
    }
    return Math.abs(value - other) <= AS_PRINTED * Math.abs(other) + ROUNDING;
  };
  if (sign === "=" || sign === "in") {
    return wanted.some(isEqual);
  }
  if (sign === "!=") {
    return !wanted.some(isEqual);
  }
  const [bound] = wanted;
  const isNear = Math.abs(value - bound) <= ROUNDING * Math.abs(bound);
  const isBeyond = sign[0] === "<" ? value < bound : value > bound;
  return sign.endsWith("=") ? isBeyond || isNear : isBeyond && !isNear;
}

// --- The table ---

// Compares two values for rising order, numbers or texts.
function compareValues(a, b) {
  return typeof a === "string" ? a.localeCompare(b) : a - b;
}

// Returns the rows that pass the filters, sorted; rows without a number come last.
function rowsOfTable() {
  const all = Array.from({ length: page.table.rows }, (_, row) => row);
  const rows = all.filter((row) => listed.filters.every((filter) => passes(row, filter)));
  if (listed.sort === null) {
    return rows;
  }
  const { value } = listed.columns[listed.sort];
  const direction = listed.falling ? -1 : 1;
  return rows.sort((first, second) => {
    const a = value(first);
    const b = value(second);
    const missing = Number(Number.isNaN(a)) - Number(Number.isNaN(b));
    return missing || direction * compareValues(a, b);
  });
}

// Makes the head of a column, a button that sorts by it: rising first, then falling.
function makeHead(column, at) {
  const isSorted = listed.sort === at;
  let order = "none";
  let mark = "";
  if (isSorted) {
    order = listed.falling ? "descending" : "ascending";
    mark = listed.falling ? " ▼" : " ▲";
  }
  const press = () => {
    listed.falling = isSorted && !listed.falling;
    listed.sort = at;
    drawTable();
    byId("list").querySelectorAll("th button")[at].focus();
  };
  const button = make("button", { type: "button", onclick: press }, titleOf(column) + mark);
  return make("th", { scope: "col", "aria-sort": order }, button);
}

function drawTable() {
  const rows = rowsOfTable();
  const columns = listed.columns.filter((column) => !column.hidden);
  const marked = new Set(view.brushed);
  const body = rows.slice(0, listed.count).map((row) => {
    const cells = columns.map((column) => {
      const value = column.value(row);
      return make("td", {}, typeof value === "string" ? value : formatNumber(value));
    });
    return make("tr", { class: marked.has(row) && "marked" }, ...cells);
  });
  const head = make("thead", {}, make("tr", {}, ...columns.map(makeHead)));
  byId("list").replaceChildren(make("table", {}, head, make("tbody", {}, ...body)));
  const seen = Math.min(rows.length, listed.count);
  const total = page.table.rows;
  byId("list-says").textContent = `${seen} of ${rows.length} rows that pass, of ${total}`;
  byId("more").hidden = rows.length <= listed.count;
}

// Filters the table by a text; the rows stay as they are while the text is not a filter.
function onFilter(event) {
  try {
    listed.filters = parseFilters(event.target.value);
    byId("filter-fault").textContent = "";
    drawTable();
  } catch (fault) {
    byId("filter-fault").textContent = fault.message;
  }
}

async function startTable() {
  if (!page.table) {
    return;
  }
  listed.columns = await columnsOfTable();
  byId("more").addEventListener("click", () => {
    listed.count += MORE_ROWS;
    drawTable();
  });
  const mark = byId("mark");
  if (page.design) {
    mark.addEventListener("click", () => brush(listed.filters.length ? rowsOfTable() : null));
  } else {
    mark.remove();
  }
  byId("filter").addEventListener("input", onFilter);
  drawTable();
}
