"""The mechanism as data that reads like the machine: bodies, joints, couplings, contacts, drivers, signals, measures."""
