"""Suite: every case against theory, other formulations and other engines, and one report (``mbsd3d validate``)."""
