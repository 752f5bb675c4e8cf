"""A recording as arrays: where each catom was in each step."""

import h5py
import numpy


class Recorded:
    """times: of the steps; positions[step][catom]: in diameters, catoms in the order of their numbers; values(name): of a
    recorded predicate, [step][catom]."""

    def __init__(self, path):
        with h5py.File(path) as file:
            data = file["VTKHDF"]
            steps = data["Steps"]
            self.times = numpy.asarray(steps["Values"])
            points = numpy.asarray(data["Points"], dtype=float)
            starts = numpy.asarray(steps["PointOffsets"])
            counts = numpy.asarray(data["NumberOfPoints"])
            parts = numpy.asarray(steps["PartOffsets"])
            data_starts = {name: numpy.asarray(offsets) for name, offsets in steps["PointDataOffsets"].items()}
            self.columns = {name: (numpy.asarray(data["PointData"][name]), starts_of) for name, starts_of in data_starts.items()}
            self.positions = [points[start : start + counts[part]] for start, part in zip(starts, parts)]

    def values(self, name):
        rows, starts = self.columns[name]
        return [rows[start : start + len(places)] for start, places in zip(starts, self.positions)]
