"""The quick messages have the very bytes of the standard ones."""

import io
import math

import genpy
import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from mrs_simulator.ros.message_forms.planar_messages import PlanarOdometry, QuickTwist

COVARIANCE = [float(value) for value in range(36)]


def standard():
    message = Odometry()
    message.header.seq, message.header.stamp = 7, genpy.Time(12, 340)
    message.header.frame_id, message.child_frame_id = "robot12/odom", "robot12/base_link"
    message.pose.pose.position.x, message.pose.pose.position.y = 1.5, -2.5
    message.pose.pose.orientation.z = math.sin(0.35)
    message.pose.pose.orientation.w = math.cos(0.35)
    message.pose.covariance = COVARIANCE
    message.twist.twist.linear.x, message.twist.twist.angular.z = 0.3, -0.4
    message.twist.covariance = COVARIANCE[::-1]
    return message


def quick():
    message = PlanarOdometry()
    message.prepare("robot12/odom", "robot12/base_link", COVARIANCE, COVARIANCE[::-1])
    message.header.seq, message.stamp = 7, genpy.Time(12, 340)
    message.planar, message.body = (1.5, -2.5, 0.7), (0.3, 0.0, -0.4)
    return message


def wire(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def test_odometry_has_the_same_bytes_and_type():
    assert wire(quick()) == wire(standard())
    assert (PlanarOdometry._type, PlanarOdometry._md5sum) == (Odometry._type, Odometry._md5sum)


def test_odometry_is_read_alike():
    read = PlanarOdometry().deserialize(wire(standard()))
    assert read.planar == pytest.approx((1.5, -2.5, 0.7), abs=1e-15)
    assert read.body == (0.3, 0.0, -0.4) and read.stamp == genpy.Time(12, 340)


def test_twist_both_ways():
    message = QuickTwist()
    message.values = 0.3, 0.1, 0.0, 0.0, 0.5, -0.2
    plain = Twist().deserialize(wire(message))
    assert (plain.linear.x, plain.linear.y, plain.angular.y) == (0.3, 0.1, 0.5)
    assert plain.angular.z == -0.2
    assert QuickTwist().deserialize(wire(plain)).values == (0.3, 0.1, 0.0, 0.0, 0.5, -0.2)
    assert (QuickTwist._type, QuickTwist._md5sum) == (Twist._type, Twist._md5sum)


@pytest.mark.parametrize("kind, whole", [(PlanarOdometry, standard()), (QuickTwist, Twist())])
def test_a_message_cut_short_is_refused(kind, whole):
    data = wire(whole)
    for length in (0, 5, 20, len(data) // 3):
        with pytest.raises(genpy.DeserializationError):
            kind().deserialize(data[:length])
