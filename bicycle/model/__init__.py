"""The bicycle as a mechanism: how its wheels stand and roll, and its bodies, joints and loads."""
