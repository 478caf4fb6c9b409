"""What forgotten terms break."""
