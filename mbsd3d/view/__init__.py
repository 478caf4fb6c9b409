"""Pages, live views, pictures, films and glTF files of systems, runs and modes.

Users call methods of systems, solutions and modes; `mbsd3d.api.drawable` and `mbsd3d.api.viewable` give the options.

- `scene`: what every medium draws: the drawing of a system, poses, arrows, traces and curves over time, the camera
- `page`: from the options to a `View` or a `LiveView`, by viser; only `recorder` uses its private parts
- `explore`: tables of a mechanism over parameters, from which `page/assets/solver.js` solves it in the page
- `picture` and `film`: matplotlib figures, painted from far to near, and GIF and MP4 files of them
- `gltf`: a run as a file, by pygltflib
"""
