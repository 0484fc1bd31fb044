// The table of designs or choices: sorted by any column, filtered by comparisons.

const FIRST_ROWS = 100;
const MORE_ROWS = 400;

// The column that sorts, the filters, how many rows are shown, and the columns with their values.
const listed = { sort: null, falling: false, filters: [], count: FIRST_ROWS, columns: [] };

// Returns the columns of the table, each with a function `value` that takes a row, and a function
// `compared` that returns what filters compare. Those without one are not filtered.
async function columnsOfTable() {
  const columns = [];
  for (const column of page.table.columns) {
    if (column.axis !== undefined) {
      columns.push(await axisColumn(column.axis));
    } else if (column.texts) {
      columns.push(textColumn(column));
    } else if (column.exact) {
      columns.push(await exactColumn(column));
    } else if (column.codes) {
      columns.push(await codedColumn(column));
    } else {
      const source = column.array ? column : page.quantities[column.quantity];
      columns.push(await arrayColumn(source));
    }
  }
  return columns;
}

// Returns the column of an axis of the page.
async function axisColumn(number) {
  const axis = page.axes[number];
  const ticks = ticksOf(axis);
  const meant = axis.words || (await unpack(axis.numbers));
  return {
    ...axis,
    stated: axis.words || (await unpack(axis.stated)),
    value: (row) => ticks[indexAlong(number, row)],
    compared: (row) => meant[indexAlong(number, row)],
  };
}

// Returns a column of texts, of which an empty one is none.
function textColumn(column) {
  return {
    ...column,
    words: column.texts,
    value: (row) => column.texts[row] || "none",
    compared: (row) => column.texts[row],
  };
}

// Returns a column of a few words, packed as their indices.
async function codedColumn(column) {
  const codes = await unpack(column.codes);
  const value = (row) => column.words[codes[row]];
  return { ...column, stated: column.words, value, compared: value };
}

// Returns a column of exact numbers, which axes set.
async function exactColumn(column) {
  const values = await unpack(column.exact);
  const value = (row) => values[row];
  return { ...column, stated: await unpack(column.stated), value, compared: value };
}

// Returns a column of packed numbers; classes are shown by their labels.
async function arrayColumn(source) {
  const values = await unpack(source.array);
  if (source.classes) {
    return { ...source, value: (row) => classLabel(source.classes, values[row]) };
  }
  const value = (row) => values[row];
  return { ...source, isResult: !source.truth, value, compared: value };
}

// --- Filters, as on the command line: "margin > 5 N; load_mass in 3 kg, 5 kg; taut = yes" ---
//
// Grammar and comparisons are those of `studies/filters.py`, which a test compares with these.

