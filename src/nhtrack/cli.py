"""The command line. Commands import what they need when they run, so that `nhtrack --help` answers at once.

Exit codes: 0 done; 1 another error of the package; 2 a scenario or a command line at fault; 3 a simulation
that diverged; 130 interrupted by the user.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table
from typer.core import TyperGroup

from nhtrack.errors import NhtrackError, ScenarioError, SimulationDiverged

if TYPE_CHECKING:
    from collections.abc import Callable

    from nhtrack.scenario.schema import Scenario

EXIT_ERROR, EXIT_SCENARIO, EXIT_DIVERGED, EXIT_INTERRUPTED = 1, 2, 3, 130


class _Commands(TyperGroup):
    """The commands, with the package's errors turned into one line each and an exit code."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except ScenarioError as error:
            _fail(str(error), EXIT_SCENARIO)
        except SimulationDiverged as error:
            _fail(f"diverged: {error}", EXIT_DIVERGED)
        except NhtrackError as error:
            _fail(f"error: {error}", EXIT_ERROR)
        except KeyboardInterrupt:
            _fail("interrupted", EXIT_INTERRUPTED)


def _fail(message: str, code: int) -> NoReturn:
    """Ends the command with a message on stderr, unwrapped: one line per fault stays one line."""
    typer.echo(message, err=True)
    raise typer.Exit(code)


app = typer.Typer(
    cls=_Commands,
    help="Nonholonomic robots on real MuJoCo wheel contacts, beside the ideal integrator.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


class Backend(StrEnum):
    """What moves the robots."""

    mujoco = "mujoco"
    ideal = "ideal"


class Camera(StrEnum):
    """Where the film is seen from."""

    group = "group"
    top = "top"
    isometric = "isometric"
    chase = "chase"


def main() -> None:
    """Runs the command line."""
    app()


def _print_version(wanted: bool) -> None:
    if wanted:
        from nhtrack import __version__

        typer.echo(f"nhtrack {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    pass


@app.command()
def run(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file, a bundled name (`nhtrack list`), or a recording.nc.")
    ],
    out: Annotated[Path | None, typer.Option(help="Results folder; by default a fresh runs/<name>-<n>/.")] = None,
    backend: Annotated[Backend | None, typer.Option(help="Override the scenario's backend.")] = None,
    seed: Annotated[int | None, typer.Option(help="Override the scenario's seed.")] = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Override any key, such as law.kp=3.")
    ] = None,
    video: Annotated[bool, typer.Option("--video/--no-video", help="Make the film.")] = True,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures.")] = True,
    force: Annotated[bool, typer.Option(help="Write into a results folder that exists.")] = False,
) -> None:
    """Run a scenario: summary, recording, figures and film in a fresh folder."""
    overrides = list(changes or [])
    overrides += [f"backend={backend.value}"] if backend is not None else []
    overrides += [f"seed={seed}"] if seed is not None else []
    loaded = _load(scenario, overrides)
    from nhtrack.study.run import run_scenario

    run_scenario(loaded, out=out, video=video, figures=figures, force=force, console=Console())


def _load(source: str, overrides: list[str]) -> Scenario:
    """Returns the scenario of a file, of a bundled name, or the one a recording was made from."""
    from nhtrack.scenario.load import load, load_tree

    if not source.endswith(".nc"):
        return load(source, overrides)
    from nhtrack.recording import Recording

    return load_tree(Recording.load(source).scenario, source=source, overrides=overrides)


@app.command()
def validate(files: Annotated[list[str], typer.Argument(help="Scenario files or bundled names.")]) -> None:
    """Check scenarios and report every fault with its line; nothing is run or written."""
    from nhtrack.scenario.load import load

    faulty = False
    for source in files:
        try:
            scenario = load(source)
        except ScenarioError as error:
            faulty = True
            typer.echo(str(error), err=True)
        else:
            typer.echo(f"{source}: ok ({_account(scenario)})")
    if faulty:
        raise typer.Exit(EXIT_SCENARIO)


def _account(scenario: Scenario) -> str:
    """Returns what a scenario amounts to on the robot."""
    seconds = scenario.periods / scenario.control_rate
    count = len(scenario.followers)
    return f"{count} follower{'s' * (count > 1)}, {seconds:g} s on the robot's clock, {scenario.law.name} law"


@app.command()
def schema(
    out: Annotated[Path | None, typer.Option(help="Write to this file instead of the terminal.")] = None,
) -> None:
    """Print the JSON Schema of scenario files, for editors that complete and check them."""
    from nhtrack.scenario.documentation import json_schema

    text = json.dumps(json_schema(), indent=2)
    if out is None:
        typer.echo(text)
    else:
        _write(out, text + "\n")
        typer.echo(f"wrote {out}")


