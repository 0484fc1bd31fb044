"""A scheduler or a worker in a process of its own, forked from one that has imported everything."""

import multiprocessing
import os

FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(
    [
        "pytest",
        "distributed.cli.dask_scheduler",
        "distributed.cli.dask_worker",
        "tendon_cli.answers.choices",
        "tendon_cli.engine.cluster.worker",
        "tendon_cli.engine.sweep",
    ]
)
ALLOWED_FAILURES = 1
"""Workers that may die of a part before the scheduler sends it out no more."""


def start(role, words, folder, log, environment):
    """Start a scheduler or a worker in a folder. Return its process."""
    process = FORKS.Process(target=_run, args=(role, words, folder, log, environment))
    process.start()
    return process


def _run(role, words, folder, log, environment):
    os.setsid()
    os.chdir(folder)
    os.environ.update(environment)
    with log.open("w", encoding="utf-8") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    import dask
    from distributed.cli import dask_scheduler, dask_worker

    dask.config.set({"distributed.scheduler.allowed-failures": ALLOWED_FAILURES})
    main = {"scheduler": dask_scheduler.main, "worker": dask_worker.main}[role]
    main(words)
