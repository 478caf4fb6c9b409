"""What everything stands on: checks of what is given, paths, rotations, inertia, errors, style, progress."""