const TRUTHS = new Map([
  ["true", 1],
  ["yes", 1],
  ["1", 1],
  ["false", 0],
  ["no", 0],
  ["0", 0],
]);
const FILTERS = /(?:"[^"]*"|'[^']*'|[^;])+/g;
const FILTER = /^\s*([A-Za-z_][\w.]*)\s*(<=|>=|!=|==|=|<|>|\bin\b)\s*(.+?)\s*$/;
const LISTED = /\s*("[^"]*"|'[^']*'|[^,]*?)\s*(?:,|$)/g;
const MEASURE = /^([+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)(?:[ \t]*([^\s\d].*))?$/;
const PRINTED_DIGITS = 4; // fewest significant digits to which a value is rounded
const ROUNDING = 1e-9; // relative difference of a value of an axis and a text that states it

const RELATIONS = {
  "=": (value, wanted) => value === wanted,
  "<": (value, wanted) => value < wanted,
  "<=": (value, wanted) => value <= wanted,
  ">": (value, wanted) => value > wanted,
  ">=": (value, wanted) => value >= wanted,
};

// Returns the filters of a text; throws an Error that says what is wrong.
function parseFilters(text) {
  const parts = text.match(FILTERS) || [];
  return parts.filter((part) => part.trim()).map(parseFilter);
}

function parseFilter(text) {
  const match = text.match(FILTER);
  const sign = match && match[2].replace("==", "=");
  const texts = match ? textsOf(sign, match[3]) : [];
  if (!texts.length) {
    const example = "margin > 5 N, or load_mass in 3 kg, 5 kg";
    throw new Error(`"${text.trim()}" is not a filter such as ${example}`);
  }
  const column = columnNamed(match[1]);
  if ("<>".includes(sign[0]) && (column.truth || column.words)) {
    throw new Error(`${column.name} holds words, which have no order; =, != or in`);
  }
  return { column, sign, wanted: texts.map((one) => wantedOf(column, one)) };
}

// Returns the values that a filter lists, as they are written; only "in" has several.
function textsOf(sign, text) {
  if (sign !== "in") {
    return [text];
  }
  const items = text.replace(/^[[\]]+|[[\]]+$/g, "").matchAll(LISTED);
  return Array.from(items, (item) => item[1]).filter(Boolean);
}

// Returns the column with a name or a key.
function columnNamed(name) {
  const columns = listed.columns.filter((column) => column.compared);
  const column = columns.find((one) => one.name === name || one.key === name);
  if (!column) {
    const names = columns.map((one) => one.name).join(", ");
    throw new Error(`there is no column "${name}"; columns of this page: ${names}`);
  }
  return column;
}

// Returns a text without quotes around it.
function unquoted(text) {
  return text.replace(/^(["'])(.*)\1$/, "$2");
}

// Returns the value that a filter asks for: yes and no as 1 and 0, a text, or a number in the unit
// in which its column is shown.
function wantedOf(column, text) {
  if (column.truth) {
    const truth = TRUTHS.get(unquoted(text).toLowerCase());
    if (truth === undefined) {
      throw new Error(`${column.name} is true or false: yes or no`);
    }
    return truth;
  }
  if (column.words) {
    const word = unquoted(text);
    if (column.stated && !column.stated.includes(word)) {
      throw new Error(`${column.name} is never "${word}"; values: ${column.stated.join(", ")}`);
    }
    return word;
  }
  return wantedNumber(column, text);
}

function wantedNumber(column, text) {
  if (column.dimension === "stiffness" && unquoted(text) === "rigid") {
    return Infinity;
  }
  const match = text.match(MEASURE);
  if (!match) {
    throw new Error(`"${text}" is not one number and one unit`);
  }
  const symbol = match[2] === undefined ? "1" : match[2].trim();
  if (symbol === "1" && column.dimension !== "number") {
    throw new Error(`"${text}" has no unit, such as ${text} ${column.unit}`);
  }
  const unit = Object.hasOwn(page.units, symbol) ? page.units[symbol] : null;
  if (!unit || unit[0] !== column.dimension) {
    const example = column.unit ? `, such as ${column.unit}` : "";
    throw new Error(`"${symbol}" is not a unit of ${column.name}${example}`);
  }
  const number = (Number(match[1]) * unit[1]) / column.factor; // unit: dimension, factor to SI
  if (column.isResult) {
    return Math.fround(number);
  }
  return valueMeant(number, (halfDigit(match[1]) * unit[1]) / column.factor, column.stated);
}

// Returns half of the last significant digit of a number as it is written, 0.005 of "33.33"; that
// of the fourth digit if fewer are written, and 0 of zero.
function halfDigit(text) {
  const [mantissa, power] = text.toLowerCase().replace(/^[+-]/, "").split("e");
  const [whole, decimals = ""] = mantissa.split(".");
  const digits = (whole + decimals).replace(/^0+/, "");
  if (!digits) {
    return 0;
  }
  const exponent = Number(power || 0) - decimals.length;
  const last = Math.min(exponent, exponent + digits.length - PRINTED_DIGITS);
  return Number(`0.5e${last}`);
}

// Returns the value of an axis that a number means: the one that it states, or else the only one
// that rounds to it; the number itself if it means none.
function valueMeant(number, rounding, values) {
  let nearest = NaN;
  const rounded = new Set();
  for (const value of values) {
    const distance = Math.abs(value - number);
    if (!(distance >= Math.abs(nearest - number))) {
      nearest = value;
    }
    if (distance <= rounding) {
      rounded.add(value);
    }
  }
  if (Math.abs(nearest - number) <= ROUNDING * Math.abs(number)) {
    return nearest;
  }
  return rounded.size === 1 ? [...rounded][0] : number;
}

// Returns true if a row passes a filter; a row without a value passes none.
function passes(row, { column, sign, wanted }) {
  const value = column.compared(row);
  if (value === "" || Number.isNaN(value)) {
    return false;
  }
  if (sign === "!=") {
    return !wanted.includes(value);
  }
  if (sign === "in") {
    return wanted.includes(value);
  }
  return RELATIONS[sign](value, wanted[0]);
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
  const { value } = listed.sort;
  const direction = listed.falling ? -1 : 1;
  return rows.sort((first, second) => {
    const a = value(first);
    const b = value(second);
    const missing = Number(Number.isNaN(a)) - Number(Number.isNaN(b));
    return missing || direction * compareValues(a, b);
  });
}

// Makes the head of a column, a button that sorts by it: rising first, then falling. `place` is its
// number among the columns that are shown.
function makeHead(column, place) {
  const isSorted = listed.sort === column;
  let order = "none";
  let mark = "";
  if (isSorted) {
    order = listed.falling ? "descending" : "ascending";
    mark = listed.falling ? " ▼" : " ▲";
  }
  const press = () => {
    listed.falling = isSorted && !listed.falling;
    listed.sort = column;
    drawTable();
    byId("list").querySelectorAll("th button")[place].focus();
  };
  const button = make("button", { type: "button", onclick: press }, titleOf(column) + mark);
  return make("th", { scope: "col", "aria-sort": order }, button);
}

// Returns a value of a column as a text.
function cellText(column, value) {
  if (value === Infinity && column.dimension === "stiffness") {
    return "rigid";
  }
  return typeof value === "string" ? value : formatNumber(value);
}

function drawTable() {
  const rows = rowsOfTable();
  const columns = listed.columns.filter((column) => !column.hidden);
  const marked = new Set(view.brushed);
  const body = rows.slice(0, listed.count).map((row) => {
    const cells = columns.map((column) => make("td", {}, cellText(column, column.value(row))));
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
