import http.server
import json
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, Future
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from distributed import KilledWorker
from rogues import spec

from robolaser.benchmark import load
from robolaser.benchmark.engines import DaskCluster, Engine, EngineLost, ThisMachine
from robolaser.benchmark.engines import dask_cluster as cluster_module
from robolaser.benchmark.single_run import DONE, FAILED, BenchmarkRun, Task
from robolaser.cli import main
from robolaser.errors import BenchmarkError, DependencyMissing

PAYLOAD = pickle.dumps(spec())
FAIRLY = [
    Task("bowl", f"rogues:{name}", seed, 200, 60.0, 400_000_000) for seed in (1, 2, 3) for name in ("walks", "dawdles")
]
WAITS = Task("bowl", "rogues:waits", 1, 200, 60.0, 400_000_000)
SOON_S = 60.0
"""On a busy machine all comes, if late."""
AT_ONCE_S = WAITS.time_limit_s / 2
"""Whoever comes back by then has not waited for what runs."""
QUICK_S = 20.0
"""By itself, distributed would wait for half a minute."""
ANSWER_S = cluster_module.ANSWER_S


def _runs(engine: Engine, tasks: list[Task]) -> list[BenchmarkRun]:
    payload = engine.share(PAYLOAD)
    return [future.result(SOON_S) for future in [engine.submit(task, payload) for task in tasks]]


def _known(run: BenchmarkRun) -> tuple[object, ...]:
    trace = run.trace
    return (
        run.problem, run.algorithm, run.seed, run.state, run.reason, run.evaluations,
        trace.evaluations.tolist(), trace.costs.tolist(),
    )  # fmt: skip


def _below(pid: int) -> dict[int, str]:
    """Command lines of all processes that a process has started, and those have started."""
    said = subprocess.run(["ps", "-wwAo", "pid,ppid,args"], capture_output=True, text=True, check=True).stdout
    rows = [line.split(None, 2) for line in said.splitlines()[1:]]
    below: dict[int, str] = {}
    parents = {pid}
    while parents:
        found = {int(row[0]): row[2] for row in rows if int(row[1]) in parents and len(row) == 3}
        below |= found
        parents = set(found)
    return below


def _children(pid: int) -> set[int]:
    return {one for one, command in _below(pid).items() if "robolaser.benchmark.engines.worker" in command}


def _eventually(holds: Callable[[], object], within_s: float = SOON_S) -> bool:
    until = time.monotonic() + within_s
    while not holds():
        if time.monotonic() > until:
            return False
        time.sleep(0.02)
    return True


def _there(pid: int) -> bool:
    said = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False).stdout
    return said.strip()[:1] not in ("", "Z")


class Cluster:
    """A scheduler and its workers, each a process."""

    def __init__(self, folder: Path) -> None:
        self._stack = ExitStack()
        self._folder = folder
        self._file = folder / "scheduler.json"
        self._start("dask_scheduler", "--port", "0", "--host", "127.0.0.1", "--scheduler-file", str(self._file))
        assert _eventually(lambda: self._file.exists() and '"address"' in self._file.read_text())
        self.address = self._file.read_text().split('"address": "')[1].split('"')[0]
        self.workers = [self.worker(), self.worker()]

    def worker(self) -> int:
        return self._start("dask_worker", "--scheduler-file", str(self._file), "--nthreads", "1", "--no-nanny").pid

    def close(self) -> None:
        self._stack.close()

    def _start(self, module: str, *arguments: str) -> "subprocess.Popen[bytes]":
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{module}", *arguments, "--no-dashboard"],
            cwd=self._folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._stack.callback(process.wait)
        self._stack.callback(process.kill)
        return process


