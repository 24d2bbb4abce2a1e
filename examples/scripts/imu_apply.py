"""A node of ROS 2 that applies the parameters of `gravical export --to ros2`.

    gravical export cal.json --to ros2 -o imu.yaml
    python3 imu_apply.py --ros-args --params-file imu.yaml

Acceleration has to arrive in m/s² and angular rate in rad/s.
"""

import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Imu


class ImuApply(Node):
    def __init__(self):
        super().__init__("imu_apply", automatically_declare_parameters_from_overrides=True)
        array = lambda name: np.array(self.get_parameter(name).value)
        self.accel = array("accel.matrix").reshape(3, 3), array("accel.offset")
        self.gyro = None
        if self.has_parameter("gyro.matrix"):
            matrices = [array(f"gyro.{of}").reshape(3, 3) for of in ("matrix", "g_sensitivity")]
            self.gyro = *matrices, array("gyro.offset")
        self.output = self.create_publisher(Imu, "imu/data_calibrated", 10)
        self.create_subscription(Imu, "imu/data_raw", self.calibrate, qos_profile_sensor_data)

    def calibrate(self, imu):
        a, w = imu.linear_acceleration, imu.angular_velocity
        matrix, offset = self.accel
        accel = matrix @ (np.array([a.x, a.y, a.z]) - offset)
        a.x, a.y, a.z = accel.tolist()
        if self.gyro:
            matrix, g_sensitivity, offset = self.gyro
            rate = matrix @ (np.array([w.x, w.y, w.z]) - offset - g_sensitivity @ accel)
            w.x, w.y, w.z = rate.tolist()
        self.output.publish(imu)


rclpy.init()
rclpy.spin(ImuApply())
