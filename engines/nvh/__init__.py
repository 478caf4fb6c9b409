"""From crank to cabin: real engines on mounts, in cars, on roads."""
