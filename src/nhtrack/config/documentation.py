"""The JSON Schemas of scenario, campaign and sweep files, and pages of docs/ written from them.

`python -m nhtrack.config.documentation docs` writes the pages.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from nhtrack.config.campaign import Campaign
from nhtrack.config.scenario import Scenario
from nhtrack.config.sweep import COLUMNS, METRICS, Sweep
from nhtrack.references import CONSTANTS, FUNCTIONS
from nhtrack.section import Section, title_of

COMMAND = "python -m nhtrack.config.documentation docs"

_BOUNDS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}


def json_schema(model: type[Section] = Scenario) -> dict[str, Any]:
    """Returns the JSON Schema (draft 2020-12) of a kind of file."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **model.model_json_schema()}


def scenario_reference() -> str:
    """Returns docs/scenario.md: every section of a scenario file, every key with type, default and meaning."""
    functions = ", ".join(f"`{name}`" for name in sorted(FUNCTIONS))
    constants = ", ".join(f"`{name}`" for name in ("t", *CONSTANTS))
    sections = [_section(name, part) for name, part in _sections("Scenario", json_schema(Scenario))]
    formulas = _FORMULAS.format(functions=functions, constants=constants)
    return "\n".join([_INTRODUCTION.format(command=COMMAND), *sections, formulas])


def campaign_reference() -> str:
    """Returns docs/campaign.md: the sections that a campaign file has and a scenario file has not."""
    shared = {"Scenario", *json_schema(Scenario)["$defs"]}
    parts = [(name, part) for name, part in _sections("Campaign", json_schema(Campaign)) if name not in shared]
    text = "\n".join([_CAMPAIGNS.replace("{command}", COMMAND), *(_section(name, part) for name, part in parts)])
    for name in shared:  # sections that scenarios have as well are described there
        text = text.replace(f"](#{_anchor(name)})", f"](scenario.md#{_anchor(name)})")
    return text


def sweep_reference() -> str:
    """Returns docs/sweep.md: the sections of a sweep file, and the columns of its table."""
    parts = [_section(name, part) for name, part in _sections("Sweep", json_schema(Sweep))]
    rows = [f"| `{name}` | {meaning} |" for name, meaning in METRICS.items()]
    metrics = "\n".join(["## Metrics", "", _METRICS, "| metric | meaning |", "|---|---|", *rows]) + "\n"
    own = ", ".join(f"`{name}`" for name in COLUMNS)
    return "\n".join([_SWEEPS.replace("{command}", COMMAND).replace("{columns}", own), *parts, metrics])


