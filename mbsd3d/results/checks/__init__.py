"""The checks of a certificate, from the stored samples and the true equations."""
