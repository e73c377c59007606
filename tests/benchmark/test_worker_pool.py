import os
import pickle
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest
from rogues import spec

from robolaser.benchmark.engines import worker_process
from robolaser.benchmark.engines.this_machine import WorkerPool
from robolaser.benchmark.single_run import DONE, FAILED, BenchmarkRun, Task

PAYLOAD = pickle.dumps(spec())
Make = Callable[..., BenchmarkRun]


@pytest.fixture(scope="module")
def pool() -> Iterator[WorkerPool]:
    pool = WorkerPool()
    yield pool
    pool.close()


@pytest.fixture
def made(pool: WorkerPool) -> Make:
    def make(name: str, *, seed: int = 1, time_limit_s: float = 60.0, payload: bytes = PAYLOAD) -> BenchmarkRun:
        task = Task("bowl", f"rogues:{name}", seed, 500, time_limit_s, 400_000_000)
        return pool.do(task, str(hash(payload)), lambda: payload)

    return make


@contextmanager
def _impatient() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(worker_process, "GRACE_S", 0.2)
        patch.setattr(worker_process, "WARM_UP_S", 1.6)
        yield


def _processes(pool: WorkerPool) -> set[int]:
    return {worker.pid for worker in pool.workers}


def _gone(pid: int, within_s: float = 30.0) -> bool:
    until = time.monotonic() + within_s
    while time.monotonic() < until:
        try:
            if Path(f"/proc/{pid}/stat").exists() and Path(f"/proc/{pid}/stat").read_text().split()[2] == "Z":
                return True
            os.kill(pid, 0)
        except (ProcessLookupError, FileNotFoundError):
            return True
        time.sleep(0.02)
    return False


def test_a_run_uses_its_budget_and_its_worker_is_kept_for_the_next(pool: WorkerPool, made: Make) -> None:
    first = made("walks")
    before = _processes(pool)
    second = made("walks", seed=2)
    assert (first.state, first.evaluations, first.algorithm) == (DONE, 500, "rogues:walks")
    assert second.trace.final != first.trace.final
    assert _processes(pool) == before


def test_a_problem_is_sent_only_once(pool: WorkerPool) -> None:
    sent = []

    def payload() -> bytes:
        sent.append(1)
        return PAYLOAD

    for seed in (1, 2):
        pool.do(Task("bowl", "rogues:walks", seed, 50, 1.0, 400_000_000), "once", payload)
    assert len(sent) == 1


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("stumbles", "ZeroDivisionError: no ground"),
        ("dreams", "not a number"),
        ("leaves", "it called sys.exit(3)"),
        ("hoards", "more memory than it may use"),
        ("keeps", "more memory than it may use"),
        ("quits", "exit code 3"),
        ("no_such", "no_such"),
    ],
)
def test_a_solver_that_fails_fails_with_the_reason(made: Make, name: str, reason: str) -> None:
    run = made(name)
    assert run.state == FAILED
    assert reason in run.reason
    assert (run.problem, run.algorithm, run.seed) == ("bowl", f"rogues:{name}", 1)
    assert made("walks").state == DONE


def test_a_problem_that_cannot_be_built_fails_its_runs(made: Make) -> None:
    run = made("walks", payload=pickle.dumps(spec(broken=True)))
    assert "no such bowl" in run.reason


@pytest.mark.parametrize("name", ["circles_later", "freezes", "closes"])
def test_a_solver_that_never_ends_is_killed(made: Make, name: str) -> None:
    made("walks")
    began = time.monotonic()
    with _impatient():
        run = made(name, time_limit_s=0.2)
    assert run.state == FAILED
    assert "killed" in run.reason
    assert time.monotonic() - began < worker_process.WARM_UP_S
    assert made("walks").state == DONE


def test_a_solver_that_never_ended_once_is_not_waited_for_that_long_again(made: Make) -> None:
    made("walks")
    with _impatient():
        assert "within 2 s of its uncounted" in made("circles", time_limit_s=0.2).reason
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(worker_process, "GRACE_S", 0.2)
        assert "within 0.4 s; killed" in made("circles", time_limit_s=0.2, seed=2).reason