@pytest.fixture(autouse=True, scope="module")
def patient() -> Iterator[None]:
    """However late a busy machine answers, no scheduler is lost for it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cluster_module, "ANSWER_S", QUICK_S)
        yield


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    running = Cluster(tmp_path_factory.mktemp("dask"))
    with DaskCluster(running.address) as cluster:
        assert _eventually(lambda: cluster.workers == 2)
    yield running
    running.close()


@pytest.fixture(scope="module")
def machine() -> Iterator[ThisMachine]:
    with ThisMachine(2) as machine:
        yield machine


def test_runs_are_the_same_wherever_they_happen(machine: ThisMachine, running: Cluster) -> None:
    with ThisMachine(1) as alone:
        expected = [_known(run) for run in _runs(alone, FAIRLY)]
    assert [_known(run) for run in _runs(machine, FAIRLY)] == expected
    with DaskCluster(running.address) as cluster:
        assert _eventually(lambda: cluster.workers == 2)
        assert not cluster.empty
        assert cluster.label == running.address
        assert [_known(run) for run in _runs(cluster, FAIRLY)] == expected
    assert all(state == DONE for _, _, _, state, *_ in expected)
    assert len(np.unique([str(costs) for *_, costs in expected])) > 1


def test_a_killed_worker_of_this_machine_costs_no_run(machine: ThisMachine) -> None:
    tasks = [Task("bowl", "rogues:dawdles", seed, 200, 60.0, 400_000_000) for seed in range(1, 13)]
    payload = machine.share(PAYLOAD)
    expected = [_known(run) for run in _runs(machine, tasks)]
    futures = [machine.submit(task, payload) for task in tasks]
    futures[2].result(SOON_S)
    os.kill(
        next(pid for pid, command in _below(os.getpid()).items() if "robolaser.benchmark.engines.worker" in command),
        signal.SIGKILL,
    )
    assert [_known(future.result(SOON_S)) for future in futures] == expected


def test_a_killed_worker_of_a_cluster_costs_no_run(machine: ThisMachine, running: Cluster) -> None:
    tasks = [Task("bowl", "rogues:dawdles", seed, 200, 60.0, 400_000_000) for seed in range(1, 17)]
    expected = [_known(run) for run in _runs(machine, tasks)]
    with DaskCluster(running.address) as cluster:
        assert _eventually(lambda: cluster.workers == 2)
        payload = cluster.share(PAYLOAD)
        futures = [cluster.submit(task, payload) for task in tasks]
        futures[4].result(SOON_S)
        os.kill(running.workers[0], signal.SIGKILL)
        assert [_known(future.result(SOON_S)) for future in futures] == expected
        running.workers[0] = running.worker()


def test_runs_that_fail_are_runs_and_the_others_go_on(machine: ThisMachine) -> None:
    tasks = [Task("bowl", f"rogues:{name}", 1, 200, 60.0, 400_000_000) for name in ("stumbles", "quits", "walks")]
    reasons = [run.reason for run in _runs(machine, tasks)]
    assert "no ground" in reasons[0]
    assert "exit code 3" in reasons[1]
    assert not reasons[2]


def test_closing_this_machine_kills_what_runs_at_once() -> None:
    machine = ThisMachine(1)
    before = _children(os.getpid())
    payload = machine.share(PAYLOAD)
    running, waiting = machine.submit(WAITS, payload), machine.submit(WAITS, payload)
    assert _eventually(lambda: _children(os.getpid()) - before)
    child = (_children(os.getpid()) - before).pop()
    began = time.monotonic()
    machine.close()
    machine.close()
    assert time.monotonic() - began < AT_ONCE_S
    assert waiting.cancelled()
    with pytest.raises(CancelledError):
        running.result(1)
    assert _eventually(lambda: not _there(child))


def test_leaving_a_cluster_kills_what_runs_there_at_once(running: Cluster) -> None:
    with DaskCluster(running.address) as cluster:
        future = cluster.submit(WAITS, cluster.share(PAYLOAD))
        assert _eventually(lambda: any(_children(worker) for worker in running.workers))
        began = time.monotonic()
    assert time.monotonic() - began < AT_ONCE_S
    with pytest.raises(CancelledError):
        future.result(1)
    assert _eventually(lambda: not any(_children(worker) for worker in running.workers))


def test_nothing_outlives_a_killed_program(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(
        f"import sys, time\nsys.path.append({str(Path(__file__).parent)!r})\n"
        "from test_engines import PAYLOAD, WAITS, ThisMachine\n"
        "machine = ThisMachine(2)\nmachine.submit(WAITS, machine.share(PAYLOAD))\ntime.sleep(100)\n"
    )
    with subprocess.Popen([sys.executable, str(program)]) as process:
        assert _eventually(lambda: _children(process.pid))
        below = _below(process.pid)
        process.kill()
    assert _eventually(lambda: not any(_there(pid) for pid in below))


@pytest.fixture
def silent() -> Iterator[str]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"


@pytest.fixture
def deaf() -> str:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return f"tcp://127.0.0.1:{server.getsockname()[1]}"


@pytest.fixture
def web() -> Iterator[str]:
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, format: str, *args: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Quiet) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"tcp://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    assert 3 * ANSWER_S < 10
    monkeypatch.setattr(cluster_module, "ANSWER_S", 1.0)


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("who", ["silent", "deaf", "web"])
def test_where_no_scheduler_answers_is_said_soon(request: pytest.FixtureRequest, who: str) -> None:
    address = request.getfixturevalue(who)
    began = time.monotonic()
    with pytest.raises(BenchmarkError, match=address):
        DaskCluster(address)
    assert time.monotonic() - began < QUICK_S


@pytest.mark.parametrize("address", ["", "nonsense", "tcp://", "foo://bar:1", "tcp://127.0.0.1", "inproc://x"])
def test_an_address_that_makes_no_sense_is_refused(address: str) -> None:
    with pytest.raises(BenchmarkError, match="such as tcp://host:8786"):
        DaskCluster(address)


def test_other_versions_are_refused_and_named(running: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = cluster_module._fetch_versions

    async def altered(address: str, packages: Sequence[str]) -> object:
        said = dict(await asked(address, packages))
        worker = next(who for who in said if who.startswith("worker"))
        return said | {worker: {**said[worker], "numpy": "1.0", "robolaser": None}}

    monkeypatch.setattr(cluster_module, "_fetch_versions", altered)
    with pytest.raises(BenchmarkError, match=r"robolaser [^ ]+ here, missing on worker .*numpy 2[^ ]+ here, 1.0 on"):
        DaskCluster(running.address)


def test_the_version_of_a_package_that_is_not_used_does_not_matter(
    running: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = cluster_module._fetch_versions

    async def without_numba(address: str, packages: Sequence[str]) -> object:
        return {who: {**said, **({"numba": None} if "numba" in packages else {})}
                for who, said in (await asked(address, packages)).items()}  # fmt: skip

    monkeypatch.setattr(cluster_module, "_fetch_versions", without_numba)
    DaskCluster(running.address, ("robolaser", "numpy")).close()
    with pytest.raises(BenchmarkError, match=r"numba .* here, missing on"):
        DaskCluster(running.address)


def test_a_worker_with_other_versions_that_comes_later_is_refused(
    running: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    compared = cluster_module._compared
    monkeypatch.setattr(cluster_module, "_compared", lambda *asked: {**compared(*asked), "python": "3.99"})
    with DaskCluster(running.address) as cluster, pytest.raises(BenchmarkError, match=r"python 3.99 here"):
        cluster.submit(WAITS, cluster.share(PAYLOAD)).result(SOON_S)


def test_who_has_no_dask_is_told_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(DependencyMissing, match=r"pip install 'robolaser\[dask\]'"):
        DaskCluster("tcp://127.0.0.1:8786")


def test_a_run_with_which_workers_keep_dying_has_failed(running: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    with DaskCluster(running.address) as cluster:
        payload = cluster.share(PAYLOAD)
        monkeypatch.setattr(cluster, "_executor", _Ends(cluster._executor, KilledWorker("x", None, 3)))
        run = cluster.submit(WAITS, payload).result(SOON_S)
    assert (run.state, run.reason) == (FAILED, "4 workers died while they had it")


def test_a_lost_scheduler_is_said_and_not_waited_for(tmp_path: Path) -> None:
    lost = Cluster(tmp_path)
    with DaskCluster(lost.address) as cluster:
        future = cluster.submit(WAITS, cluster.share(PAYLOAD))
        lost.close()
        with pytest.raises(EngineLost, match="no longer answers"):
            future.result(SOON_S)


class _Ends:
    """An executor whose futures end with an error."""

    def __init__(self, executor: Executor, error: Exception) -> None:
        self.shutdown, self._error = executor.shutdown, error

    def submit(self, *arguments: object) -> Future[BenchmarkRun]:
        future: Future[BenchmarkRun] = Future()
        future.set_exception(self._error)
        return future


def test_the_command_gives_on_a_cluster_what_it_gives_here(running: Cluster, tmp_path: Path) -> None:
    asked = ["compare", "paper", "--algorithms", "screening,rcga,random", "--seeds", "2", "--budget", "1000"]
    for name, where in (("here", ["--jobs", "1"]), ("there", ["--scheduler", running.address])):
        assert main([*asked, "--output", str(tmp_path / name), *where]) == 0
    here, there = ({run.key: _known(run) for run in load(tmp_path / name).runs} for name in ("here", "there"))
    assert len(here) == 6
    assert here == there


MINE = """
import sys
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.problem import Problem
from robolaser import RunPlan, compare
from robolaser.benchmark.engines import DaskCluster, ThisMachine, dask_cluster

