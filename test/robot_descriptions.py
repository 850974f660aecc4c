"""Small descriptions of robots, built as users' own are: for tests of importing."""

import os

import numpy as np

PLUGIN = """
  <gazebo>
    <plugin name="drive" filename="libgazebo_ros_diff_drive.so">
      <commandTopic>cmd_vel</commandTopic>
      <updateRate>30</updateRate>
      <leftJoint>wheel_left_joint</leftJoint>
      <rightJoint>wheel_right_joint</rightJoint>
      <wheelSeparation>0.20</wheelSeparation>
      <wheelDiameter>0.08</wheelDiameter>
      <wheelAcceleration>2</wheelAcceleration>
      <wheelTorque>3</wheelTorque>
    </plugin>
  </gazebo>
"""

WHEEL = """
  <joint name="wheel_{side}_joint" type="continuous">
    <parent link="base_link"/>
    <child link="wheel_{side}_link"/>
    <origin xyz="0 {y} 0.03" rpy="-1.5707963267948966 0 0"/>
    <axis xyz="0 0 1"/>
    {limit}
  </joint>
  <link name="wheel_{side}_link">
    <visual>
      <origin rpy="1.5707963267948966 0 0"/>
      <geometry><mesh filename="package://scout_description/meshes/tire.stl"/></geometry>
      <material name="dark"/>
    </visual>
    <collision><geometry><cylinder length="0.02" radius="0.04"/></geometry></collision>
    <inertial>
      <mass value="0.05"/>
      <inertia ixx="2e-5" ixy="0" ixz="0" iyy="2e-5" iyz="0" izz="4e-5"/>
    </inertial>
  </link>
"""

# Mass 0.8 + 2 * 0.05 + 0.1 = 1.0 kg: base_footprint and imu_link have none.
BODY = """
  <material name="dark"><color rgba="0.3 0.3 0.3 1"/></material>
  <link name="base_footprint"/>
  <joint name="base_joint" type="fixed">
    <parent link="base_footprint"/><child link="base_link"/><origin xyz="0 0 0.01"/>
  </joint>
  <link name="base_link">
    <visual>
      <geometry><mesh filename="package://scout_description/meshes/base.stl"/></geometry>
      <material name="dark"/>
    </visual>
    <collision><origin xyz="-0.03 0 0.06"/><geometry><box size="0.2 0.16 0.1"/></geometry></collision>
    <inertial>
      <mass value="0.8"/>
      <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.003"/>
    </inertial>
  </link>
  <joint name="caster_joint" type="fixed">
    <parent link="base_link"/><child link="caster_link"/><origin xyz="-0.1 0 0"/>
  </joint>
  <link name="caster_link">
    <collision><geometry><sphere radius="0.01"/></geometry></collision>
  </link>
  <joint name="imu_joint" type="fixed"><parent link="base_link"/><child link="imu_link"/></joint>
  <link name="imu_link"/>
  <joint name="scan_joint" type="fixed">
    <parent link="base_link"/><child link="scan_link"/><origin xyz="-0.03 0 0.13"/>
  </joint>
  <link name="scan_link">
    <collision><geometry><cylinder length="0.04" radius="0.05"/></geometry></collision>
    <inertial>
      <mass value="0.1"/>
      <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/>
    </inertial>
  </link>
  <gazebo reference="wheel_left_link"><mu1>0.7</mu1></gazebo>
  <gazebo reference="wheel_right_link"><mu1>0.8</mu1></gazebo>
"""

LIMIT = '<limit velocity="10" effort="1"/>'

CONTROLLER = """
scout:
  joint_state_controller: {type: joint_state_controller/JointStateController, publish_rate: 50}
  mobile_base_controller:
    type: diff_drive_controller/DiffDriveController
    left_wheel: wheel_left_joint
    right_wheel: [wheel_right_joint]
    publish_rate: 40
    cmd_vel_timeout: 0.25
    wheel_separation_multiplier: 1.1
    pose_covariance_diagonal: [0.001, 0.001, 1.0e+6, 1.0e+6, 1.0e+6, 0.03]
    linear: {x: {has_velocity_limits: true, max_velocity: 1.0, min_velocity: -0.5,
                 has_acceleration_limits: true, max_acceleration: 3.0}}
    angular: {z: {has_velocity_limits: true, max_velocity: 2.0}}
"""


def urdf(plugin=PLUGIN, limit=LIMIT, body=BODY, left=0.1, right=-0.1):
    """Return the text of a URDF whose axle's centre lies 0.04 m above the ground, below base_link."""
    wheels = "".join(
        WHEEL.format(side=side, y=y, limit=limit) for side, y in (("left", left), ("right", right))
    )
    return '<?xml version="1.0"?>\n<robot name="scout">{}</robot>\n'.format(body + wheels + plugin)


def xacro():
    """Return the text of a xacro file with an argument, a property and an included file."""
    text = urdf(plugin="").replace('mass value="0.8"', 'mass value="${base_mass}"')
    head = (
        '<robot name="scout" xmlns:xacro="http://ros.org/wiki/xacro">\n'
        '<xacro:include filename="$(find scout_description)/urdf/drive.xacro"/>\n'
        '<xacro:arg name="base_mass" default="0.8"/>\n'
        '<xacro:property name="base_mass" value="$(arg base_mass)"/>\n'
    )
    return text.replace('<robot name="scout">', head)


def box_stl(low, high):
    """Return a binary STL file of two triangles that span the box from ``low`` to ``high``."""
    low, high = np.array(low, dtype="<f4"), np.array(high, dtype="<f4")
    triangle = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    rows = np.zeros(2, triangle)
    rows["corners"][0] = [low, high, low]
    rows["corners"][1] = [high, low, high]
    return b"\0" * 80 + (2).to_bytes(4, "little") + rows.tobytes()


def write_package(directory, text=None, name="scout.urdf"):
    """Write the ROS package scout_description with its meshes below ``directory``.

    Returns the path of the description in it, ``text`` or else ``urdf()``.
    """
    top = os.path.join(str(directory), "scout_description")
    for inner in ("urdf", "meshes"):
        os.makedirs(os.path.join(top, inner), exist_ok=True)
    files = {
        "package.xml": b"<package><name>scout_description</name></package>",
        "meshes/base.stl": box_stl([-0.1, -0.08, 0.0], [0.1, 0.08, 0.1]),
        "meshes/tire.stl": box_stl([-0.04, -0.01, -0.04], [0.04, 0.01, 0.04]),
        "urdf/drive.xacro": '<robot name="drive">{}</robot>'.format(PLUGIN).encode(),
        "urdf/" + name: (urdf() if text is None else text).encode(),
        "urdf/control.yaml": CONTROLLER.encode(),
    }
    for file_name, content in files.items():
        with open(os.path.join(top, file_name), "wb") as file:
            file.write(content)
    return os.path.join(top, "urdf", name)
