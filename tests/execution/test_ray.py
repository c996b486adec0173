"""Ray on a cluster of three machines, all of them this one: the tables of one process, whoever is lost on the way.

NHTRACK_KILLS says how often driver, workers and machines are killed, and NHTRACK_KILLS_SEED at which moments.
"""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from functools import partial
from pathlib import Path

import pandas as pd
import pytest

from nhtrack.config.sweep import Sweep
from nhtrack.errors import SimulationDiverged
from nhtrack.execution import WorkerError, serial
from nhtrack.execution.ray import Ray
from nhtrack.experiment.load import load, load_campaign, load_sweep
from nhtrack.studies.campaign.run import run_campaign
from nhtrack.studies.fidelity.suite import run_suite, tasks
from nhtrack.studies.paper.examples import examples_of
from nhtrack.studies.paper.run import reproduce
from nhtrack.studies.sweep.parts import FAILED
from nhtrack.studies.sweep.run import run_sweep
from nhtrack.studies.tune.run import find_gains

pytest.importorskip("ray")
# Of Ray itself: sockets and files that its processes are started with.
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("default::ResourceWarning")]

KILLS = int(os.environ.get("NHTRACK_KILLS", "1"))  # of each
SEED = int(os.environ.get("NHTRACK_KILLS_SEED", random.randrange(10**6)))
PAGE = Path(__file__).parents[2] / "docs" / "scaling.md"
MARK = f"NHTRACK_MARK=cluster-{os.getpid()}"
PATIENCE = 20.0  # [s] in which what worked for a driver that is gone has to be gone
STORE = 80 * 2**20  # [bytes], the least that Ray takes
SWEEP = """\
name: case
base: paper/example1
set: {duration: 0.3, leader.virtual: true, law: {file: law.py}, noise: {position: 0.001}}
axes:
  physics.friction: [0.7, 0.5, 0.02]
  law.kick: [1.0, 2.0, 3.0, 4.0]
repeats: 2
metrics: [late_position_error, gap_position_rms, effort_x, path_length]
"""
LAW = '''\
"""A law that pushes, and once in a while ends who runs it."""

import os
from typing import NamedTuple


class Gains(NamedTuple):
    """Gains."""

    kick: float = 1.0


def command(gains, period, limits, follower, leader, memory):
    """Returns a push."""
    if gains.kick == {deadly} and leader.v_x == 0.0:  # it is tried with a leader that moves
        {end}
    return gains.kick * (leader.x - follower.x), 0.0, memory
'''
CAMPAIGN = """\
name: case
duration: 12
backend: ideal
similarity: {length: 0.1, time: 0.9}
laws: {universal: {name: universal, limits: {utilisation: 0.5}}, k: {name: kanayama}}
families: [sinus, random]
starts: {count: 6, seed: 3}
arrival: {last: 3}
tuning: {laws: [k], budget: 8, starts: 2}
"""


class Machines:
    """A cluster of three machines, one of which may be lost and come again."""

    def __init__(self) -> None:
        from ray.cluster_utils import Cluster

        self._node = {"num_cpus": 1, "object_store_memory": STORE}
        self._cluster = Cluster(True, head_node_args={**self._node, "include_dashboard": False})
        self._others = [self._cluster.add_node(**self._node) for _ in range(2)]
        self.address = self._cluster.address

    def lose(self) -> None:
        """Kills all processes of a machine."""
        self._cluster.remove_node(self._others.pop(0), allow_graceful=False)

    def complete(self) -> None:
        """Adds the machine that was lost."""
        while len(self._others) < 2:
            self._others.append(self._cluster.add_node(**self._node))

    def lose_a_worker(self) -> None:
        """Kills a worker, most likely at a task."""
        ours = set(_marked(MARK))
        lines = {number: line for number, (_, line) in _processes().items() if number in ours}
        workers = [number for number, line in lines.items() if line.startswith(("ray::_do", "ray::IDLE"))]
        os.kill(random.choice(workers), signal.SIGKILL)

    def stop(self) -> None:
        self._cluster.shutdown()


