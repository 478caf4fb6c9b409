"""Systems as files of other programs: MJCF, URDF, SDF."""
