"""Bicycle as a mechanism: pose and rolling of its wheels, and its bodies, joints and loads."""
