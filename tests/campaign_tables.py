"""Tables of campaigns that were never run, made of random numbers of a fixed seed: plausible, and quick to make."""

from __future__ import annotations

import numpy as np
import pandas as pd

FAMILIES = (
    "rest", "line", "circle", "sinus", "stop-and-go", "forward-reverse", "park", "spin", "slow-decay", "random",
)  # fmt: skip
LAWS = (
    "universal", "published", "kanayama", "samson", "jiang_nijmeijer", "feedback_linearisation", "look_ahead",
)  # fmt: skip
POSITION_LIMIT, HEADING_LIMIT = 0.01, 0.02  # [m], [rad]


def campaign_starts(
    laws: tuple[str, ...] = LAWS[:1],
    families: tuple[str, ...] = FAMILIES,
    count: int = 50,
    share: float | None = None,
    lost: float = 0.0,
    seed: int = 0,
) -> pd.DataFrame:
    """Returns `starts` of a campaign.

    Args:
        laws: their labels.
        families: names of the references.
        count: starts for every law and family, the same for all of them.
        share: how many converge; None gives every law and family a share of its own, the first law 1.
        lost: how many of those that do not converge were lost.
        seed: of everything random.
    """
    rng = np.random.default_rng(seed)
    where = _places(rng, count)
    parts = []
    for place, law in enumerate(laws):
        for family in families:
            own = share if share is not None else 1.0 if place == 0 else rng.choice([0.0, 0.01, 0.4, 0.98, 1.0])
            runs = _runs(rng, where, own, lost)
            parts.append(pd.DataFrame({"law": law, "family": family, "start": np.arange(count), **where, **runs}))
    return pd.concat(parts, ignore_index=True)


def _places(rng: np.random.Generator, count: int) -> dict[str, np.ndarray]:
    """Returns where followers begin: in a disc of 10 m, one in twenty at its centre."""
    radius, bearing, theta = 10 * np.sqrt(rng.uniform(0, 1, count)), *rng.uniform(-np.pi, np.pi, (2, count))
    radius[rng.uniform(0, 1, count) < 0.05] = 0.0
    v, omega = rng.uniform(-1, 1, (2, count))
    return {"x": radius * np.cos(bearing), "y": radius * np.sin(bearing), "theta": theta, "v": v, "omega": omega}


def _runs(rng: np.random.Generator, where: dict[str, np.ndarray], share: float, lost: float) -> dict[str, np.ndarray]:
    """Returns what became of runs: those from far away take longest, those that head across fail first."""
    count = len(where["x"])
    across = np.abs(np.sin(where["theta"] / 2)) + 0.3 * rng.standard_normal(count)
    converged = across.argsort().argsort() < round(share * count)
    ran_away = ~converged & (rng.uniform(0, 1, count) < lost)
    distance = np.hypot(where["x"], where["y"])
    time = 6 + distance + rng.gamma(2.0, 1.5, count) + 4 * np.abs(where["theta"]) / np.pi
    small, large = 10 ** rng.uniform(-11, -3, (2, count)), 10 ** rng.uniform(-1.5, 0.5, (2, count))
    position, heading = np.where(converged, small, large)
    return {
        "converged": converged,
        "lost": ran_away,
        "late_position": np.where(ran_away, np.inf, position),
        "late_heading": np.where(ran_away, np.inf, heading),
        "settling_time": np.where(converged, np.minimum(time, 64.0), np.nan),
        "peak_utilisation": rng.uniform(0.2, 0.6, count),
        "saturated": np.where(rng.uniform(0, 1, count) < 0.1, 0.01, 0.0),
        "effort_x": rng.uniform(0.2, 0.6, count),
        "effort_theta": rng.uniform(0.3, 0.9, count),
        "switches": rng.integers(0, 4, count),
    }


def campaign_cells(starts: pd.DataFrame, backend: str = "ideal") -> pd.DataFrame:
    """Returns `cells` of a campaign with these `starts`."""
    pairs = starts.groupby(["law", "family"], sort=False)
    return pd.DataFrame([_cell(law, family, runs, backend) for (law, family), runs in pairs])


def _cell(law: str, family: str, runs: pd.DataFrame, backend: str) -> dict[str, object]:
    count, converged = len(runs), int(runs["converged"].sum())
    low, high = wilson(converged, count)
    settling = runs.loc[runs["converged"], "settling_time"]
    worst = runs.sort_values(["lost", "converged", "late_position"], ascending=[False, True, False]).iloc[0]
    return {
        "law": law, "family": family, "backend": backend, "starts": count, "converged": converged,
        "lost": int(runs["lost"].sum()), "share": converged / count, "share_low": low, "share_high": high,
        "late_position_median": runs["late_position"].median(), "late_position_max": runs["late_position"].max(),
        "late_heading_median": runs["late_heading"].median(), "late_heading_max": runs["late_heading"].max(),
        "settling_median": settling.median(), "settling_p99": settling.quantile(0.99), "settling_max": settling.max(),
        "utilisation_median": runs["peak_utilisation"].median(), "utilisation_max": runs["peak_utilisation"].max(),
        "saturated_share": (runs["saturated"] > 0).mean(), "effort_x_median": runs["effort_x"].median(),
        "effort_theta_median": runs["effort_theta"].median(), "switches_median": runs["switches"].median(),
        "switches_max": runs["switches"].max(), "worst_start": worst["start"], "position_limit": POSITION_LIMIT,
        "heading_limit": HEADING_LIMIT, "gains": "k_x=1.2 k_y=0.5",
    }  # fmt: skip


def wilson(converged: int, count: int, z: float = 1.959964) -> tuple[float, float]:
    """Returns the 95 % interval of Wilson (1927) of a share."""
    share = converged / count
    middle = (share + z**2 / (2 * count)) / (1 + z**2 / count)
    half = z / (1 + z**2 / count) * np.sqrt(share * (1 - share) / count + z**2 / (4 * count**2))
    return float(middle - half), float(middle + half)
