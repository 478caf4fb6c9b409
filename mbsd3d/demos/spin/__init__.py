"""Spin turns sideways."""
