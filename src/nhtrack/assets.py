"""Where the bundled robots and scenarios are, in a wheel or in a checkout."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from nhtrack.errors import NhtrackError, did_you_mean

_PACKAGE = Path(__file__).parent
_CAMPAIGNS, _SWEEPS = "campaign/", "sweep/"  # folders of scenarios/ whose files are campaigns and sweeps


class AssetError(NhtrackError):
    """A bundled robot or scenario that does not exist; the message lists those that do."""


def _directory(name: str) -> Path:
    return _found(_PACKAGE, name)


@cache
def _found(package: Path, name: str) -> Path:
    """Returns `_bundled/<name>` of an installed wheel, or `<name>` at the root of a checkout."""
    bundled, checkout = package / "_bundled" / name, package.parents[1] / name
    for candidate in (bundled, checkout):
        if candidate.is_dir():
            return candidate
    raise AssetError(f"the {name}/ folder is missing from this installation; looked in {bundled} and {checkout}")


def models_directory() -> Path:
    """Returns the folder of the bundled robots and arenas."""
    return _directory("models")


def scenarios_directory() -> Path:
    """Returns the folder of the bundled scenarios."""
    return _directory("scenarios")


def find_example(name: str) -> Path:
    """Returns a file of examples/, such as `write_a_law/my_law.py`."""
    return _directory("examples") / name


def robots() -> tuple[str, ...]:
    """Returns the names of the bundled robots: the folders of models/ that hold a robot.xml."""
    return _robots_in(models_directory())


@cache
def _robots_in(folder: Path) -> tuple[str, ...]:
    return tuple(sorted(path.parent.name for path in folder.glob("*/robot.xml")))


def find_robot(name: str) -> Path:
    """Returns the MJCF file of a bundled robot.

    Raises:
        AssetError: no such robot.
    """
    if name not in robots():
        raise AssetError(f"no robot {name!r}; {did_you_mean(name, robots())}")
    return models_directory() / name / "robot.xml"


def bundled_scenarios() -> tuple[str, ...]:
    """Returns the names of the bundled scenarios, such as `paper/example1`."""
    return tuple(name for name in _bundled_files() if not name.startswith((_CAMPAIGNS, _SWEEPS)))


def bundled_campaigns() -> tuple[str, ...]:
    """Returns the names of the bundled campaigns, such as `campaign/ideal`."""
    return tuple(name for name in _bundled_files() if name.startswith(_CAMPAIGNS))


def bundled_sweeps() -> tuple[str, ...]:
    """Returns the names of the bundled sweeps, such as `sweep/small`."""
    return tuple(name for name in _bundled_files() if name.startswith(_SWEEPS))


def find_scenario(name: str) -> Path:
    """Returns the file of a bundled scenario.

    Raises:
        AssetError: no such scenario.
    """
    return _find("scenario", name, bundled_scenarios())


def find_campaign(name: str) -> Path:
    """Returns the file of a bundled campaign.

    Raises:
        AssetError: no such campaign.
    """
    return _find("campaign", name, bundled_campaigns())


def find_sweep(name: str) -> Path:
    """Returns the file of a bundled sweep.

    Raises:
        AssetError: no such sweep.
    """
    return _find("sweep", name, bundled_sweeps())


def _bundled_files() -> tuple[str, ...]:
    root = scenarios_directory()
    return tuple(sorted(path.relative_to(root).with_suffix("").as_posix() for path in root.rglob("*.yaml")))


def _find(kind: str, name: str, bundled: tuple[str, ...]) -> Path:
    if name not in bundled:
        raise AssetError(f"no bundled {kind} {name!r}; {did_you_mean(name, bundled)}")
    return scenarios_directory() / f"{name}.yaml"


def robot_description(name: str) -> str:
    """Returns what a bundled robot is, in the first sentence of its README; empty where it has none.

    Raises:
        AssetError: no such robot.
    """
    readme = find_robot(name).with_name("README.md")
    paragraphs = readme.read_text(encoding="utf-8").split("\n\n") if readme.is_file() else []
    prose = (text for text in paragraphs if not text.lstrip().startswith(("#", "!", "<")))
    return " ".join(next(prose, "").split()).split(". ")[0].rstrip(".")
