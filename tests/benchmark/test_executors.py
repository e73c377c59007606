"""A cluster gives the same runs; whoever is killed leaves no process behind and loses no run that had ended."""

import gc
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from made_up import outcomes

import robolaser
from robolaser import load_comparison
from robolaser.benchmark import executors
from robolaser.benchmark.executors import Processes, WorkerLost
from robolaser.cli import main
from robolaser.errors import BenchmarkError

HERE = Path(__file__).parent


def test_a_dask_cluster_makes_the_same_runs():
    distributed = pytest.importorskip("distributed")
    asked = {"problems": ["pymoo:sphere-3"], "algorithms": ["de", "random"], "seeds": 2, "budget": 200}
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        there = robolaser.compare(**asked, scheduler=cluster.scheduler_address)
    assert outcomes(there) == outcomes(robolaser.compare(**asked, jobs=1))
    assert there.workers == 1


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense", "tcp://127.0.0.1", "foo://127.0.0.1:1"])
def test_a_cluster_that_does_not_answer_is_named_and_nothing_lingers(address, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr("robolaser.benchmark.executors.CONNECT_S", 0.5)
    with pytest.raises(BenchmarkError, match=rf"at {re.escape(address)} \("):
        robolaser.compare(["pymoo:sphere-3"], ["random"], seeds=1, budget=10, scheduler=address)
    left = [one for one in gc.get_objects() if type(one) is distributed.Client and one.status != "closed"]
    assert not left


def test_a_process_that_is_ended_while_it_starts_ends():
    processes = Processes(1)
    asked = processes.submit(time.sleep, 60)
    began = time.monotonic()
    while not executors._START.locked():
        time.sleep(0.001)
    processes.shutdown()
    with pytest.raises(WorkerLost):
        asked.result()
    assert time.monotonic() - began < 30


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_killed_comparison_leaves_no_process_and_is_resumed(tmp_path):
    typed = ["compare", "mine:Slow:seconds=0.02", "--algorithms", "random", "--seeds", "6", "--budget", "30"]
    command = [sys.executable, "-m", "robolaser", *typed, "--output", str(tmp_path), "--jobs", "1"]
    process = subprocess.Popen(command, cwd=HERE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.monotonic() + 120
    while time.monotonic() < until and not (
        (tmp_path / "runs.jsonl").exists() and len((tmp_path / "runs.jsonl").read_text().splitlines()) > 2
    ):
        time.sleep(0.05)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    workers = [int(pid) for pid in children.read_text().split()] if children.exists() else []
    process.send_signal(signal.SIGKILL)
    process.wait()
    before = outcomes(load_comparison(tmp_path))
    assert 0 < len(before) < 6
    assert main([*typed, "--output", str(tmp_path), "--jobs", "1", "--resume"]) == 0
    after = outcomes(load_comparison(tmp_path))
    assert len(after) == 6
    assert before.items() <= after.items()
    assert not [pid for pid in workers if _runs(pid)]


def _runs(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return "Z" not in Path(f"/proc/{pid}/stat").read_text().split()[2]
