"""The rooms of flexmb: what each may import, and which room is the door to which third-party package.

The order is that of docs/architecture.md. Imports point upwards in it, never sideways between kinds.
"""

# room: the rooms (or single modules of them) that it may know. `errors` and `told` are open to all.
MAY_KNOW = {
    "errors": (),
    "told": (),
    "files": (),
    "found": (),
    "lock": (),
    "broken_pipes": (),
    "ctrl_c": (),
    "drain": (),
    "hdf5_probe": (),
    "hdf5_seal": (),
    "hdf5": ("files", "found", "drain", "hdf5_seal"),
    "math": ("lock",),
    "model": ("files", "hdf5", "math"),
    "fem": (
        "files",
        "found",
        "broken_pipes",
        "hdf5",
        "math",
        "model.described",
        "model.material",
        "model.numbering",
        "model.plausibility",
    ),
    "reduction": ("math", "model", "fem.beside", "fem.fe_model", "fem.surface_load"),
    "parts": ("files", "lock", "math", "model", "fem", "reduction"),
    "profiles": ("math", "model.described"),
    "constraints": ("math", "model"),
    "surfaces": ("math", "model", "fem.surface_file", "profiles"),
    "bodies": ("math", "model", "fem.meshes.skin_triangles"),
    "joints": ("math", "model", "constraints"),
    "forces": ("math", "model", "profiles", "constraints", "surfaces"),
    "mechanisms": ("math", "model", "bodies", "joints"),
    "sensors": ("math", "model", "constraints", "surfaces"),
    "events": ("math", "model", "constraints", "joints", "sensors"),
    "system": ("math", "model", "constraints"),
    "tree": ("math", "model", "constraints", "system"),
    "results": ("files", "lock", "hdf5", "math", "model", "system"),
    "integrate": ("math", "model", "constraints", "surfaces", "system", "tree", "results"),
    "trust": ("files", "math", "model", "system", "tree", "results", "integrate"),
    "io": (
        "files",
        "found",
        "hdf5",
        "math",
        "model",
        "fem",
        "reduction",
        "parts",
        "profiles",
        "constraints",
        "surfaces",
        "bodies",
        "joints",
        "forces",
        "sensors",
        "events",
        "system",
        "results",
    ),
    "view": ("files", "math", "model", "surfaces", "bodies", "results", "io"),
    "study": ("files", "found", "lock", "broken_pipes", "ctrl_c", "math", "model", "parts", "results", "io"),
    "fmi": ("files", "found", "model", "forces", "sensors", "results", "io"),
    "cli": (),
}

# room: the rooms of which it may know the door (the package) but no module behind it.
MAY_CALL = {
    "io": ("integrate",),
    "study": ("integrate",),
    "fmi": ("integrate",),
    "cli": tuple(MAY_KNOW),
}

# room: exceptions inside what it may know.
MUST_NOT_KNOW = {
    "model": ("math.kernel",),
    "joints": ("math.kernel",),
    "reduction": ("model.model",),
    "parts": ("model.model",),
}

# Only the public face of the package may be imported here.
MAY_USE_THE_FACE = ("cli", "study")

# third-party package (or standard parser): files below flexmb/ that may import it.
DOORS = {
    "numba": ("math/",),
    "llvmlite": ("math/",),
    "threadpoolctl": ("math/",),
    "pypardiso": ("math/",),
    "sksparse": ("math/",),
    "h5py": ("hdf5.py", "hdf5_probe.py"),
    "skfem": ("fem/",),
    "meshio": ("fem/",),
    "gmsh": ("fem/meshes/gmsh_solids.py",),
    "trimesh": ("fem/surface_file.py",),
    "pyyeti": ("fem/matrices/op2.py", "fem/matrices/op4.py"),
    "sksundae": ("integrate/",),
    "control": ("integrate/linear/plant.py",),
    "tomllib": ("io/",),
    "vtk": ("io/", "view/"),
    "vtkmodules": ("io/", "view/"),
    "pyvista": ("io/", "view/"),
    "matplotlib": ("view/",),
    "pythonfmu": ("fmi/",),
    "pythonfmu3": ("fmi/",),
    "fmpy": ("fmi/",),
    "precice": ("fmi/",),
    "imageio": ("view/",),
    "imageio_ffmpeg": ("view/",),
    "dask": ("study/",),
    "distributed": ("study/",),
    "pyarrow": ("study/",),
    "numpy": ("",),
    "scipy": ("",),
}

HEAVY = (
    "pyvista",
    "vtk",
    "vtkmodules",
    "meshio",
    "skfem",
    "matplotlib",
    "sksundae",
    "h5py",
    "gmsh",
    "pyyeti",
    "control",
    "pythonfmu",
    "pythonfmu3",
    "fmpy",
    "precice",
    "dask",
    "distributed",
    "pyarrow",
)
"""Packages that `import flexmb` must not load: they are imported where they are used."""