dask_cluster.ANSWER_S = 20.0


class Halves(GA):
    pass


def walk(evaluator, seed):
    rng = np.random.default_rng(seed)
    while True:
        evaluator.objectives(np.clip(rng.normal(size=(10, 3)), -5, 5))


class Bowl(Problem):
    def __init__(self, n_obj=1):
        super().__init__(n_var=3, n_obj=n_obj, xl=-5, xu=5)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = ((x[:, None] - offsets[: self.n_obj, None]) ** 2).sum(axis=2)


import numpy as np

offsets = np.array([0.0, 1.0])
two = Bowl(n_obj=2)
solvers = ["random", "NSGA2", walk, Halves, "__main__:Halves"]
plan = RunPlan.of([Bowl, lambda: two, "__main__:Bowl"], solvers, seeds=2, budget=300)
for engine in (ThisMachine(2), DaskCluster(sys.argv[1])):
    result = compare(plan, engine)
    assert len(result.runs) == 26 and not result.failures, result.failures
    print(sorted((*run.key, run.trace.final) for run in result.runs))
"""


NOTEBOOK = """
import sys
from IPython.core.interactiveshell import InteractiveShell

shell = InteractiveShell.instance()
source, sys.argv = sys.argv[1], sys.argv[1:]
for cell in source.split("\\n\\n\\n"):
    shell.run_cell(cell).raise_error()
