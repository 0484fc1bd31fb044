// The table of designs or choices: sorted by any column, filtered by comparisons.

const listed = { sort: null, falling: false, filters: [], count: 100, columns: [] };

async function columnsOfTable() {
  const columns = [];
  for (const column of page.table.columns) {
    if (column.axis !== undefined) {
      const axis = page.axes[column.axis];
      const at = (row) => Math.floor(row / strides[column.axis]) % lengthOf(axis);
      columns.push({ ...axis, value: (row) => (axis.names ? axis.names[at(row)] : axis.values[at(row)]) });
    } else if (column.texts) columns.push({ ...column, value: (row) => column.texts[row] });
    else {
      const like = column.array ? column : page.quantities[column.quantity];
      const values = await unpack(like.array);
      columns.push({ ...like, value: (row) => (like.classes ? classOf(like.classes, values[row]) : values[row]) });
    }
  }
  return columns;
}

// The filters of the command line: "margin > 5 N; load_mass in 3 kg, 5 kg; taut = yes". A number without a unit is in that of its column.
const TRUTHS = { yes: 1, true: 1, 1: 1, no: 0, false: 0, 0: 0 };

function parseFilters(text) {
  return text.split(";").map((each) => each.trim()).filter(Boolean).map((part) => {
    const match = part.match(/^(.+?)\s*(<=|>=|!=|==|=|<|>|\sin(?=\s|\[))\s*(.+)$/);
    if (!match) throw new Error(`"${part}" is not a filter such as "${listed.columns[0].label} > 5"`);
    const [sign, column] = [match[2].trim().replace("==", "="), columnNamed(match[1])];
    const values = sign === "in" ? match[3].replace(/^\[|\]$/g, "").split(",") : [match[3]];
    return { column, sign, wanted: values.map((value) => wantedOf(column, value.trim(), sign)) };
  });
}

function columnNamed(text) {
  const wanted = text.trim().toLowerCase();
  const words = wanted.replaceAll("_", " ");
  const known = listed.columns;
  const column = known.find((each) => each.name === wanted || each.key === wanted) || known.find((each) => each.label.toLowerCase() === words) || known.find((each) => each.label.toLowerCase().startsWith(words));
  if (!column) throw new Error(`no column is called "${text.trim()}"; the heads of the columns are their names`);
  return column;
}

function wantedOf(column, text, sign) {
  if (column.truth) {
    if (!(text.toLowerCase() in TRUTHS) || "<>".includes(sign[0])) throw new Error(`${column.label} is yes or no`);
    return TRUTHS[text.toLowerCase()];
  }
  if (column.texts || column.names || column.classes) return text.replace(/^["'](.*)["']$/, "$1");
  const match = text.match(/^([-+−]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)$/);
  if (!match) throw new Error(`"${text}" is not a number`);
  const value = Number(match[1].replace("−", "-"));
  if (match[2] === "") return value;
  const unit = page.units[match[2]];
  if (!unit || unit[0] !== column.dimension) throw new Error(`"${match[2]}" is no unit of ${column.label}${column.unit ? `, such as ${column.unit}` : ""}`);
  return (value * unit[1]) / column.factor;
}

function passes(row, { column, sign, wanted }) {
  const value = column.value(row);
  const close = (each) => (typeof value === "string" ? value === each : Math.abs(value - each) <= 1e-3 * Math.abs(each) + 1e-9);
  if (typeof value !== "string" && !Number.isFinite(value)) return false;
  if (sign === "=" || sign === "in") return wanted.some(close);
  if (sign === "!=") return !wanted.some(close);
  const near = Math.abs(value - wanted[0]) <= 1e-9 * Math.abs(wanted[0]);
  const beyond = sign[0] === "<" ? value < wanted[0] : value > wanted[0];
  return sign.endsWith("=") ? beyond || near : beyond && !near;
}

function rowsOfTable() {
  const rows = Array.from({ length: page.table.rows }, (_, row) => row).filter((row) => listed.filters.every((filter) => passes(row, filter)));
  if (listed.sort !== null) {
    const { value } = listed.columns[listed.sort];
    const sign = listed.falling ? -1 : 1;
    const order = (a, b) => (typeof a === "string" ? a.localeCompare(b) : (Number.isNaN(a) ? 1 : 0) - (Number.isNaN(b) ? 1 : 0) || sign * (a - b));
    rows.sort((a, b) => (typeof value(a) === "string" ? sign : 1) * order(value(a), value(b)));
  }
  return rows;
}

function drawTable() {
  const rows = rowsOfTable();
  const seen = listed.columns.filter((column) => !column.hidden);
  const head = seen.map((column, at) => {
    const sorted = listed.sort === at ? (listed.falling ? "descending" : "ascending") : "none";
    const mark = { ascending: " ▲", descending: " ▼", none: "" }[sorted];
    const press = () => { listed.falling = listed.sort === at && !listed.falling; listed.sort = at; drawTable(); place("list").querySelectorAll("th button")[at].focus(); };
    return make("th", { scope: "col", "aria-sort": sorted }, make("button", { type: "button", onclick: press }, named(column) + mark));
  });
  const cells = (row) => seen.map((column) => make("td", {}, typeof column.value(row) === "string" ? column.value(row) : number(column.value(row))));
  const marked = new Set(view.brushed);
  const body = rows.slice(0, listed.count).map((row) => make("tr", { class: marked.has(row) && "marked" }, ...cells(row)));
  place("list").replaceChildren(make("table", {}, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...body)));
  place("list-says").textContent = `${Math.min(rows.length, listed.count)} of ${rows.length} rows that pass, of ${page.table.rows}`;
  place("more").hidden = rows.length <= listed.count;
}

async function startTable() {
  if (!page.table) return;
  listed.columns = await columnsOfTable();
  place("more").addEventListener("click", () => { listed.count += 400; drawTable(); });
  if (page.design) place("mark").addEventListener("click", () => brush(listed.filters.length ? rowsOfTable() : null));
  else place("mark").remove();
  place("filter").addEventListener("input", (event) => {
    try {
      listed.filters = parseFilters(event.target.value);
      place("filter-fault").textContent = "";
      drawTable();
    } catch (fault) {
      place("filter-fault").textContent = fault.message; // the rows stay as they were until it is one
    }
  });
  drawTable();
}
