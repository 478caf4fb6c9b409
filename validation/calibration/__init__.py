"""Calibration of the certificate: runs with known true motion against the statements of the certificate."""
