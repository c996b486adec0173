"""Bundled robots and scenarios are found by name, in a checkout and in a wheel."""

from __future__ import annotations

from pathlib import Path

import pytest

from nhtrack import assets


def test_the_robot_is_there_and_the_arena_is_no_robot() -> None:
    assert "nh_mini" in assets.robots()
    assert "arena" not in assets.robots()
    assert assets.find_robot("nh_mini") == assets.models_directory() / "nh_mini" / "robot.xml"
    assert assets.find_robot("nh_mini").is_file()


def test_unknown_names_get_the_nearest() -> None:
    with pytest.raises(assets.AssetError, match=r"no robot 'nhmini'; did you mean 'nh_mini'\?"):
        assets.find_robot("nhmini")
    with pytest.raises(assets.AssetError, match=r"did you mean 'paper/example1'\?"):
        assets.find_scenario("paper/exmple1")


def test_a_wheel_s_copy_comes_before_the_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "_bundled" / "models" / "other"
    folder.mkdir(parents=True)
    (folder / "robot.xml").write_text("<mujoco/>")
    monkeypatch.setattr(assets, "_PACKAGE", tmp_path)
    assert assets.robots() == ("other",)
    assert assets.robot_description("other") == ""


def test_an_installation_without_assets_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assets, "_PACKAGE", tmp_path / "a" / "b" / "c")
    with pytest.raises(assets.AssetError, match="the models/ folder is missing"):
        assets.models_directory()
