"""Steady turns: with a steer torque, or hands-free in families of circles."""