@app.command()
def init(
    path: Annotated[Path, typer.Argument(help="The file to write.")] = Path("scenario.yaml"),
    force: Annotated[bool, typer.Option(help="Replace the file if it exists.")] = False,
) -> None:
    """Write a commented scenario to start from."""
    from nhtrack.assets import find_scenario

    if path.exists() and not force:
        _fail(f"error: {path} exists; choose another name, or --force to replace it", EXIT_ERROR)
    text = find_scenario("tour/hello").read_text(encoding="utf-8")
    if re.fullmatch(r"[A-Za-z][\w-]*", path.stem):
        text = re.sub(r"^name: \S+", f"name: {path.stem}", text, count=1, flags=re.MULTILINE)
    _write(path, text)
    typer.echo(f"wrote {path}; run it with: nhtrack run {path}")


def _write(path: Path, text: str) -> None:
    """Writes a text file that appears under its name only once it is whole."""
    from nhtrack.recording import atomic_path

    try:
        with atomic_path(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
    except OSError as error:
        _fail(f"error: cannot write {path}: {error.strerror}", EXIT_ERROR)


@app.command()
def render(
    recording: Annotated[Path, typer.Argument(help="A recording.nc that a run left.")],
    out: Annotated[Path | None, typer.Option(help="The film; by default renders/<run>.mp4.")] = None,
    camera: Annotated[Camera | None, typer.Option(help="By default as the scenario says.")] = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Pixels, such as 1280x720.")] = None,
    fps: Annotated[int | None, typer.Option(min=1, max=120, help="Frames per second.")] = None,
    speed: Annotated[float | None, typer.Option(help="Robot seconds per second of film.")] = None,
    force: Annotated[bool, typer.Option(help="Replace the film if it exists.")] = False,
) -> None:
    """Make a film from a recording; nothing is simulated again."""
    from nhtrack.recording import Recording
    from nhtrack.scenario.schema import Video

    loaded = Recording.load(recording)
    wanted = Video.model_validate(loaded.scenario.get("video", {}))
    target = out or Path("renders") / f"{_run_name(recording, loaded.name)}.mp4"
    if target.exists() and not force:
        _fail(f"error: {target} exists; choose another --out, or --force to replace it", EXIT_ERROR)
    if speed is not None and not speed > 0:
        raise typer.BadParameter(f"expected a number greater than 0, got {speed:g}", param_hint="--speed")
    from nhtrack.video import render as render_film

    with _progress_bar("film") as progress:
        film = render_film(
            loaded,
            target,
            camera=camera.value if camera is not None else wanted.camera,
            size=_pixels(size) if size is not None else wanted.size,
            fps=fps or wanted.fps,
            speed=speed or wanted.speed,
            progress=progress,
        )
    typer.echo(f"wrote {film}")


def _run_name(recording: Path, name: str) -> str:
    """Returns the name of the run a recording lies in: its folder, unless that says nothing."""
    folder = recording.resolve().parent.name
    return folder if folder.startswith(name) else name


def _pixels(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{2,4})x(\d{2,4})", text)
    if match is None or any(int(side) % 2 for side in match.groups()):
        raise typer.BadParameter(f"expected two even numbers such as 1280x720, got {text!r}", param_hint="--size")
    return int(match[1]), int(match[2])


@contextmanager
def _progress_bar(label: str) -> Iterator[Callable[[int, int], None]]:
    """Shows a bar on stderr while work goes on; yields what to call with the work done and the whole of it."""
    columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@app.command("list")
def list_assets() -> None:
    """List the bundled scenarios and robots."""
    from nhtrack import assets
    from nhtrack.scenario.load import load

    scenarios = [(name, load(name).description) for name in assets.bundled_scenarios()]
    robots = [(name, assets.robot_description(name)) for name in assets.robots()]
    console = Console()
    for title, rows in (("Scenarios", scenarios), ("Robots", robots)):
        table = Table(title=title, title_justify="left", box=None, show_header=False, padding=(0, 2))
        table.add_column(no_wrap=True, style="bold")
        table.add_column()
        for row in rows:
            table.add_row(*row)
        console.print(table)


@app.command()
def doctor() -> None:
    """Check what this machine has for running and filming, and say what to do about what is missing."""
    from nhtrack.study.doctor import report

    checks = report()
    for check in checks:
        mark = typer.style("ok  ", fg="green") if check.ok else typer.style("miss", fg="red")
        typer.echo(f"{mark} {check.name}: {check.detail}")
        if not check.ok and check.remedy:
            typer.echo(f"     {check.remedy}")
    if not all(check.ok for check in checks):
        raise typer.Exit(EXIT_ERROR)


if __name__ == "__main__":
    main()