"""


@pytest.mark.parametrize("program", [[MINE], [NOTEBOOK, MINE]], ids=["script", "notebook"])
def test_problems_and_algorithms_of_ones_own_run_in_processes_and_on_a_cluster_alike(
    running: Cluster, program: list[str]
) -> None:
    if NOTEBOOK in program:
        pytest.importorskip("IPython")
    command = [sys.executable, "-c", *program, running.address]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    here, there = done.stdout.splitlines()
    assert here == there


def test_a_blind_trial_is_diagnosed_in_processes_and_on_a_cluster_as_it_is_here(
    running: Cluster, tmp_path: Path
) -> None:
    few = ["--kinds", "none", "--count", "2", "--poses", "8", "--points", "3", "--seed", "1"]
    assert main(["challenge", "new", str(tmp_path / "trial"), *few]) == 0
    said = []
    for where in ([], ["--jobs", "2"], ["--scheduler", running.address]):
        out = tmp_path / f"scored-{len(said)}"
        assert main(["challenge", "score", str(tmp_path / "trial"), "--output", str(out), *where]) == 0
        found = [json.loads(path.read_text()) for path in sorted(out.rglob("diagnosis.json"))]
        said.append([(one["dataset"], one["sentence"], round(one["gap_mm"]["after"], 6)) for one in found])
    assert len(said[0]) == 2
    assert said[0] == said[1] == said[2]
    assert main(["challenge", "score", str(tmp_path / "trial"), "--jobs", "2", "--scheduler", "tcp://x:1"]) == 2


@pytest.mark.usefixtures("quick")
def test_a_comparison_without_a_scheduler_ends_with_a_sentence_and_touches_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    began = time.monotonic()
    assert main(["compare", "paper", "--scheduler", address, "--output", str(tmp_path / "new")]) == 1
    assert time.monotonic() - began < QUICK_S
    assert address in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
