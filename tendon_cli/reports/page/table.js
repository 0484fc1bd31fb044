// The table of designs or choices: sorted by any column, filtered by comparisons.

const listed = { sort: null, falling: false, filters: [], brushedOnly: false, count: 100, columns: [] };

async function columnsOfTable() {
  const columns = [];
  for (const column of page.table.columns) {
    if (column.axis !== undefined) {
      const axis = page.axes[column.axis];
      const at = (row) => Math.floor(row / strides[column.axis]) % lengthOf(axis);
      columns.push({ ...column, label: axis.label, unit: axis.unit, value: (row) => (axis.names ? axis.names[at(row)] : axis.values[at(row)]) });
    } else if (column.texts) columns.push({ ...column, value: (row) => column.texts[row] });
    else {
      const values = await unpack(column.array || page.quantities[column.quantity].array);
      const like = column.array ? column : page.quantities[column.quantity];
      const told = like.classes ? (row) => (like.classes[values[row]] || { label: "none" }).label : (row) => values[row];
      columns.push({ label: like.label, unit: like.unit, value: told });
    }
  }
  return columns;
}

// "margin > 5; load mass = 3": each names a column by the beginning of its label.
function parseFilters(text) {
  const found = [];
  for (const part of text.split(";").map((each) => each.trim()).filter(Boolean)) {
    const match = part.match(/^(.+?)\s*(<=|>=|!=|=|<|>)\s*(.+)$/);
    if (!match) throw new Error(`"${part}" is not a comparison such as "${listed.columns[0].label} > 5"`);
    const wanted = match[1].toLowerCase();
    const column = listed.columns.find((each) => each.label.toLowerCase() === wanted) || listed.columns.find((each) => each.label.toLowerCase().startsWith(wanted));
    if (!column) throw new Error(`no column starts with "${match[1]}"`);
    found.push({ column, sign: match[2], value: match[3] });
  }
  return found;
}

function passes(row, filter) {
  const value = filter.column.value(row);
  const text = typeof value === "string";
  const [a, b] = text ? [value, filter.value] : [value, Number(filter.value)];
  switch (filter.sign) {
    case "=": return text ? a === b : Math.abs(a - b) <= 1e-6 * Math.abs(b);
    case "!=": return text ? a !== b : !(Math.abs(a - b) <= 1e-6 * Math.abs(b));
    case "<": return a < b;
    case ">": return a > b;
    case "<=": return a <= b;
    default: return a >= b;
  }
}

function rowsOfTable() {
  const grid = page.table.cells; // the cell of each row; null where rows are cells
  const marked = view.brushed ? new Set(view.brushed) : null;
  const rows = [];
  for (let row = 0; row < page.table.rows; row++) {
    if (listed.brushedOnly && marked && !marked.has(grid ? grid[row] : row)) continue;
    if (listed.filters.every((filter) => passes(row, filter))) rows.push(row);
  }
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
  const head = listed.columns.map((column, at) => {
    const sorted = listed.sort === at ? (listed.falling ? "descending" : "ascending") : "none";
    const mark = { ascending: " ▲", descending: " ▼", none: "" }[sorted];
    const press = () => { listed.falling = listed.sort === at && !listed.falling; listed.sort = at; drawTable(); place("list").querySelectorAll("th button")[at].focus(); };
    return make("th", { scope: "col", "aria-sort": sorted }, make("button", { type: "button", onclick: press }, named(column) + mark));
  });
  const cells = (row) => listed.columns.map((column) => make("td", {}, typeof column.value(row) === "string" ? column.value(row) : number(column.value(row))));
  const body = rows.slice(0, listed.count).map((row) => make("tr", {}, ...cells(row)));
  place("list").replaceChildren(make("table", {}, make("thead", {}, make("tr", {}, ...head)), make("tbody", {}, ...body)));
  place("list-says").textContent = `${Math.min(rows.length, listed.count)} of ${rows.length} rows that pass, of ${page.table.rows}`;
  place("more").hidden = rows.length <= listed.count;
}

async function startTable() {
  if (!page.table) return;
  listed.columns = await columnsOfTable();
  place("more").addEventListener("click", () => { listed.count += 400; drawTable(); });
  place("filter").addEventListener("change", (event) => {
    try {
      listed.filters = parseFilters(event.target.value);
      place("filter-fault").textContent = "";
    } catch (fault) {
      place("filter-fault").textContent = fault.message;
    }
    drawTable();
  });
  place("brushed-only").addEventListener("change", (event) => { listed.brushedOnly = event.target.checked; drawTable(); });
  drawTable();
}
