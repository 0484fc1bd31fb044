"""What is done with a hostile file: all that a command would do with it."""

import contextlib
import hashlib
import json


def try_study(file):
    """What a command does with a study before it computes anything, and one state."""
    from tendon_cli.engine.plan import Plan
    from tendon_cli.state_page.page import state_page
    from tendon_cli.studies.load import load_study

    study = load_study(file)
    plan = Plan(study)
    json.dumps(study.record)
    _ = plan.designs, plan.states, plan.parts, study.hash, study.document()
    json.dumps(state_page(study, study.cases[0].name if study.cases else None).record)


def try_fit(file):
    """Fit, and say it in both ways; then with the second column as the motor's."""
    from tendon_cli import friction
    from tendon_cli.errors import TendonError

    fit = friction.fit_friction(file, bend_angle=angle_of(file))
    json.dumps(fit.record)
    friction.summary_lines(fit)
    with contextlib.suppress(TendonError):
        json.dumps(friction.fit_friction(file, motor="2").record)


def angle_of(file):
    """A bend angle for readings that have no column of it."""
    return None if b"bend" in file.read_bytes()[:200] else "144 deg"


def try_plot(file):
    """What `plot` reads and lays out of a table, for both kinds of figures; one file in 32 is drawn."""
    from tendon_cli.cube.cube import cube_of
    from tendon_cli.figures.curve_data import curve_data
    from tendon_cli.figures.draw import plot
    from tendon_cli.figures.layout import long_axes, plan_curves, plan_maps
    from tendon_cli.figures.map_data import map_data
    from tendon_cli.studies.figures import figure_spec
    from tendon_cli.tables.read import open_table

    table = open_table(file)
    _ = table.facts, table.rows, table.schema
    table.read()
    cube = cube_of(table)
    chosen, spec = cube.choose([]), figure_spec()
    if cube.kind == "designs" and len(long_axes(cube, chosen)) > 1:
        map_data(cube, plan_maps(cube, chosen), spec)
    if hashlib.sha256(file.read_bytes()).digest()[0] < 8:
        plot(cube.files, spec, file.with_name("figure.png"))
    curve_data(cube, plan_curves(cube, chosen, spec), [], spec)


ATTEMPTS = {"toml": try_study, "yaml": try_study, "csv": try_fit, "parquet": try_plot}
"""For each ending."""
