"""Models of MuJoCo (MJCF) and ROS (URDF), read in a guarded process."""
