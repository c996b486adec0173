"""What a robot's file of a stranger may ask for in a few words, and which files it may name."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from nhtrack.errors import RobotError
from nhtrack.robots.contract import Hints
from nhtrack.robots.reading.files import load_source

MANY, POINTS = "repeated elements, more than 10000", "points in one element, more than 2e\\+07"
ASKED = {
    '<worldbody><replicate count="10001"><geom size="1"/></replicate></worldbody>': MANY,
    '<worldbody><replicate count="101"><replicate count="100"/></replicate></worldbody>': MANY,
    "<worldbody><composite count='22 22 22'/></worldbody>": MANY,
    '<worldbody><replicate prefix=">" count="10001"/></worldbody>': MANY,
    '<worldbody><replicate\n count = "&#49;0001"/></worldbody>': MANY,
    '<!-- <a " --><worldbody><replicate count="10001"/></worldbody>': MANY,
    '<include file="more.xml"/>': MANY,
    '<asset><texture type="2d" builtin="flat" width="10000" height="10000"/></asset>': POINTS,
    '<asset><hfield name="a" nrow="10000" ncol="10000" size="1 1 1 1"/></asset>': POINTS,
    '<custom><numeric name="a" size="1000000000"/></custom>': POINTS,
    '<size nuserdata="1000000000"/>': POINTS,
    '<sensor><user dim="1000000000"/></sensor>': POINTS,
    '<size memory="10G"/>': "bytes, more than",
    '<asset><mesh name="a" builtin="supersphere" params="100000 1 1"/></asset>': "a mesh of 1e\\+05 cuts",
    '<sensor><gyro site="a" nsample="1000000000"/></sensor>': POINTS,
    "".join(f'<include file="f{i}.xml"/>' for i in range(100)): "includes more than 100 files",
    f"<!-- {'a' * 20_000_000} -->": "has more than 20 MB",
    '<include file="/dev/zero"/>': "includes /dev/zero, which is no regular file",
    '<include file="pipe"/>': "pipe, which is no regular file",
    '<include file="endless"/>': "endless, which is no regular file",
    '<include file="gone.xml"/>': "gone.xml, which no such file",
    '<asset><mesh file="endless.stl"/></asset><worldbody><geom type="mesh" mesh="endless"/></worldbody>': "cannot find",
    '<asset><hfield name="a" file="/dev/zero" size="1 1 1 1"/></asset>': "cannot find height field file /dev/zero",
}


@pytest.mark.parametrize("asked", ASKED, ids=lambda asked: asked[:60])
def test_what_asks_for_too_much_is_refused(asked: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for name in ("endless", "endless.stl"):
        (tmp_path / name).symlink_to("/dev/zero")
    (tmp_path / "more.xml").write_text('<mujoco><worldbody><replicate count="10001"/></worldbody></mujoco>')
    for i in range(100):
        (tmp_path / f"f{i}.xml").write_text("<mujoco/>")
    file = tmp_path / "robot.xml"
    file.write_text(f"<mujoco>{asked}</mujoco>")
    with pytest.raises(RobotError, match=ASKED[asked]):
        load_source(file, Hints())


@pytest.mark.parametrize("piece", ["<replicate ", "<a '", "<!--", '<a x="', "<![CDATA[", "aaaa", "<a b", "<?", '"'])
def test_what_is_no_xml_takes_no_time(piece: str, tmp_path: Path) -> None:
    file = tmp_path / "robot.xml"
    file.write_text("<mujoco " + piece * (1_000_000 // len(piece)))
    began = time.process_time()
    with pytest.raises(RobotError):
        load_source(file, Hints())
    assert time.process_time() - began < 2, piece
