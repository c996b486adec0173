"""Files of robots: texts, a URDF, a mesh."""

from __future__ import annotations

import struct
from pathlib import Path

URDF = """
<robot name="cart">
  <link name="footprint"/>
  <joint name="footprint_joint" type="fixed">
    <parent link="footprint"/> <child link="base"/> <origin xyz="0 0 0.05"/>
  </joint>
  <link name="base">
    <inertial>
      <origin xyz="-0.02 0 0.01"/> <mass value="2"/>
      <inertia ixx="0.006" ixy="0" ixz="0" iyy="0.009" iyz="0" izz="0.012"/>
    </inertial>
    <visual> <geometry> <mesh filename="package://cart_description/meshes/shell.stl"/> </geometry> </visual>
    <collision> <origin xyz="-0.02 0 0.03"/> <geometry> <box size="0.18 0.14 0.06"/> </geometry> </collision>
    <collision> <origin xyz="-0.08 0 -0.03"/> <geometry> <sphere radius="0.02"/> </geometry> </collision>
  </link>
  {wheels}
</robot>
"""

WHEEL = """
  <joint name="{side}_axle" type="continuous">
    <parent link="base"/> <child link="{side}_wheel"/> <origin xyz="0 {y} 0" rpy="-1.5707963267948966 0 0"/>
    <axis xyz="0 0 1"/>
    <limit effort="1.5" velocity="12"/>
    <dynamics damping="0.02"/>
  </joint>
  <link name="{side}_wheel">
    <inertial>
      <mass value="0.3"/> <inertia ixx="2.1e-4" ixy="0" ixz="0" iyy="2.1e-4" iyz="0" izz="4e-4"/>
    </inertial>
    <collision> <geometry> <cylinder radius="0.05" length="0.02"/> </geometry> </collision>
  </link>
"""


def urdf() -> str:
    """Returns the plain robot as a URDF."""
    return URDF.format(wheels="".join(WHEEL.format(side=s, y=y) for s, y in (("left", 0.1), ("right", -0.1))))


def written(folder: Path, name: str, text: str) -> Path:
    """Returns a new file with a text."""
    file = folder / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return file


def shell(folder: Path, name: str, scale: float = 1.0) -> Path:
    """Returns a new mesh: a tetrahedron in binary STL."""
    corners = [(0.0, 0.0, 0.05), (0.1, 0.0, 0.05), (0.0, 0.1, 0.05), (0.0, 0.0, 0.12)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    data = bytes(80) + struct.pack("<I", len(faces))
    for face in faces:
        data += struct.pack("<12f", 0, 0, 0, *(scale * x for k in face for x in corners[k])) + bytes(2)
    file = folder / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(data)
    return file
