"""What programs that measure and draw share: building, running, saying on what, painting."""
import datetime
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def run(command, **options):
    """Runs a command; its failure ends the program with its name instead of a traceback."""
    try:
        return subprocess.run([str(part) for part in command], check=True, **options)
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"{Path(sys.argv[0]).name}: {Path(str(command[0])).name}: {error}")


def processor():
    """Name of the processor as the kernel tells it."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"


def commit():
    """Short hash of the checkout, marked if there are changes; "unknown" outside of git."""
    try:
        return subprocess.run(
            ["git", "-C", ROOT, "describe", "--always", "--dirty", "--abbrev=10"],
            check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def build(program, folder):
    """The program, built if no folder was named."""
    if folder is not None:
        return folder / "bin" / program
    folder = ROOT / "build" / "release"
    if not (folder / "build.ninja").exists():
        run(["cmake", "--preset", "release"], cwd=ROOT, stdout=subprocess.DEVNULL)
    run(["cmake", "--build", folder, "--target", program], stdout=subprocess.DEVNULL)
    return folder / "bin" / program


def origin(command):
    """Machine, commit, date and command, to be kept with a measurement."""
    return {"machine": {"processor": processor(), "processors": os.cpu_count(),
                        "system": f"{platform.system()} {platform.release()}"},
            "commit": commit(), "date": datetime.date.today().isoformat(), "command": command}


def paint(picture, size):
    """The PNG beside an SVG, by a browser without a window; None where there is no browser."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which(
        "google-chrome")
    if browser is None:
        return None
    painted = picture.with_suffix(".png")
    run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
         "--force-device-scale-factor=1.5", f"--window-size={size[0]},{size[1]}",
         f"--screenshot={painted.resolve()}", picture.resolve().as_uri()],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=120)
    return painted
