"""Kind of the task of a sweep: record, tables, who runs, checks and draws it."""

from tendon_cli.verbs.registry import FlagOption, TableKind, TaskKind

DEFINING = (
    "pretension",
    "spring_stiffness",
    "spool_ratio",
    "load_mass",
    "friction",
    "bend_angle",
)
"""Columns that every table of a sweep has, and that say what a design is."""

SWEEP = TaskKind(
    verb="sweep",
    help="Run every combination of a study's values; write Parquet tables and slack maps.",
    noun="a sweep",
    record="run.json",
    counts=(
        "designs",
        "states",
        "feasible",
        "slack",
        "no_equilibrium",
        "unstable",
        "parts",
        "resumed_parts",
    ),
    tables=(
        TableKind("designs", axes="tendon_cli.cube.axes.design_axes", always=DEFINING),
        TableKind("states", axes="tendon_cli.cube.axes.state_axes", always=DEFINING),
    ),
    task="tendon_cli.engine.sweep.Sweep",
    result="tendon_cli.engine.results.Run",
    size="tendon_cli.engine.cost.size_of_sweep",
    draw="tendon_cli.figures.draw.draw_run",
    check_figures="tendon_cli.figures.draw.check_figures_of",
    check="tendon_cli.checks.check.check_run",
    compare="tendon_cli.checks.compare_runs.compare_runs",
    page="tendon_cli.reports.report.sweep_page",
    allow_negative=FlagOption(
        "--allow-no-equilibrium", "exit 0 even if states have no equilibrium"
    ),
)
