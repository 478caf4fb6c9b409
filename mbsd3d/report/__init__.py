"""Report of a run: one page with its evidence, which needs neither a network nor this package.

- `page`: the page, from the template in mbsd3d/templates
- `facts`: its content: facts, tables and sentences
- `exhibits`: which figures and pictures it shows
- `wording`: numbers and counts as text
"""
