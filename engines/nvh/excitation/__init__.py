"""Engines with real dimensions: gas, loads on the block, main bearings, balance shafts."""
