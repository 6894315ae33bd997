"""What others call a mesh."""
from typing import Any

from . import _core


def as_mesh(mesh: Any, *, name: str = "mesh") -> _core.Mesh:
    """A Mesh from whatever has vertices and triangles.

    Takes a Mesh (as it is), an object with the attributes `vertices` and `faces` (trimesh) or
    `vertices` and `triangles` (Open3D), or a pair of arrays. Building the hierarchy of a mesh takes
    time, so build it once and keep it. Raises TypeError for anything else.
    """
    if isinstance(mesh, _core.Mesh):
        return mesh
    vertices = getattr(mesh, "vertices", None)
    for attribute in ("faces", "triangles"):
        triangles = getattr(mesh, attribute, None)
        if vertices is not None and triangles is not None:
            return _core.Mesh(_array(vertices), _array(triangles), name=name)
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return _core.Mesh(mesh[0], mesh[1], name=name)
    raise TypeError(f"{name}: expected a Mesh, an object with vertices and faces, or a pair of "
                    f"arrays, but got {type(mesh).__name__}")


def _array(values: Any) -> Any:
    """Open3D's vectors become arrays only when asked."""
    import numpy as np
    return np.asarray(values)
