"""Changes to a scenario file that leave the rest of it as it is, to the character.

The text is composed to ruamel's node graph, which knows where every value begins and ends; only those places are
rewritten. Comments, layout, quotes and line ends stay.
"""

from __future__ import annotations

import codecs
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode

from nhtrack.config.load import Loader
from nhtrack.config.scenario import Scenario
from nhtrack.config.tree import Path as TreePath
from nhtrack.config.tree import dotted
from nhtrack.errors import NhtrackError
from nhtrack.files.atomic import atomic_path


class EditError(NhtrackError):
    """A scenario file that cannot be changed in place."""


def save_law_gains(
    source: Path,
    target: Path,
    gains: Mapping[str, float],
    marker: str,
    remarks: Sequence[str],
    loader: Loader = Loader(),  # noqa: B008 - it does not change
) -> None:
    """Writes a scenario file with other gains; it appears under its name only once it is whole.

    Args:
        source: the scenario file to start from.
        target: where to write; may be the source.
        gains: see `with_law_gains`, and so the rest.
        marker: what every remark begins with.
        remarks: comment lines.
        loader: what reads the file that is to be written, to see that it has the gains.

    Raises:
        EditError: a file whose gains cannot be changed in place; nothing is written.
        ScenarioError: the file names others that are not there when it stands at the target.
    """
    data = source.read_bytes()
    text = with_law_gains(data.decode("utf-8-sig"), gains, marker, remarks)
    law = loader.load_text(text, source=target, directory=target.parent).law
    if any(getattr(law, name) != gain for name, gain in gains.items()):
        raise EditError(f"{source}: the gains of its law cannot be changed in place")
    mark = codecs.BOM_UTF8 if data.startswith(codecs.BOM_UTF8) else b""
    with atomic_path(target) as temporary:
        temporary.write_bytes(mark + text.encode())


def with_law_gains(text: str, gains: Mapping[str, float], marker: str, remarks: Sequence[str]) -> str:
    """Returns the text of a scenario with other gains of its law, and comment lines above it that say why.

    Args:
        text: a valid scenario file.
        gains: values by the law's keys; a key that is not there yet is added behind the others.
        marker: what every remark begins with; older comment lines with it, just above the law, are replaced.
        remarks: comment lines, without the marker.

    Raises:
        EditError: no `law` section at the top level.
    """
    law_key, law = _law(text)
    values = {str(key.value): value for key, value in law.value}
    changes = [
        (values[name].start_mark.index, values[name].end_mark.index, shown_number(gain))
        for name, gain in gains.items()
        if name in values
    ]
    missing = [f"{name}: {shown_number(gain)}" for name, gain in gains.items() if name not in values]
    if missing:
        last_key, last = law.value[-1]
        between = ", " if law.flow_style else _newline(text) + " " * last_key.start_mark.column
        end = last.end_mark.index
        changes.append((end, end, "".join(between + item for item in missing)))
    start = law_key.start_mark.index
    changes.append((*_remarks_above(text, start, marker), _comment(text, marker, remarks)))
    return _changed(text, changes)


def with_values(text: str, values: Mapping[TreePath, str]) -> str:
    """Returns the text of a YAML file with other values.

    Args:
        text: the file.
        values: what is to stand there, as YAML in one line, by the paths of keys and places that lead to it.

    Raises:
        EditError: no such value.
    """
    root = YAML(typ="safe", pure=True).compose(text)
    nodes = {path: _node(root, path) for path in values}
    spans = [(node.start_mark.index, node.end_mark.index, values[path]) for path, node in nodes.items()]
    return _changed(text, spans)


def _node(node: Node, path: TreePath) -> Node:
    """Returns what keys and places lead to."""
    for key in path:
        below = dict(enumerate(node.value)) if isinstance(key, int) else {k.value: v for k, v in node.value}
        if key not in below:
            raise EditError(f"no value {dotted(path)}")
        node = below[key]
    return node


def _changed(text: str, changes: Iterable[tuple[int, int, str]]) -> str:
    """Returns a text with others from begins to ends of places in it."""
    for begin, end, new in sorted(changes, reverse=True):
        text = text[:begin] + new + text[end:]
    return text


def scenario_text(scenario: Scenario) -> str:
    """Returns a scenario file that says what a scenario does, without the keys that are at their defaults."""
    yaml: Any = YAML(typ="safe", pure=True)
    yaml.default_flow_style, yaml.sort_base_mapping_type_on_output, yaml.width = None, False, 120
    text = io.StringIO()
    yaml.dump(scenario.model_dump(mode="json", exclude_defaults=True), text)
    return text.getvalue()


def shown_number(value: float) -> str:
    """Returns a number as people write it in a scenario: the shortest form that reads back the same."""
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def _law(text: str) -> tuple[Node, MappingNode]:
    """Returns the nodes of the key `law` and of its section."""
    root = YAML(typ="safe", pure=True).compose(text)
    if isinstance(root, MappingNode):
        for key, value in root.value:
            if isinstance(key, ScalarNode) and key.value == "law" and isinstance(value, MappingNode):
                return key, value
    raise EditError("no `law:` section at the top level of the file")


def _remarks_above(text: str, start: int, marker: str) -> tuple[int, int]:
    """Returns where older remarks just above a key begin and end."""
    older = re.compile(rf"(?:^[ \t]*# {re.escape(marker)}.*\n)+\Z", re.MULTILINE).search(text[:start])
    return (older.start(), start) if older else (start, start)


def _comment(text: str, marker: str, remarks: Sequence[str]) -> str:
    return "".join(f"# {marker} {remark}{_newline(text)}" for remark in remarks)


def _newline(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"
