"""Bicycles: models, stability and manoeuvres, on the public interface of `mbsd3d`."""
