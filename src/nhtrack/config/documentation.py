"""The JSON Schemas of scenario and campaign files, and docs/scenario.md and docs/campaign.md written from them.

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


def _type(value: Mapping[str, Any]) -> str:
    """Returns the type of a key in words, with its bounds."""
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
seconds. Angles are radians. A relative path starts from the file's folder.
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

_FORMULAS = """## Formulas

Where a formula is allowed, it is arithmetic in {constants} with `+ - * / // % **`, comparisons (chained ones
too), `and`, `or`, `not`, `a if condition else b`, `where(condition, a, b)` and the functions {functions}. It
is asked at the middle of every control period, in scenario time, and must be finite there.
"""


if __name__ == "__main__":
    for file, page in (("scenario.md", scenario_reference()), ("campaign.md", campaign_reference())):
        (Path(sys.argv[1]) / file).write_text(page, encoding="utf-8")
