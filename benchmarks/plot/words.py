"""Numbers as text, and small statistics."""
import math


def unique(values):
    return list(dict.fromkeys(values))


def duration(micros):
    """Three digits in the largest unit that leaves something before the point."""
    for unit, size in (("s", 1e6), ("ms", 1e3), ("µs", 1.0)):
        if micros >= size:
            return f"{micros / size:.3g} {unit}"
    return f"{1e3 * micros:.3g} ns"


def power(value, digits=0):
    """Digits behind the point and the power of ten: 3e-3, 1; 3.1e-3."""
    return f"{value:.{digits}e}".replace("e-0", "e-").replace("e+00", "").replace("e+0", "e")


def number(value, digits=2):
    """With so many digits that count: 110, 0.018, 2e-5."""
    if value is None:
        return "–"
    if 0 < abs(value) < 1e-3:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return f"{float(mantissa):g}e{int(exponent)}"
    return f"{float(f'{value:.{digits}g}'):g}".replace("e+0", "e")


def quantile(values, share):
    """The value that this share of all is not above; None for none."""
    if not values:
        return None
    ordered = sorted(values)
    return ordered[math.ceil(share * (len(ordered) - 1) - 1e-9)]


def origin_of(measured):
    """What measured it: command, machine, compiler, flags, peers, commit, date."""
    return ", ".join(filter(None, [
        measured.get("command"), measured.get("machine", {}).get("processor"),
        measured.get("compiler"), measured.get("flags", "").strip(),
        " and ".join(filter(None, measured.get("peers", []))),
        "commit " + measured.get("commit", "unknown"), measured.get("date")]))
