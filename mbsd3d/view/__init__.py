"""Every run can be seen: pages, live views, pictures, films and glTF files.

Users call methods of systems, solutions and modes; `mbsd3d.api.drawable` and `mbsd3d.api.viewable` give the options.

`scene`: what is drawn, in every medium; no plotting library

- `drawing`: triangles, wires, links and names of a system, each fixed in a body, and the layers that show them
- `artist`: makes the drawing of a system; `glyphs`: what its joints look like
- `frames`: poses in equal steps of time; `motion`: arrows, traces and curves over these frames
- `camera`: from where one looks, perspective, round lengths; `meshes`: normals and edges; coils, rods and arrows

`page`: pages and live views, by viser

- `show`: from what is asked for to a `View` (`html`) or a `LiveView` (`live`, with the widgets of `panel`)
- `content`: what a page holds, as numbers; assets/ has the player that reads them
- `stage`: the scene of viser; `recorder`: all uses of private parts of viser

`picture` and `film`, by matplotlib

- `picture`: a figure of one moment or several; `painter`: paints poses from far to near; `shading`: their triangles
- `film`: GIF and MP4 files; `frames`: the images of a film

`gltf`: `export`: a run as a file; `asset`: arrays, materials, nodes and bytes, by pygltflib
"""