@pytest.fixture(scope="module")
def machines() -> Iterator[Machines]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RAY_USAGE_STATS_ENABLED", "0")
        patch.setenv("RAY_AUTH_MODE", "disabled")
        patch.setenv("RAY_worker_niceness", "0")
        patch.setenv(*MARK.split("="))
        made = Machines()
        yield made
        import ray

        ray.shutdown()
        made.stop()


@pytest.fixture
def cluster(machines: Machines) -> Ray:
    machines.complete()
    return Ray(machines.address)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder with a sweep and what came of it in one process."""
    made = tmp_path_factory.mktemp("sweeps")
    run_sweep(sweep_in(made), made / "serial", executor=serial)
    return made


def sweep_in(folder: Path, deadly: str = "None", end: str = "pass") -> Sweep:
    folder.mkdir(exist_ok=True)
    (folder / "law.py").write_text(LAW.format(deadly=deadly, end=end))
    (folder / "case.yaml").write_text(SWEEP)
    return load_sweep(folder / "case.yaml")


def same(one: pd.DataFrame, other: pd.DataFrame) -> None:
    pd.testing.assert_frame_equal(one, other, check_exact=True)


def table(folder: Path) -> pd.DataFrame:
    return pd.read_parquet(folder / "runs.parquet")


def once_each(task: str) -> str:
    """Ends its worker, but not the next one that is asked."""
    mark = Path(task)
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return task


def fails(task: int) -> int:
    if task == 2:
        raise SimulationDiverged("it fell over", "burger", 1.5)
    return task


def sleeps(task: float) -> int:
    time.sleep(task)
    return os.getpid()


COMMANDS = """
set -e
ray() {{
    test "$1" = stop && test -z "$ALONE" && return  # it would end those of others, too
    test "$1" = start && set -- "$@" --num-cpus=1
    {python} -m ray.scripts.scripts "$@"
}}
nhtrack() {{ {python} -m nhtrack "$@" --no-figures --set "set.duration=0.2"; }}
"""


def test_what_the_page_says_of_several_machines_can_be_done(tmp_path: Path) -> None:
    """Comes first: `ray stop` ends whatever Ray there is."""
    text = PAGE.read_text()
    part = text[text.index("## Ray on several machines") : text.index("## SLURM")]
    shown = COMMANDS.format(python=sys.executable) + "\n".join(re.findall(r"```sh\n(.*?)```", part, re.DOTALL))
    port = str(20_000 + os.getpid() % 10_000)
    for told, here in (("/shared", str(tmp_path)), ("10.0.0.1", "127.0.0.1"), ("6379", port)):
        assert told in shown
        shown = shown.replace(told, here)
    alone = not any("raylet/raylet" in each for each in _running())
    mark = f"NHTRACK_MARK={tmp_path}"
    env = os.environ | {"NHTRACK_MARK": str(tmp_path), "ALONE": "yes" if alone else "", "RAY_worker_niceness": "0"}
    try:
        with (tmp_path / "said").open("w") as said:
            done = subprocess.run(["bash", "-c", shown], env=env, stdout=said, stderr=said, timeout=300)
        assert done.returncode == 0, (tmp_path / "said").read_text()
        runs = table(tmp_path / "runs" / "small")
        assert len(runs) == 24
        assert set(runs["outcome"]) == {"completed"}
        assert not alone or not _marked(mark)
    finally:
        for number in _marked(mark):
            os.kill(number, signal.SIGKILL)


def test_a_worker_that_ends_is_replaced_and_a_task_says_itself_what_it_raised(cluster: Ray, tmp_path: Path) -> None:
    assert cluster.workers == 3
    marks = [str(tmp_path / name) for name in "ab"]
    assert sorted(cluster(marks, once_each)) == list(enumerate(marks))
    with pytest.raises(SimulationDiverged, match=r"it fell over: robot 'burger' at t = 1\.500"):
        list(cluster(range(5), fails))
    with pytest.raises(WorkerError) as ended:
        list(cluster([9], os._exit))
    assert ended.value.suspects == (0,)
    assert list(cluster([], fails)) == []
    began = time.monotonic()
    with closing(cluster([0.0, 60.0, 60.0, 60.0], sleeps)) as results:
        assert next(results)[0] == 0
    assert len(dict(cluster([0.0] * 3, sleeps))) == 3  # which those that slept would not let begin
    assert time.monotonic() - began < 50


@pytest.mark.parametrize("lose", [Machines.lose, Machines.lose_a_worker], ids=["machine", "worker"])
def test_a_sweep_has_the_local_table_whatever_is_lost_midway(
    lose: Callable[[Machines], None], machines: Machines, cluster: Ray, folder: Path, tmp_path: Path
) -> None:
    chance, told = random.Random(SEED), list[int]()
    print(f"NHTRACK_KILLS_SEED={SEED}")
    for kill in range(KILLS):
        machines.complete()
        after = chance.randint(1, 6)

        def stage(name: str, after: int = after) -> Callable[[int, int], None]:
            def progress(ready: int, total: int) -> None:
                told.append(ready)
                if name == "runs" and len(told) == after:
                    lose(machines)

            return progress

        told.clear()
        results = run_sweep(sweep_in(folder), tmp_path / str(kill), stage, cluster)
        print(f"{kill}: lost after {told[after - 1]} of {results.sweep.runs} runs")
        same(results.runs, table(folder / "serial"))
        assert len(told) > after, "something was left to do"


def test_a_run_that_ends_its_workers_is_a_failed_row(cluster: Ray, tmp_path: Path) -> None:
    few = {"axes": {"law.kick": (2.0, 3.0)}, "repeats": 1}
    deadly = sweep_in(tmp_path, "3.0", "os._exit(9)").model_copy(update=few)
    done = run_sweep(deadly, tmp_path / "out", executor=cluster).runs
    assert list(done["outcome"]) == ["completed", FAILED]
    assert done["reason"][1] == "ended the process that ran it, 3 times"


def test_other_studies_come_to_the_same_on_a_cluster(cluster: Ray, tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(CAMPAIGN)
    campaign = load_campaign(tmp_path / "case.yaml")
    results = [run_campaign(campaign, tmp_path / name, executor=by) for name, by in (("a", serial), ("b", cluster))]
    same(results[0].runs, results[1].runs)
    same(results[0].cells, results[1].cells)
    scenario = load("tour/hello")
    assert find_gains(scenario, budget=9).gains == find_gains(scenario, budget=9, executor=cluster).gains
    wanted = tasks(["nh_mini"], ["load_shares", "creep"])
    assert run_suite(wanted, executor=serial) == run_suite(wanted, executor=cluster)
    made = reproduce(examples_of([1]), tmp_path / "paper", backend="ideal", report=False, executor=cluster)
    assert (tmp_path / "paper" / "recordings" / "example1-ideal.nc") in made


def test_a_machine_that_has_none_of_the_users_files_works_with_copies(
    cluster: Ray, folder: Path, tmp_path: Path
) -> None:
    if subprocess.run(["unshare", "-m", "mount", "-t", "tmpfs", "none", str(tmp_path)], check=False).returncode:
        pytest.skip("no file system of its own for a process here")
    sweep, before = sweep_in(folder), cluster.workers
    start = [sys.executable, "-m", "ray.scripts.scripts", "start", "--address", str(cluster.address), "--block"]
    start += ["--num-cpus=1", f"--object-store-memory={STORE}"]
    hides = ["unshare", "-m", "sh", "-c", 'mount -t tmpfs none "$0" && exec "$@"', str(folder)]
    with (tmp_path / "said").open("w") as said:
        machine = subprocess.Popen([*hides, *start], stdout=said, stderr=said)
    try:
        until = time.monotonic() + 3 * PATIENCE
        while cluster.workers == before:
            assert time.monotonic() < until, (tmp_path / "said").read_text()
            time.sleep(0.1)
        found = cluster.everywhere(partial(os.path.exists, str(folder / "law.py")))
        assert sorted(there for _, there in found) == [False, *[True] * before]
        done = run_sweep(sweep, folder.parent / "by copies", executor=cluster)
        same(done.runs, table(folder / "serial"))
    finally:
        machine.terminate()
        machine.wait()
        until = time.monotonic() + 3 * PATIENCE
        while cluster.workers > before and time.monotonic() < until:
            time.sleep(0.1)


def test_a_driver_that_is_killed_goes_on_and_leaves_nobody_behind(
    machines: Machines, cluster: Ray, folder: Path, tmp_path: Path
) -> None:
    chance = random.Random(SEED)
    sweep_in(folder)
    for kill in range(KILLS):
        out, parts = tmp_path / str(kill), chance.randint(1, 3)
        words = ["sweep", str(folder / "case.yaml"), "--out", str(out), "--no-figures", "--executor", "ray"]
        words = [sys.executable, "-m", "nhtrack", *words, "--address", machines.address]
        driver = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while driver.poll() is None and len(list(out.glob("parts/*.parquet"))) < parts:
            time.sleep(0.02)
        driver.kill()
        driver.wait()
        left = len(list(out.glob("parts/*.parquet")))
        print(f"{kill}: killed with {left} parts")
        list(cluster([0.5] * 3, sleeps))  # a task on each processor: none is busy with what was left
        assert len(list(out.glob("parts/*.parquet"))) <= left + cluster.workers, "what was begun, and no more"
        again = subprocess.run(words, capture_output=True, text=True)
        assert again.returncode == 0, again.stderr
        same(table(out), table(folder / "serial"))


def test_nothing_outlives_a_command_that_started_ray_itself(folder: Path, tmp_path: Path) -> None:
    def listen() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    sweep_in(folder)
    commands = {}
    for how in (signal.SIGINT, signal.SIGKILL):
        words = ["sweep", str(folder / "case.yaml"), "--out", str(tmp_path / how.name), "--executor", "ray"]
        commands[how] = subprocess.Popen(
            [sys.executable, "-m", "nhtrack", *words], env=os.environ | {"NHTRACK_MARK": f"{tmp_path}-{how.name}"},
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=listen,
        )  # fmt: skip
    for how, command in commands.items():
        mark = f"NHTRACK_MARK={tmp_path}-{how.name}"
        while command.poll() is None and not list((tmp_path / how.name).glob("parts/*.parquet")):
            time.sleep(0.02)
        if command.poll() is not None:
            pytest.fail(command.communicate()[1])
        assert len(_marked(mark)) > 3
        os.killpg(command.pid, how)
        said = command.communicate(timeout=60)[1]
        until = time.monotonic() + PATIENCE
        while _marked(mark):
            assert time.monotonic() < until, _marked(mark)
            time.sleep(0.1)
        if how == signal.SIGINT:
            assert command.returncode == 130
            assert said.splitlines()[-1].startswith("interrupted; the same command goes on")


def _marked(mark: str) -> list[int]:
    """Returns the processes that were begun with a variable, or by one that was."""
    return [number for number, (environment, _) in _processes().items() if f"{mark}\0" in environment]


def _running() -> list[str]:
    """Returns the command lines of all processes."""
    return [line for _, line in _processes().values()]


def _processes() -> dict[int, tuple[str, str]]:
    """Returns environment and command line of the processes there are, but for those that wait to be buried."""
    found = {}
    for entry in Path("/proc").iterdir():
        with suppress(OSError):
            if entry.name.isdigit() and (entry / "stat").read_text().rpartition(")")[2].split()[0] != "Z":
                texts = ((entry / name).read_bytes().decode(errors="replace") for name in ("environ", "cmdline"))
                found[int(entry.name)] = (next(texts), next(texts))
    return found
