"""Riders and steering control: a rider of five loops, handling quality, and balance assist."""
