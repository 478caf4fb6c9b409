"""Balance of reciprocating engines: closed form, sum of planar models and the whole engine in space, side by side.

Engine      `layouts`: 24 layouts of the data file, and the engine that a layout and masses make
Three ways  `phasor`: closed form, imports nothing of the others; `planar_sum`: one planar model per cylinder;
            `spatial`: the whole engine as a System; `harmonics`: what each returns; `balance`: all three compared
Studies     `gas`: gas forces and firing orders; `shafts`: balance shafts; `studies`: both and the rod ratio as tables
Published   `claims`: figures under the sources' assumptions and as they are; `corrections`: the statements of the data
            file on what is wrong; `truth`: the whole table
Pages       `pages`: files; `sheets`: what a page says; `drawings`: vectors, bars and curves as SVG; `looks`: shapes of
            the parts; `portrait`: the engine upright, animated and as a sketch; `templates`
Texts       `report`: tables as text; `cli`: ``python -m validation.engine_balance``
"""
