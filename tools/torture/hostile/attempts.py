"""Attempts on a hostile file: all that a command would do with it."""

import contextlib
import hashlib
import json


def try_study(file):
    """Do with a study all that a command does before it computes anything, and compute a state."""
    from tendon_cli.engine.plan import Plan
    from tendon_cli.state_page.page import state_page
    from tendon_cli.studies.load import load_study

    study = load_study(file)
    plan = Plan(study)
    json.dumps(study.record)
    _ = plan.designs, plan.states, plan.parts, study.hash, study.document()
    case = study.cases.names[0] if study.cases else None
    json.dumps(state_page(study, case).record)


def try_fit(file):
    """Fit and print in both ways; then fit with the second column as the motor's."""
    from tendon_cli.errors import TendonError
    from tendon_cli.fits import friction

    fit = friction.fit_friction(file, bend_angle=angle_of(file))
    json.dumps(fit.record)
    _ = fit.text
    with contextlib.suppress(TendonError):
        json.dumps(friction.fit_friction(file, motor="2").record)


def angle_of(file):
    """Return a bend angle for readings that have no column of it, else None."""
    return None if b"bend" in file.read_bytes()[:200] else "144 deg"


def try_plot(file):
    """Read a table and lay it out as `plot` does, in both kinds of figures; draw one file in 32."""
    from tendon_cli.cube.cube import cube_of
    from tendon_cli.figures.curves import curve_data
    from tendon_cli.figures.draw import plot
    from tendon_cli.figures.layout import map_axes, plan_curves
    from tendon_cli.figures.slices import grid_of
    from tendon_cli.studies.figures import figure_spec
    from tendon_cli.tables.read import open_table

    table = open_table(file)
    _ = table.facts, table.rows, table.schema
    table.read()
    cube = cube_of(table)
    chosen = cube.choose([])
    spec = figure_spec()
    axes = map_axes(cube, chosen)
    if cube.kind == "designs" and axes is not None:
        cube.gather(grid_of(cube, axes, chosen, 175.0).rows, ["margin"])
    if hashlib.sha256(file.read_bytes()).digest()[0] < 8:
        plot(cube.table, spec, file.with_name("figure.png"))
    curve_data(cube, plan_curves(cube, chosen, spec), [], spec)


ATTEMPTS = {"toml": try_study, "yaml": try_study, "csv": try_fit, "parquet": try_plot}
"""Attempt for each ending."""
