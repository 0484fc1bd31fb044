"""Table A.1 as people type it."""

from __future__ import annotations

TABLE = """case,load_cell_1_kg,load_cell_2_kg
1,1.236,1.028
1,1.236,1.027
1,1.236,1.028
2,0.858,1.036
2,0.858,1.036
2,0.857,1.036
"""
GERMAN = TABLE.replace(",", ";").replace(".", ",")
GRAMS = (
    TABLE.replace("load_cell_1_kg,load_cell_2_kg", "cell 1 (g),cell 2 (kg)")
    .replace(",1.236", ",1236")
    .replace(",0.", ",")
)
BARE_ROWS = TABLE.split("\n", 1)[1]
CELLS_ONLY = "\n".join(line.split(",", 1)[1] for line in TABLE.splitlines()) + "\n"
NAMED = TABLE.replace("case", "direction").replace("\n1,", "\nup,").replace("\n2,", "\ndown,")
