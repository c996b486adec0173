"""A scenario as YAML, and what each of its keys means."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedSeq


def yaml_text(tree: Mapping[str, Any]) -> str:
    """Returns a tree as YAML; lists of plain values stand in one line."""
    yaml, stream = YAML(), io.StringIO()
    yaml.representer.add_representer(type(None), _null)
    yaml.width = 100
    yaml.indent(mapping=2, sequence=4, offset=2)
    yaml.dump(_flowing(tree), stream)
    return stream.getvalue()


def meanings(tree: Mapping[str, Any], schema: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Returns every key that a scenario uses, with its description, each once.

    Args:
        tree: the scenario; what the schema does not know is left out.
        schema: JSON Schema of scenario files, with `$defs`.

    Returns:
        Dotted keys such as `law.kp` or `followers[].name`, in the order of the scenario.
    """
    return list(dict(_described(tree, schema, schema.get("$defs", {}), "")).items())


def _described(
    tree: Mapping[str, Any], schema: Mapping[str, Any], sections: Mapping[str, Any], prefix: str
) -> Iterator[tuple[str, str]]:
    for key, value in tree.items():
        node = schema.get("properties", {}).get(key)
        if node is None:
            continue
        yield prefix + key, node.get("description", "")
        items = value if isinstance(value, list) else [value]
        mark = "[]." if isinstance(value, list) else "."
        for item in items:
            section = _section_of(item, node, sections) if isinstance(item, Mapping) else None
            if section is not None:
                yield from _described(item, section, sections, prefix + key + mark)


def _section_of(tree: Mapping[str, Any], node: Any, sections: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Returns the section among those a key may hold that has all of a mapping's keys and its fixed values."""
    for section in _candidates(node, sections):
        known = section["properties"]
        fixed = ((key, value["const"]) for key, value in known.items() if "const" in value)
        if set(tree) <= set(known) and all(tree.get(key, value) == value for key, value in fixed):
            return section
    return None


def _candidates(node: Any, sections: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    if isinstance(node, list):
        for value in node:
            yield from _candidates(value, sections)
    elif isinstance(node, Mapping):
        if "$ref" in node:
            yield from _candidates(sections[node["$ref"].rsplit("/", 1)[-1]], sections)
        if "properties" in node:
            yield node
        for part in ("items", "anyOf", "oneOf"):
            yield from _candidates(node.get(part), sections)


def _null(representer: Any, _: None) -> Any:
    """Writes `null` out: nothing at all looks like a mistake."""
    return representer.represent_scalar("tag:yaml.org,2002:null", "null")


def _flowing(tree: Any) -> Any:
    """Returns a tree whose lists of plain values are written in one line."""
    if isinstance(tree, Mapping):
        return {key: _flowing(value) for key, value in tree.items()}
    if not isinstance(tree, list):
        return tree
    items = CommentedSeq(_flowing(item) for item in tree)
    if not any(isinstance(item, (Mapping, list)) for item in tree):
        items.fa.set_flow_style()
    return items