def _sections(whole: str, schema: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yields every section after the one that first speaks of it, the whole file first."""
    waiting: list[tuple[str, Mapping[str, Any]]] = [(whole, schema)]
    seen = {whole}
    while waiting:
        name, part = waiting.pop(0)
        yield name, part
        fresh = [other for other in _mentioned(part["properties"]) if other not in seen]
        seen.update(fresh)
        waiting = [(other, schema["$defs"][other]) for other in fresh] + waiting


def _mentioned(node: Any) -> list[str]:
    """Returns the names of the sections a part of the schema refers to, in order, each once."""
    if isinstance(node, Mapping):
        own = [node["$ref"].rsplit("/", 1)[-1]] if "$ref" in node else []
        found = own + [name for key, value in node.items() if key != "discriminator" for name in _mentioned(value)]
    elif isinstance(node, list):
        found = [name for value in node for name in _mentioned(value)]
    else:
        found = []
    return list(dict.fromkeys(found))


def _section(name: str, part: Mapping[str, Any]) -> str:
    lines = [
        f"## {title_of(name)}",
        "",
        part["description"],
        "",
        "| key | type | default | meaning |",
        "|---|---|---|---|",
    ]
    required = part.get("required", ())
    # What a section is called comes first, whichever class its keys were inherited from.
    for key, value in sorted(part["properties"].items(), key=lambda item: item[0] != "name"):
        meaning = value["description"].replace("|", "\\|")
        default = "required" if key in required else f"`{json.dumps(value['default'])}`"
        if isinstance(value.get("default"), dict) and value["default"]:
            default = "as below"
        lines.append(f"| `{key}` | {_type(value)} | {default} | {meaning} |")
    return "\n".join(lines) + "\n"


def _anchor(name: str) -> str:
    """Returns where a page has the section of a class name."""
    return title_of(name).lower()


def _type(value: Mapping[str, Any] | bool) -> str:
    """Returns the type of a key in words, with its bounds."""
    if not isinstance(value, Mapping) or not value:
        return "anything"
    if "$ref" in value:
        name = value["$ref"].rsplit("/", 1)[-1]
        return f"[{title_of(name)}](#{_anchor(name)})"
    for union in ("oneOf", "anyOf"):
        if union in value:
            return " or ".join(_type(form) for form in value[union])
    if "const" in value:
        return f"`{value['const']}`"
    if "enum" in value:
        return ", ".join(f"`{choice}`" for choice in value["enum"])
    if value.get("type") == "array":
        if "prefixItems" in value:
            return f"list of {len(value['prefixItems'])}: {_type(value['prefixItems'][0])}"
        return f"list of {_type(value['items'])}"
    if value.get("type") == "object":
        return f"`name: ...` lines, each {_type(value['additionalProperties'])}"
    words = {
        "number": "number",
        "integer": "whole number",
        "boolean": "`true` or `false`",
        "string": "text",
        "null": "`null`",
    }
    bounds = [f"{sign} {value[bound]:.6g}" for bound, sign in _BOUNDS.items() if bound in value]
    return " ".join([words[value["type"]], ", ".join(bounds)]).strip()


_INTRODUCTION = """# Scenario files

<!-- Written by `{command}`; do not edit. -->

A scenario is one YAML file: one tree, no includes, no anchors. Unknown keys, wrong types and numbers that are
not finite are refused, all of them at once, each with its line. `nhtrack init` writes a commented file to
start from, `nhtrack validate` checks one and warns of leaders beyond law or robot, `nhtrack schema` prints the
JSON Schema for editors, and `nhtrack run --set key.path=value` changes any key.

Scenario units are whatever lengths and times the file is written in; `similarity` maps them to metres and
seconds. Angles are radians. A relative path starts from the file's folder. Wherever a number is wanted a formula of
numbers may stand, such as `6*pi` or `sqrt(2)/2` (see [Formulas](#formulas)).
"""

_CAMPAIGNS = """# Campaign files

<!-- Written by `{command}`; do not edit. -->

A campaign is a scenario with one follower whose law, reference and start vary: one YAML file, run with
`nhtrack campaign`, checked like a scenario (`nhtrack validate`, `nhtrack schema --campaign`). Its leader begins at the
origin and heads along x, unless its input says where. Bundled references are named alone or by set, `slow` or `quick`;
one of your own is two signals, any `input` of a scenario's leader, or signals over a `grid` of one or two numbers:

```yaml
families:
  - slow                                          # all of the bundled set
  - {name: mine, u_x: 0.5*cos(t), u_theta: 0}
  - {name: lap, input: {poses: lap.csv}}
  - name: swing                                   # 7 x 3 references, and a map of them
    grid: {f: {from: 0.1, to: 10, count: 7, log: true}, A: [0.1, 0.5, 2]}
    u_x: A*f*cos(f*t)
    u_theta: 0
    labels: {f: "frequency [rad/s]", A: "speed [m/s]"}
```

References beyond a law or the robot are told before it runs ([which](theory.md#which-leaders-can-be-followed)). What
came of the bundled ones is told in [convergence.md](convergence.md). Sections that scenarios have as well are in
[scenario.md](scenario.md).
"""

_SWEEPS = """# Sweep files

<!-- Written by `{command}`; do not edit. -->

A sweep is one scenario run many times, with other values of some of its keys: one YAML file, run with `nhtrack sweep`
(`nhtrack.sweep` in Python) and checked like a scenario (`nhtrack validate`, `nhtrack schema --sweep`). `nhtrack init
--sweep` writes one to start from, `nhtrack sweep --dry-run` tells runs, time and disk.

```yaml
name: ice
base: paper/example1                              # or a scenario file, relative to this one
set: {duration: 6, leader.virtual: true}          # the same in every run
axes:
  physics.friction: {from: 0.05, to: 0.8, count: 16, log: true}
  law.delay_periods: [0, 1]
  law: {choices: {printed: published, rival: {name: kanayama}}}
metrics: [late_position_error, gap_position_max]
expressions: {cost: late_position_error/0.01 + peak_utilisation}
pareto: [[cost, gap_position_max]]
```

Every combination of all values runs, the first axis slowest. With `sample: {method: sobol, count: 1024}` points are
drawn in the space of all axes instead, and an axis may be a distribution: `{uniform: [a, b]}`, `{log_uniform: [a, b]}`
or `{normal: [mean, deviation]}`; one with values takes each equally often. A Sobol sequence is even for a power of two
of points only. A section comes before what is in it: `law` names the law, then `law.delay_periods` sets what all have.

`sample: {method: saltelli, count: 512}` draws what Sobol indices are reckoned from (SALib): 512 groups of as many
points as axes and two. An index says which share of a metric's variance an axis brings by itself, and with all that it
does together with others; the variance is over the axes' distributions, of repetitions the mean counts, and groups in
which a run has no value are left out, which the page says. `pareto` names pairs of columns whose fronts are drawn: the
runs that no other beats in both, the smaller the better.

The results folder has `runs.parquet`, a row a run ({columns}, the axes by their keys, metrics), `sweep.json` (what was
asked for, versions, and hashes of the files that runs read), `parts/`, `figures/`, `extremes/` (scenario files of the
runs with the smallest and the largest of each metric) and `report.html`: maps of any two axes, curves, fronts, and for
every run that is clicked the command that repeats it. Of many runs the page has maps and curves of all, and dots of
some, which it says. `key` is a hash of all that a run depends on: scenario, changes, laws, robots, tables, versions.

What was stopped or killed goes on with the same command and loses no part that was done; where a file, the scenario or
a version is no longer the same it is refused, by name. `--executor` says what does the runs: processes of this machine,
or a Ray cluster of several ([many machines](scaling.md)). The numbers of a run are those of `nhtrack run` with the same
changes, to the last bit (sums over a run to 1e-12), however the sweep is divided: runs that differ in gains, starts or
seed alone go side by side through one compiled model. A run that is lost, that its values do not allow, or that ends
three processes, is a row with its reason. With `repeats` the k-th run of every point has the scenario's seed + k, the
same noise at every point.

![Late position error of three laws, by delay and by how far they are asked ahead](figures/sweep_delay.png)

This is `sweep/delay`: 147 runs on wheels behind a figure of eight, at 50 Hz. On the diagonal laws are asked ahead by as
much as their commands are late: 80 ms late `agile` then keeps within 21 µm, 0.49 mm where it is not asked ahead. At
160 ms that is 92 µm, and 0.76 m.

![Largest distance of wheels from their twin, by friction and by a gain of the law](figures/sweep_friction_gain.png)

This is `sweep/friction_gain`: 10 000 runs on wheels of 24 s, 16 minutes on two cores, 0.17 s of the processor a run; at
eight frictions runs took 1.11 times what the same steps take in bare `mj_step` (0.96 to 1.38). From a friction of 0.26
on, wheels keep within 70 nm of their ideal twins at every gain; below, they slide and part by up to 0.12 m.
"""

_METRICS = """Of a run's worst follower, or of its worst robot on wheels, as `summary.json` has them; not known (NaN)
where the run was lost. Units are metres, radians and seconds on the robot's clock.
"""

_FORMULAS = """## Formulas

Where a formula is allowed, it is arithmetic in {constants} with `+ - * / // % **`, comparisons (chained ones
too), `and`, `or`, `not`, `a if condition else b`, `where(condition, a, b)` and the functions {functions}. It
is asked at the middle of every control period, in scenario time, and must be 1e12 in magnitude at most there, as
all numbers of a file.
"""


if __name__ == "__main__":
    pages = {"scenario.md": scenario_reference(), "campaign.md": campaign_reference(), "sweep.md": sweep_reference()}
    for file, page in pages.items():
        (Path(sys.argv[1]) / file).write_text(page, encoding="utf-8")
