"""Every run can be seen: pages, live views, pictures, films and glTF files.

What users call:

- `drawable`, `viewable`: the methods of systems, and of solutions and modes; all options and their meaning
- `layers`: what is shown and hidden together, by one set of names

What is drawn, in every medium; no plotting library:

- `drawing`: triangles, wires, links and names of a system, each fixed in a body
- `artist`: makes the drawing of a system; `glyphs`: what its joints look like
- `frames`: poses in equal steps of time; `motion`: arrows and traces; `curves`: lines over time
- `camera`: from where one looks, and perspective; `grid`: round lengths
- `meshes`: normals and edges of triangles; `sticks`: coils, rods and arrows, and how they are laid along vectors

Pages and live views, by viser:

- `show`: from what is asked for to a `View` (`page`) or a `LiveView` (`live`, with the widgets of `panel`)
- `content`: what a page holds, as numbers; assets/ has the player that reads them
- `stage`: the scene of viser; `copies`: its arrows and links; `recorder`: all that is no public part of viser

Pictures and films, by matplotlib:

- `picture`: a figure of one moment or several; `reel`: the frames of a film; `film`: GIF and MP4 files
- `painter`: paints poses from far to near; `shading`: its triangles, `pointers`: its arrows, `labels`: its names

glTF, by pygltflib:

- `gltf`: a run as a file; `gltf_asset`: arrays, materials, nodes and bytes
"""
