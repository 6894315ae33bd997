"""What points of time against error say: which are right, which no other beats, which to take."""
import math

from plot.words import unique

FLAWS = ["missed", "late", "false", "timedOut"]
BEST_ERROR = 1e-12  # the references themselves are known to this


def flaws_of(measured):
    """Keys of the flaws that the family knows, with its words for them."""
    return [(key, measured["flaws"][key]) for key in FLAWS if measured["flaws"][key]]


def scenes_of(measured):
    return unique(p["scene"] for p in measured["points"])


def is_right(point):
    return all(point[key] == 0 for key in FLAWS)


def error_of(point):
    """Median error; None if nothing was found."""
    return max(point["medianError"], BEST_ERROR) if point["found"] > 0 else None


def front(points):
    """Points that no other beats in both time and error, the fastest first."""
    best = []
    for point in sorted((p for p in points if p["found"] > 0),
                        key=lambda p: (p["meanMicroseconds"], p["medianError"])):
        if not best or error_of(point) < error_of(best[-1]):
            best.append(point)
    return best


def thresholds(measured):
    """Powers of ten from the largest error of all points down to the smallest that one keeps; with
    their threefold in between where that is a short way."""
    found = [p for p in measured["points"] if p["found"] > 0]
    errors = [max(p["maxError"], BEST_ERROR) for p in found]
    if not errors:
        return []
    kept = [max(p["maxError"], BEST_ERROR) for p in found if is_right(p)] or errors
    first = min(math.ceil(math.log10(max(errors))), 0)
    last = min(math.ceil(math.log10(min(kept))), first)
    digits = (3.0, 1.0) if first - last < 6 else (1.0,)
    return [digit * 10.0 ** exponent for exponent in range(first, last - 1, -1)
            for digit in digits if exponent < first or digit == 1.0]


def choices(measured, scene=None):
    """For every threshold the fastest setting that keeps it in all queries, nothing missed, late,
    false or too slow, in the scene or in all of them: (threshold, setting as a point or None)."""
    asked = len(scenes_of(measured)) if scene is None else 1
    settings = {}
    for point in measured["points"]:
        if scene in (None, point["scene"]):
            settings.setdefault((point["method"], point["setting"]), []).append(point)
    candidates = [
        {"method": method, "setting": setting, "maxError": max(p["maxError"] for p in points),
         "meanMicroseconds": sum(p["meanMicroseconds"] for p in points) / len(points)}
        for (method, setting), points in settings.items()
        if len(points) == asked and all(map(is_right, points)) and any(p["found"] for p in points)]
    return [(threshold, min((c for c in candidates if c["maxError"] <= threshold),
                            key=lambda c: c["meanMicroseconds"], default=None))
            for threshold in thresholds(measured)]


def strictest(rows):
    """Rows without those that the next, for a smaller error, only repeats."""
    return [row for row, after in zip(rows, rows[1:] + [None])
            if after is None or [best for _, best in row] != [best for _, best in after]]
