"""Message packages of real vehicles, made for tests where a system lacks them.

Names and types of fields are those of crazyswarm (ros_ws, 2022), heron_msgs and ardrone_autonomy.
"""

import os
import sys

import pytest


def fields(text):
    """Return the fields of ``text``, "type name, type name", one a line."""
    return text.replace(", ", "\n")


def floats(names):
    return ", ".join("float32 " + name for name in names.split())


STAMPED = "Header header, "
CRAZYSWARM_MSG = {
    "FullState": STAMPED
    + "geometry_msgs/Pose pose, geometry_msgs/Twist twist, geometry_msgs/Vector3 acc",
    "VelocityWorld": STAMPED + "geometry_msgs/Vector3 vel, float32 yawRate",
    "Hover": STAMPED + floats("vx vy yawrate zDistance"),
    "Position": STAMPED + floats("x y z yaw"),
    "TrajectoryPolynomialPiece": "float32[] poly_x, float32[] poly_y, float32[] poly_z, "
    "float32[] poly_yaw, duration duration",
}
CRAZYSWARM_SRV = {
    "Takeoff": "uint8 groupMask, float32 height, duration duration, ---",
    "Land": "uint8 groupMask, float32 height, duration duration, ---",
    "GoTo": "uint8 groupMask, bool relative, geometry_msgs/Point goal, float32 yaw, "
    "duration duration, ---",
    "UploadTrajectory": "uint8 trajectoryId, uint32 pieceOffset, "
    "TrajectoryPolynomialPiece[] pieces, ---",
    "StartTrajectory": "uint8 groupMask, uint8 trajectoryId, float32 timescale, bool reversed, "
    "bool relative, ---",
    "SetGroupMask": "uint8 groupMask, ---",
    "NotifySetpointsStop": "uint8 groupMask, uint32 remainValidMillisecs, ---",
    "Stop": "uint8 groupMask, ---",
}
HERON = {
    "Drive": floats("left right"),
    "Helm": floats("thrust yaw_rate"),
    "Course": floats("yaw speed"),
}
NAVDATA = STAMPED + (
    "float32 batteryPercent, uint32 state, int32 magX, int32 magY, int32 magZ, int32 pressure, int32 temp, "
    + floats("wind_speed wind_angle wind_comp_angle rotX rotY rotZ")
    + ", int32 altd, "
    + floats("vx vy vz ax ay az")
    + ", uint8 motor1, uint8 motor2, uint8 motor3, uint8 motor4, uint32 tags_count, uint32[] tags_type, "
    "uint32[] tags_xc, uint32[] tags_yc, uint32[] tags_width, uint32[] tags_height, "
    "float32[] tags_orientation, float32[] tags_distance, float32 tm"
)
PACKAGES = {
    "crazyswarm": {"msg": CRAZYSWARM_MSG, "srv": CRAZYSWARM_SRV},
    "heron_msgs": {"msg": HERON},
    "ardrone_autonomy": {"msg": {"Navdata": NAVDATA}},
}


def make(directory):
    """Write Python packages with these messages and services below ``directory``."""
    import rospkg
    from genpy import generate_initpy, generator

    found = rospkg.RosPack()
    known = ("std_msgs", "geometry_msgs")
    search = {name: [os.path.join(found.get_path(name), "msg")] for name in known}
    search.update({name: [os.path.join(directory, name, "source")] for name in PACKAGES})
    for package, kinds in PACKAGES.items():
        source = search[package][0]
        os.makedirs(source)
        open(os.path.join(directory, package, "__init__.py"), "w").close()
        for kind, texts in kinds.items():
            made = {name: os.path.join(source, "{}.{}".format(name, kind)) for name in texts}
            for name, path in made.items():
                with open(path, "w") as file:
                    file.write(fields(texts[name]) + "\n")
            out = os.path.join(directory, package, kind)
            write = generator.MsgGenerator() if kind == "msg" else generator.SrvGenerator()
            assert write.generate_messages(package, list(made.values()), out, search) == 0
            generate_initpy.write_modules(out)


@pytest.fixture(scope="session")
def vehicle_packages(tmp_path_factory):
    """Return a directory with the packages, on the path of this process."""
    directory = str(tmp_path_factory.mktemp("vehicle_packages"))
    make(directory)
    sys.path.insert(0, directory)
    yield directory
    sys.path.remove(directory)
    for name in [name for name in sys.modules if name.partition(".")[0] in PACKAGES]:
        del sys.modules[name]
