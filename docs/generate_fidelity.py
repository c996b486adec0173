"""Writes the tables of docs/fidelity.md anew, between their markers; takes a few minutes.

    python docs/generate_fidelity.py

The open-loop runs are those of the tests (`tests/motions.py`), so that page and tests cannot disagree.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
from rich.progress import track

from nhtrack import assets
from nhtrack.metrics import heading_gap, position_gap
from nhtrack.scenario.load import load
from nhtrack.simulation.scene import SceneSpec
from nhtrack.study.run import simulate, versions

PAGE = Path(__file__).with_name("fidelity.md")
TIMESTEPS = (0.004, 0.002, 0.001, 0.0005)

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from motions import make_simulation, weaving_error  # noqa: E402


def table(header: list[str], rows: list[list[str]]) -> str:
    """Returns a Markdown table."""
    return "\n".join(f"| {' | '.join(cells)} |" for cells in [header, ["---"] * len(header), *rows])


def open_loop() -> str:
    """Returns errors with and without rate correction over four time steps, and their order."""
    runs = [(h, corrected) for corrected in (True, False) for h in TIMESTEPS]
    errors = {}
    for h, corrected in track(runs, "open loop"):
        spec = SceneSpec(("robot",), timestep=h, rate_correction=corrected)
        errors[h, corrected] = weaving_error(make_simulation(spec))
    rows = []
    for quantity, unit in (("position", "m"), ("heading", "rad")):
        for corrected in (True, False):
            values = [getattr(errors[h, corrected], quantity) for h in TIMESTEPS]
            order = np.log(values[0] / values[-1]) / np.log(TIMESTEPS[0] / TIMESTEPS[-1])
            name = f"{quantity} [{unit}], {'with' if corrected else 'without'} rate correction"
            rows.append([name, *(f"{value:.1e}" for value in values), f"{order:.2f}"])
    return table(["physics step", *(f"{1e3 * h:g} ms" for h in TIMESTEPS), "order"], rows)


def closed_loop() -> str:
    """Returns gaps to the ideal twin and utilisation of the paper's examples."""
    names = [name for name in assets.bundled_scenarios() if name.startswith("paper/")]
    rows = []
    for name in track(names, "closed loop"):
        scenario = load(name)
        if scenario.physics.robot_contact:
            continue  # robots that may touch have no twin to be held against
        contact = scenario.physics.contact.model_copy(update={"rate_correction": False})
        physics = scenario.physics.model_copy(update={"contact": contact})
        plain = scenario.model_copy(update={"physics": physics})
        recording, uncorrected = (simulate(each).recording for each in (scenario, plain))
        position, heading = position_gap(recording), np.abs(heading_gap(recording))
        rows.append([
            f"{name}",
            f"{recording.time[-1]:.0f} s",
            f"{1e6 * rms(position):.2f}",
            f"{1e6 * position.max():.2f}",
            f"{1e6 * heading.max():.1f}",
            f"{np.nanmax(recording['friction_utilisation'].values):.3f}",
            f"{1e6 * rms(position_gap(uncorrected)):.0f}",
        ])  # fmt: skip
    header = ["scenario", "duration", "gap RMS [um]", "gap max [um]", "heading max [urad]", "utilisation"]
    header.append("gap RMS without rate correction [um]")
    return table(header, rows)


def rms(gap: np.ndarray) -> float:
    """Returns the root mean square over time, of the robot with the largest."""
    return float(np.sqrt(np.mean(gap**2, axis=0)).max())


def fill(text: str, marker: str, content: str) -> str:
    """Returns the page with what stands between two markers replaced.

    Raises:
        ValueError: the page lacks the markers.
    """
    begin, end = f"<!-- begin: {marker} -->", f"<!-- end: {marker} -->"
    pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
    if len(pattern.findall(text)) != 1:
        raise ValueError(f"{PAGE.name}: expected one {begin} ... {end}")
    return pattern.sub(lambda _: f"{begin}\n{content}\n{end}", text)


def main() -> None:
    """Writes the page."""
    text = PAGE.read_text(encoding="utf-8")
    made_with = f"\n\nMuJoCo {versions()['mujoco']}."
    text = fill(text, "open loop", open_loop() + made_with)
    text = fill(text, "closed loop", closed_loop() + made_with)
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
