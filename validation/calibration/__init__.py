"""Runs whose true motion is known, against what the certificate says of them."""
