"""The mechanism as data that reads like the machine: bodies, joints, drivers, forces, signals, measures."""
