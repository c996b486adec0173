"""Error messages are part of the product: what they say, and in what order."""

from __future__ import annotations

import inspect
import pickle

import pytest

from nhtrack import errors
from nhtrack.errors import Fault, NhtrackError, ScenarioError, SimulationDiverged, did_you_mean


def test_every_error_is_an_nhtrack_error() -> None:
    classes = [kind for _, kind in inspect.getmembers(errors, inspect.isclass) if issubclass(kind, Exception)]
    assert len(classes) >= 6
    assert all(issubclass(kind, NhtrackError) for kind in classes)


def test_divergence_names_what_who_when_and_which() -> None:
    error = SimulationDiverged("tipped over by 41 degrees", "follower", 3.14159, batch=7)
    assert str(error) == "tipped over by 41 degrees: robot 'follower' at t = 3.142 s (simulation 7)"
    assert (error.reason, error.robot, error.time, error.batch) == (
        "tipped over by 41 degrees", "follower", 3.14159, 7
    )  # fmt: skip


def test_scenario_error_lists_every_fault_in_the_order_of_the_file() -> None:
    faults = [
        Fault(12, 3, "law.kp", "expected a number > 0, got -1"),
        Fault(2, 11, "backend", "unknown"),
        Fault(12, 1, "law", "first by column"),
        Fault(0, 0, "leader", "missing"),
    ]
    error = ScenarioError("a.yaml", faults)
    assert str(error).splitlines() == [
        "a.yaml: leader: missing",
        "a.yaml:2:11: backend: unknown",
        "a.yaml:12:1: law: first by column",
        "a.yaml:12:3: law.kp: expected a number > 0, got -1",
    ]
    assert [fault.line for fault in error.faults] == [0, 2, 12, 12]


def test_fault_of_the_whole_file_has_no_key() -> None:
    assert str(ScenarioError("a.yaml", [Fault(0, 0, "", "the file is empty")])) == "a.yaml: the file is empty"


@pytest.mark.parametrize(
    ("given", "available", "expected"),
    [
        ("nh_mimi", ["arena", "nh_mini"], "did you mean 'nh_mini'? available: arena, nh_mini"),
        ("zzz", ["arena", "nh_mini"], "available: arena, nh_mini"),
        ("zzz", [], "available: none"),
    ],
)
def test_nearest_name_is_offered(given: str, available: list[str], expected: str) -> None:
    assert did_you_mean(given, iter(available)) == expected


@pytest.mark.parametrize(
    "error",
    [SimulationDiverged("fell", "leader", 1.0, 2), ScenarioError("a.yaml", [Fault(1, 2, "k", "m")])],
)
def test_errors_travel_between_processes(error: NhtrackError) -> None:
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)
