"""Workers and schedulers that die, cannot be reached, or are not fit."""

import os
import signal
import socket
import sys
import threading
import time
from pathlib import Path

import pytest

from tendon_cli.engine.cluster import flight

from .conftest import PARTS, SWEEP, in_background, leftovers, recorded, wait_for

pytest.importorskip("distributed", reason="distributed is not installed")


# --- Workers that die -----------------------------------------------------------------------------


def test_the_parts_of_a_worker_that_is_killed_are_made_by_another(
    tendon, study, start_cluster, local, hashes_in
):
    cluster = start_cluster(2, slow=0.3)

    def kill():
        wait_for(lambda: recorded() >= 2, OSError)
        os.kill(cluster.workers[0].pid, signal.SIGKILL)

    killer = in_background(kill)
    ran = tendon(*SWEEP, "--json", "--scheduler", cluster.address)
    killer.join()
    assert (ran.exit, ran.err) == (0, "")
    cluster.workers[0].join(5)
    assert cluster.workers[0].exitcode == -signal.SIGKILL
    assert hashes_in(Path("run")) == local.hashes
    assert leftovers() == []


def test_a_part_that_kills_every_worker_is_named_and_the_others_are_kept(
    tendon, study, start_cluster, local, hashes_in
):
    cluster = start_cluster(5, kill=12)
    ran = tendon(*SWEEP, "--json", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["error"]["kind"]) == (6, "workers"), ran.out
    message = ran.json["error"]["message"]
    assert "1 of 13 parts failed" in message
    assert "part 4 (designs 12 to 14" in message
    assert "tendon.pretension=120" in message
    assert "workers died of it" in message
    assert recorded() == PARTS - 1
    assert leftovers() == []
    cluster.set()
    ran = tendon(*SWEEP, "--resume", "--json", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["resumed_parts"]) == (0, PARTS - 1)
    assert hashes_in(Path("run")) == local.hashes


def test_a_cluster_without_workers_ends_the_run(tendon, study, start_cluster, monkeypatch):
    cluster = start_cluster(1, kill=12)
    monkeypatch.setattr(flight, "PATIENCE", 0.5)
    ran = tendon(*SWEEP, "--json", "--jobs", "1", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["error"]["kind"]) == (6, "workers")
    message = ran.json["error"]["message"]
    assert "no worker is left; 1 parts were being computed: part 4 (designs 12" in message
    assert recorded() == 4
    monkeypatch.setattr(flight, "CONNECT", 1.0)
    ran = tendon(*SWEEP, "--json", "--resume", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["error"]["message"]) == (6, "the cluster has no workers")
    assert tendon(*SWEEP, "--resume").exit == 0


def test_a_scheduler_that_is_killed_ends_the_run(tendon, study, start_cluster, local, hashes_in):
    cluster = start_cluster(1, slow=0.3)
    killed = []

    def kill():
        wait_for(lambda: recorded() >= 2, OSError)
        os.kill(cluster.scheduler.pid, signal.SIGKILL)
        killed.append(time.monotonic())

    killer = in_background(kill)
    ran = tendon(*SWEEP, "--scheduler", cluster.address)
    assert time.monotonic() - killed[0] < 40  # only what hangs needs it
    killer.join()
    assert ran.exit == 6
    message = f"tendon: error: {cluster.address}: the scheduler went away"
    assert ran.err.splitlines()[-2].startswith(message)
    assert "--resume continues" in ran.err
    assert 2 <= recorded() < PARTS
    assert tendon(*SWEEP, "--resume").exit == 0
    assert hashes_in(Path("run")) == local.hashes


# --- Workers that are not fit ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("hazard", "words"),
    [({"old": "1.0"}, "pyarrow 1.0 instead of"), ({"blind": "1"}, "does not see the run folder")],
)
def test_a_worker_that_is_not_fit_is_named(tendon, study, start_cluster, hazard, words):
    cluster = start_cluster(1, **hazard)
    ran = tendon(*SWEEP, "--json", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["error"]["kind"]) == (6, "workers")
    assert words in ran.json["error"]["message"]
    assert f"worker {socket.gethostname()}" in ran.json["error"]["where"]
    assert not list(Path().rglob("*.parquet/*"))
    assert Path("run").exists() == ("blind" in hazard)


def test_a_worker_that_comes_later_and_is_not_fit_ends_the_run(tendon, study, start_cluster):
    # All parts but the first are held back until the run is ended, however late the worker comes.
    cluster = start_cluster(1, hold="0")

    def add():
        wait_for(lambda: recorded() >= 1, OSError)
        cluster.set_more(old="1.0")
        cluster.add_workers(1)

    adder = in_background(add)
    ran = tendon(*SWEEP, "--json", "--scheduler", cluster.address)
    adder.join()
    assert ran.exit == 6
    assert "pyarrow 1.0 instead of" in ran.json["error"]["message"]
    assert recorded() == 1
    assert leftovers() == []


# --- Addresses ------------------------------------------------------------------------------------

MALFORMED = [
    "localhost:8786",
    "tcp://",
    "tcp://host",
    "tcp://host:0",
    "tcp://host:65536",
    "http://host:1",
    "inproc://1/2/3",
    "tcp://host:1/path",
    "tcp://us er:1",
    "",
    "tcp://host:1\n",
    "tcp://host:\u0661",
]


@pytest.mark.parametrize("address", MALFORMED)
def test_a_malformed_address_is_a_wrong_call(tendon, study, address):
    ran = tendon(*SWEEP, "--json", "--scheduler", address)
    assert (ran.exit, ran.json["error"]["kind"]) == (2, "usage")
    assert "tcp://10.0.0.1:8786" in ran.json["error"]["hint"]
    assert not Path("run").exists()


@pytest.fixture
def listener():
    """Yield a socket that listens and is no scheduler."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server


def answer(server):
    """Answer two connections as a web server would."""
    for _ in range(2):
        connection, _ = server.accept()
        with connection:
            connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" * 9)


@pytest.mark.parametrize("words", ["Connection refused", "within 1 s", "something else does"])
def test_an_address_where_no_scheduler_answers_is_exit_6(
    tendon, study, listener, monkeypatch, words
):
    before = {thread.name for thread in threading.enumerate()}
    assert flight.CONNECT < 10
    address = f"tcp://127.0.0.1:{listener.getsockname()[1]}"
    answering = None
    if words == "Connection refused":
        listener.close()
    elif words == "within 1 s":
        monkeypatch.setattr(flight, "CONNECT", 1.0)
    else:
        answering = in_background(lambda: answer(listener))
    ran = tendon(*SWEEP, "--scheduler", address)
    if answering is not None:
        answering.join()
    assert ran.exit == 6
    assert ran.err.startswith(f"tendon: error: {address}: no Dask scheduler answers")
    assert words in ran.err
    assert len(ran.err.splitlines()) == 2
    assert not Path("run").exists()
    assert {thread.name for thread in threading.enumerate()} - before == set()


def test_without_the_extra_it_says_what_to_install(tendon, study, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    ran = tendon(*SWEEP, "--json", "--scheduler", "tcp://127.0.0.1:8786")
    assert (ran.exit, ran.json["error"]["kind"]) == (2, "usage")
    assert "-m pip install distributed" in ran.json["error"]["hint"]
