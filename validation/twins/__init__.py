"""Counterpart models in other formulations and engines: joint definitions in numpy, MuJoCo and Exudyn."""
