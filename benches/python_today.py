"""The principal axes of a surface in a file with today's Python libraries. Started by benches/uploads in a separate environment.

    python_today.py METHOD FILE

Reads the file from disk, takes centroid and covariance in a few vectorised lines, and numpy.linalg.eigh of that. Prints as JSON how
long that took, without the interpreter's start and the imports, and the eigenvalues."""

import json
import sys
import time

import numpy as np


def of_points(points):
    return points, None


def of_triangles(triangles):
    """The centroids of triangles, weighted with their areas."""
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return triangles.mean(axis=1), np.linalg.norm(sides, axis=1) / 2


def pandas(path):
    import pandas

    return lambda: of_points(pandas.read_csv(path)[["x", "y", "z"]].to_numpy())


def json_numpy(path):
    def read():
        with open(path) as file:
            return of_points(np.array(json.load(file)))

    return read


def numpy_stl(path):
    from stl import mesh

    return lambda: of_triangles(mesh.Mesh.from_file(path).vectors.astype(np.float64))


def trimesh(path, **options):
    import trimesh

    def read():
        mesh = trimesh.load_mesh(path, **options)
        return mesh.triangles_center, mesh.area_faces

    return read


def trimesh_unmerged(path):
    """Without merging equal vertices, which takes the larger part of the time and changes no moment."""
    return trimesh(path, process=False)


METHODS = {
    "pandas": pandas, "json": json_numpy, "numpy-stl": numpy_stl, "trimesh": trimesh, "trimesh, unmerged": trimesh_unmerged,
}


def main():
    method, path = sys.argv[1:]
    read = METHODS[method](path)
    start = time.perf_counter()
    places, weights = read()
    values = np.linalg.eigh(np.cov(places, rowvar=False, bias=True, aweights=weights)).eigenvalues
    print(json.dumps({"seconds": time.perf_counter() - start, "eigenvalues": values.tolist()}))


if __name__ == "__main__":
    main()