def test_whatever_a_solver_prints_disturbs_nobody(made: Make, capfd: pytest.CaptureFixture[str]) -> None:
    assert made("chatters").state == DONE
    assert capfd.readouterr() == ("", "")


def test_a_run_whose_worker_died_is_tried_once_more(
    pool: WorkerPool, made: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROGUES_GRAVE", str(tmp_path / "grave"))
    for pid in _processes(pool):
        os.kill(pid, signal.SIGKILL)
        assert _gone(pid)
    run = made("dies_once")
    assert (run.state, run.reason) == (DONE, "")
    assert (tmp_path / "grave").exists()


def test_a_run_whose_worker_dies_again_has_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    amid = tmp_path / "amid"
    monkeypatch.setenv("ROGUES_AMID", str(amid))
    pool = WorkerPool()
    task = Task("bowl", "rogues:waits", 1, 500, 60.0, 400_000_000)
    runs: list[BenchmarkRun] = []
    thread = threading.Thread(target=lambda: runs.append(pool.do(task, "x", lambda: PAYLOAD)))
    thread.start()
    for _ in range(2):
        while not amid.exists():
            time.sleep(0.02)
        amid.unlink()
        (pid,) = _processes(pool)
        os.kill(pid, signal.SIGKILL)
    thread.join(30)
    pool.close()
    assert "signal 9" in runs[0].reason


@pytest.mark.parametrize("name", ["waits", "circles", "freezes"])
def test_no_worker_outlives_a_killed_program(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    amid = tmp_path / "amid"
    monkeypatch.setenv("ROGUES_AMID", str(amid))
    program = f"""
        import pickle, sys, threading
        sys.path.append({str(Path(__file__).parent)!r})
        from rogues import spec
        from robolaser.benchmark.single_run import Task
        from robolaser.benchmark.engines.this_machine import WorkerPool
        task = Task("bowl", "rogues:{name}", 1, 500, 60.0, 10**9)
        payload = pickle.dumps(spec())
        pool = WorkerPool()
        threading.Thread(target=pool.do, args=(task, "x", lambda: payload), daemon=True).start()
        while not pool.workers:
            pass
        print(*(worker.pid for worker in pool.workers), flush=True)
        threading.Event().wait()
    """
    parent = subprocess.Popen([sys.executable, "-c", textwrap.dedent(program)], stdout=subprocess.PIPE, text=True)
    with parent:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        while not amid.exists():
            time.sleep(0.02)
        time.sleep(0.1)
        assert not _gone(child, within_s=0.0)
        parent.kill()
    assert _gone(child)


def test_closing_a_pool_kills_its_workers_and_fails_what_they_run() -> None:
    pool = WorkerPool()
    task = Task("bowl", "rogues:waits", 1, 500, 60.0, 400_000_000)
    runs: list[BenchmarkRun] = []
    thread = threading.Thread(target=lambda: runs.append(pool.do(task, "x", lambda: PAYLOAD)))
    thread.start()
    while not (pids := _processes(pool)):
        time.sleep(0.02)
    pool.close()
    thread.join(30)
    assert runs[0].state == FAILED
    assert all(_gone(pid) for pid in pids)
    assert not pool.workers
    assert pool.do(task, "x", lambda: PAYLOAD).reason == "stopped"


def test_runs_at_the_same_time_have_a_worker_each(pool: WorkerPool, made: Make, tmp_path: Path) -> None:
    payload = pickle.dumps(spec(title=str(tmp_path)))
    with ThreadPoolExecutor(3) as threads:
        runs = list(threads.map(lambda seed: made("meets", seed=seed, payload=payload), (1, 2, 3)))
    assert [run.state for run in runs] == [DONE] * 3
    assert {int(file.name) for file in tmp_path.iterdir()} == _processes(pool)
