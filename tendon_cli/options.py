"""The options of the commands, each with its name, its placeholder and its help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

StudyFile = Annotated[Path, typer.Argument(metavar="STUDY", help="study file, TOML or YAML")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="override a key, such as 'arm.b1=160 mm'; repeatable"),
]
AsJson = Annotated[bool, typer.Option("--json", help="print exactly one JSON object")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="print nothing but errors")]
Jobs = Annotated[int | None, typer.Option(min=1, help="parts computed at once; default all cores")]
OutFile = Annotated[Path | None, typer.Option(metavar="FILE", help="file or folder to write to")]

# init, state, sweep
StarterFile = Annotated[Path, typer.Argument(metavar="[FILE]", help="TOML or YAML, by its ending")]
Case = Annotated[str | None, typer.Option(help="which of the study's cases")]
RunFolderName = Annotated[Path | None, typer.Option(metavar="DIR", help="run folder; default results/<name>")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="show size and cost, write nothing")]
Resume = Annotated[bool, typer.Option("--resume", help="finish an interrupted run")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace the run that stands in the folder")]
NoFigures = Annotated[bool, typer.Option("--no-figures", help="draw nothing")]
NoLock = Annotated[bool, typer.Option("--no-lock", help="for file systems that cannot lock")]
AllowNoEquilibrium = Annotated[
    bool, typer.Option("--allow-no-equilibrium", help="exit 0 although states have no equilibrium")
]
Scheduler = Annotated[str | None, typer.Option(metavar="tcp://HOST:PORT", help="compute on this running Dask cluster")]

# plot
Source = Annotated[
    Path, typer.Argument(metavar="RUN_OR_TABLE", help="a run folder, or any one of its tables; a study with --arm")
]
DrawsArm = Annotated[bool, typer.Option("--arm", help="draw the arm of a study to scale, and the route of its sheath")]
TableName = Annotated[str | None, typer.Option(metavar="states|designs", help="which table of a run folder")]
Quantities = Annotated[
    list[str] | None, typer.Option("--quantity", "-y", metavar="COLUMN", help="what to draw; repeatable")
]
Against = Annotated[str | None, typer.Option("--x", "-x", metavar="COLUMN", help="what to draw it against")]
Colour = Annotated[str | None, typer.Option(metavar="AXIS", help="axis with a colour per value")]
Panels = Annotated[str | None, typer.Option(metavar="AXIS", help="axis with a panel per value")]
Where = Annotated[list[str] | None, typer.Option(metavar="FILTER", help="such as 'load_mass = 5 kg'; repeatable")]
Units = Annotated[list[str] | None, typer.Option(metavar="UNIT", help="show its dimension in it, such as cm")]
Angles = Annotated[list[str] | None, typer.Option(metavar="ANGLE", help="with --arm: elbow angle to draw")]
Format = Annotated[str, typer.Option("--format", metavar="png|svg|pdf", help="format of the figure")]
Size = Annotated[str, typer.Option(metavar="SIZE", help="column, page, '120 mm' or '120 x 80 mm'")]

# fit-friction
Readings = Annotated[
    Path, typer.Argument(metavar="CSV", help="readings of two load cells, one at each end of a sheath")
]
BendAngle = Annotated[
    str | None, typer.Option(metavar="ANGLE", help="total bend of the sheath: '144 deg' or '144 deg +/- 2 deg'")
]
FirstCell = Annotated[str | None, typer.Option(metavar="COLUMN", help="column of the first load cell")]
SecondCell = Annotated[str | None, typer.Option(metavar="COLUMN", help="column of the second load cell")]
MotorCell = Annotated[str | None, typer.Option(metavar="1|2", help="which cell is at the motor's end")]
FitsOffset = Annotated[bool, typer.Option("--offset", help="fit a zero offset of each cell, too")]
IsRobust = Annotated[bool, typer.Option("--robust", help="let outliers weigh less")]
FitFigure = Annotated[Path | None, typer.Option(metavar="FILE", help="draw readings and fit: .png, .svg, .pdf")]
Fragment = Annotated[Path | None, typer.Option(metavar="FILE", help="write a fragment for [sheath] friction_from")]

# paper
PaperFolder = Annotated[Path, typer.Option(metavar="DIR", help="where to")]
