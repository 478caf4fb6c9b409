"""The public objects: thin, with data below and plot, report, save and animate on them."""
