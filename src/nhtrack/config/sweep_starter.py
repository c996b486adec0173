"""The commented sweep to start from."""

from __future__ import annotations

import json

_TEXT = """# A sweep: one scenario run many times, with other values of some of its keys.
# Run it with `nhtrack sweep`, look at how much it is with `--dry-run`; every key: docs/sweep.md.

name: {name}

base: tour/hello                       # a bundled name, or a scenario file relative to this one
set: {{duration: 10}}                    # what is the same in every run; any key of the scenario, dotted

axes:                                  # what varies: any keys of the scenario, dotted
  physics.friction: {{from: 0.1, to: 0.8, count: 4}}
  law.k: [1, 2, 4]
  # law: {{choices: {{printed: published, rival: {{name: kanayama}}}}}}

# Without `sample` every combination runs. With it points are drawn, and axes may be
# {{uniform: [a, b]}}, {{log_uniform: [a, b]}} or {{normal: [mean, deviation]}}:
# sample: {{method: sobol, count: 64, seed: 0}}

metrics: [late_position_error, gap_position_max, peak_utilisation]
expressions: {{cost: late_position_error/0.01 + peak_utilisation}}
"""


def sweep_starter(name: str) -> str:
    """Returns the text of a sweep that can be run as it is."""
    return _TEXT.format(name=json.dumps(name))
