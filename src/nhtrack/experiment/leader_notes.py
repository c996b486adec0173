"""How well the leader's accelerations take it along the path that a scenario gives; all of it needs a time scale."""

from math import inf

from nhtrack.config.scenario import Scenario
from nhtrack.experiment.build import instants_of
from nhtrack.references import Departure, Motion, Reference, Table

_ROUNDING = 1e-9  # of the end of a run
_TURNED_AWAY = 0.1  # [rad], of the ideal leader from its path


def leader_notes(scenario: Scenario) -> tuple[str, ...]:
    """Returns how far the ideal leader is from its path at the ends of control periods, in a sentence."""
    departure = _departure(scenario)
    if departure is None:
        return ()
    length = 1e6 * scenario.similarity.length
    far = f"{length * departure.largest:.3g} µm (rms {length * departure.rms:.3g} µm) and {departure.heading:.2g} rad"
    return (f"{scenario.leader.name}: on the ideal model it is within {far} of its path",)


def leader_warnings(scenario: Scenario) -> tuple[str, ...]:
    """Returns that the leader leaves its path, or has not come to its end when the run does, in sentences."""
    departure, motion, name = _departure(scenario), scenario.leader.input.reference(), scenario.leader.name
    found = []
    if departure is not None and departure.heading > _TURNED_AWAY:
        found.append(
            f"{name}: heads {departure.heading:.2g} rad away from its path on the ideal model, by jumps of the path or "
            f"because control periods of {1 / scenario.control_rate:g} s are too long for it"
        )
    if isinstance(motion, Motion) and scenario.duration < motion.end < float("inf"):
        found.append(f"{name}: the run ends at t = {scenario.duration:g}, before its path does at t = {motion.end:.4g}")
    # Of segments the last end is written by hand, and 0 after it is meant.
    end = motion.u_x.end if isinstance(motion, Reference) and isinstance(motion.u_x, Table) else inf
    if end < scenario.duration * (1 - _ROUNDING):
        found.append(
            f"{name}: leader.input has rows until t = {end:g} only, and the run ends at {scenario.duration:g}: it is 0 "
            "from there on; a row at the end of the run would say so"
        )
    return tuple(found)


def _departure(scenario: Scenario) -> Departure | None:
    """Returns how far the ideal leader is from its path, None where it has none."""
    motion = scenario.leader.input.reference()
    if not isinstance(motion, Motion) or not motion.tracked:
        return None
    return motion.departure(instants_of(scenario))
