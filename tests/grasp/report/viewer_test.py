#!/usr/bin/env python3
"""The page in three dimensions in a browser without a window, made by the program with 1 and with
500 grasps: hand and object are drawn where the camera says, the slider moves the joints to the values
of the record, the table sorts and filters, the command makes the grasp again, and nothing is said on
the console.

    viewer_test.py PROGRAM        the program grasp

The exit code is 77 (skipped) where Chromium or the viewer (it needs npm) is missing.
"""
import json
import math
import os
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

PROGRAM = Path(sys.argv[1]).resolve()
SHARE = PROGRAM.parent.parent / "share" / "bullet_ccd"
BROWSER = (shutil.which("chromium") or shutil.which("chromium-browser") or
           shutil.which("google-chrome"))
HAND = SHARE / "robots" / "three_finger_gripper" / "three_finger_gripper.urdf"
OBJECT = SHARE / "objects" / "mug.obj"
failures = []

# Before the page's own script.
LISTEN = """<script>
const said = [];
addEventListener("error", event => said.push(event.message));
for (const kind of ["error", "warn"]) console[kind] = (...words) => said.push(words.join(" "));
</script>"""

ACTIONS = """<script>
const { scene, data, show, commandOf } = graspPage;
const slider = document.getElementById("time");
const slideTo = value => {
  slider.value = value;
  slider.dispatchEvent(new Event("input"));
};
const press = key => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
const names = ["hand", "object", "contacts", "cones", "boxes"]
    .concat(data.obstacles.length ? ["obstacles"] : []);
/// The box of what is drawn if only this is shown, in pixels from the upper left.
const boxOf = name => {
  names.forEach(other => show(other, other === name));
  scene.render();
  const gl = scene.renderer.getContext();
  const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
  const pixels = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const box = [width, height, 0, 0];
  let count = 0;
  for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) {
    if (pixels[4 * (y * width + x) + 3] < 128) continue;
    const up = height - 1 - y;
    ++count;
    box[0] = Math.min(box[0], x);
    box[1] = Math.min(box[1], up);
    box[2] = Math.max(box[2], x + 1);
    box[3] = Math.max(box[3], up + 1);
  }
  return { box, count, width, height };
};
const postureAt = value => {
  slideTo(value);
  return { joints: [...scene.posture.joints], position: scene.hand.position.toArray(),
           said: document.getElementById("moment").textContent };
};
const rows = () => [...document.querySelectorAll("#grasps tbody tr")]
    .map(row => [...row.cells].map(cell => cell.textContent));
const seen = { said, rows: rows().length };
seen.camera = { position: scene.camera.position.toArray(), target: scene.controls.target.toArray(),
                fov: scene.camera.fov };
seen.boxes = Object.fromEntries(names.map(name => [name, boxOf(name)]));
names.forEach(name => show(name, true));
seen.names = data.joints.map(joint => joint.name);
const end = Number(slider.max);
const closing = end - data.grasps[0].end;
seen.stages = [...document.querySelectorAll("#marks .stage")].map(mark => mark.textContent);
seen.stops = document.querySelectorAll("#marks .stop").length;
seen.at = { start: postureAt(0), before: postureAt(closing), early: postureAt(closing + 0.1),
            late: postureAt(closing + 0.4), end: postureAt(end) };
slideTo(closing);
press("End");
seen.byKey = Number(slider.value) === end;
seen.command = commandOf(data.grasps[0]);
press("ArrowDown");
seen.second = document.getElementById("which").textContent;
const epsilon = [...document.querySelectorAll("#grasps th button")]
    .find(button => button.textContent === "Epsilon");
epsilon.click();
epsilon.click();
seen.rising = rows().map(row => Number(row[3]));
const outcome = document.getElementById("outcome");
outcome.value = "force closure";
outcome.dispatchEvent(new Event("input"));
seen.closures = rows().map(row => row[2]);
seen.loaded = performance.getEntriesByType("resource").length;
document.body.dataset.seen = JSON.stringify(seen);
</script></body>"""


def expect(condition, what):
    if not condition:
        failures.append(what)
        print("FAILED:", what)


def run(*command, **environment):
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False,
                          env={**os.environ, **environment})


def plan(folder, candidates, *more):
    made = run(PROGRAM, "plan", "--hand", HAND, "--object", OBJECT, "-n", candidates, "--seed", 3,
               "--pictures", 0, "--models", 1, "-q", "-o", folder, *more)
    expect(made.returncode == 0, f"a plan with force closures: {made.stderr}")
    lines = (folder / "grasps.jsonl").read_text().splitlines()
    return (folder / "report.html").read_text(), [json.loads(line) for line in lines]


def see(page, folder, actions=ACTIONS):
    file = folder / "seen.html"
    file.write_text(page.replace("<body>", "<body>" + LISTEN, 1).replace("</body>", actions))
    ran = run(BROWSER, "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
              "--enable-unsafe-swiftshader", "--window-size=900,900", "--enable-logging=stderr",
              f"--user-data-dir={folder}/user", "--virtual-time-budget=3000", "--dump-dom",
              file.as_uri())
    # The driver's advice about the speed of reading pixels is about this test.
    loud = [line for line in ran.stderr.splitlines()
            if "CONSOLE" in line and "GL Driver Message" not in line]
    expect(not loud, f"the console is silent: {loud}")
    found = re.search(r'<body[^>]* data-seen="([^"]*)"', ran.stdout)
    expect(found is not None, "the page's scripts ran: " + ran.stdout[-300:])
    return json.loads(found[1].replace("&quot;", '"').replace("&amp;", "&")) if found else None


def points_of_model(file, root):
    """Vertices [m] in W of the nodes below the one that is named so (or begins so), from the glTF
    model that another part of the program has written."""
    content = file.read_bytes()
    size = struct.unpack_from("<I", content, 12)[0]
    gltf, data = json.loads(content[20:20 + size]), content[28 + size:]
    nodes = gltf["nodes"]
    top = next(node for node in nodes if node["name"].startswith(root))
    points = []
    for node in [top] + [nodes[child] for child in top.get("children", [])]:
        if "mesh" not in node:
            continue
        for primitive in gltf["meshes"][node["mesh"]]["primitives"]:
            accessor = gltf["accessors"][primitive["attributes"]["POSITION"]]
            view = gltf["bufferViews"][accessor["bufferView"]]
            begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            points += struct.iter_unpack("<3f", data[begin:begin + 12 * accessor["count"]])
    return points


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    return [x / math.sqrt(dot(a, a)) for x in a]


def box_in_picture(points, camera, width, height):
    """Where a pinhole camera sees them: left, top, right, bottom [pixels]."""
    back = unit(minus(camera["position"], camera["target"]))
    right = unit(cross([0, 0, 1], back))
    up = cross(back, right)
    scale = height / 2 / math.tan(math.radians(camera["fov"]) / 2)
    seen = []
    for point in points:
        p = minus(point, camera["position"])
        depth = -dot(p, back)
        seen.append((width / 2 + scale * dot(p, right) / depth,
                     height / 2 - scale * dot(p, up) / depth))
    return [min(x for x, _ in seen), min(y for _, y in seen),
            max(x for x, _ in seen), max(y for _, y in seen)]


def expect_drawn(seen, model):
    for name, root in (("hand", "hand"), ("object", "object: ")):
        drawn = seen["boxes"][name]
        there = box_in_picture(points_of_model(model, root), seen["camera"], drawn["width"],
                               drawn["height"])
        off = max(abs(a - b) for a, b in zip(drawn["box"], there))
        expect(off < 1.5, f"{name} is drawn at {there}, not at {drawn['box']}")
        inside = 0 < there[0] and 0 < there[1] and there[2] < drawn["width"] and \
            there[3] < drawn["height"]
        expect(inside, f"{name} is in the picture: {there}")
        expect(max(there[2] - there[0], there[3] - there[1]) > 100, f"{name} is large: {there}")
    for name in set(seen["boxes"]) - {"hand", "object"}:
        expect(seen["boxes"][name]["count"] > 20, f"{name} are drawn")


def expect_motion(seen, record):
    final = [record["joints"][name] for name in seen["names"]]
    first = [record["preshape_joints"][name] for name in seen["names"]]
    at = seen["at"]
    expect(sorted(seen["names"]) == sorted(record["joints"]), "all joints are there")
    expect(at["end"]["joints"] == final, f"the slider ends at the record: {at['end']}")
    expect(at["end"]["position"] == record["hand_pose_in_object"]["position_m"], "so does the hand")
    for moment in ("start", "before"):
        expect(at[moment]["joints"] == first, f"the hand is open {moment}: {at[moment]}")
    expect(at["start"]["position"] == record["approach"]["start_pose_in_object"]["position_m"],
           "the slider begins at the start pose")
    expect("0.400 s" in at["late"]["said"], f"the time is said: {at['late']['said']}")
    moved = 0
    for moment, time in (("early", 0.1), ("late", 0.4)):
        for name, value, a, b in zip(seen["names"], at[moment]["joints"], first, final):
            # The proximal joints close by 1 rad/s until they are stopped.
            if "proximal" in name:
                expected = a + math.copysign(min(time, abs(b - a)), b - a)
                expect(abs(value - expected) < 2e-6, f"{name} {moment}: {value} not {expected}")
                moved += abs(b - a) > time
    expect(moved > 0, "some joint is on its way")
    expect(seen["stages"][0] == "approach" and seen["stages"][-1] == "closing", "stages are marked")
    expect(seen["stops"] == len(record["stops"]) > 0, "stops are marked")
    expect(seen["byKey"], "the key End goes to the end")


def expect_again(command, record):
    """What the page tells the user to type."""
    words = shlex.split(command)
    expect(words[0] == "grasp", command)
    made = run(PROGRAM, *words[1:], "--json", "-q")
    expect(made.returncode == 0, f"the command runs: {command}: {made.stderr}")
    again = json.loads(made.stdout)
    off = max(abs(again["joints"][name] - value) for name, value in record["joints"].items())
    expect(off < 1e-9, f"the command makes the grasp again: joints off by {off}")
    expect(abs(again["quality"]["epsilon"] - record["quality"]["epsilon"]) < 1e-6, "and its epsilon")


def expect_table(seen, records):
    expect(seen["rows"] == len(records), f"a row for every grasp: {seen['rows']}")
    expect(seen["rising"] == sorted(seen["rising"]), "pressed twice, epsilon rises")
    closures = sum(record["reject"] is None for record in records)
    expect(seen["closures"] == ["force closure"] * closures, "the filter leaves force closures")
    second = records[min(1, len(records) - 1)]
    expect(seen["second"] == f"Rank {second['rank']}: candidate {second['candidate']}",
           f"the arrow chooses the next: {seen['second']}")


def expect_without_viewer(folder):
    made = run(PROGRAM, "close", "--hand", HAND, "--object", OBJECT, "--pose", 0, 0, 0.3, 0, 1, 0,
               0, "-q", "-o", folder, BULLET_CCD_SHARE=str(folder / "none"))
    expect((folder / "report.html").is_file(), f"a page without the viewer: {made.stderr}")
    expect('id="canvas"' not in (folder / "report.html").read_text(), "it is that of pictures")


TASK = """<script>
const { scene, data, seek } = taskPage;
const object = scene.nodes[data.tracks.findIndex(({ kind }) => kind === "object")];
const placeAt = time => { seek(time); return object.position.toArray(); };
const length = data.times[data.times.length - 1];
const hidden = document.querySelectorAll("#shows button");
hidden.forEach(button => button.click());
scene.render();
document.body.dataset.seen = JSON.stringify({
  said, length, start: placeAt(0), end: placeAt(length),
  between: data.stages.map(({ from }) => placeAt(from)), stages: data.stages.map(({ name }) => name),
  shown: scene.scene.children.filter(({ isGroup, visible }) => isGroup && visible).length,
  groups: hidden.length, loaded: performance.getEntriesByType("resource").length });
</script></body>"""


def expect_task(folder):
    """A plan's page moves the object as its record says."""
    made = run(PROGRAM, "task", "pick-place", "table", "--arm", "seven_joint_arm", "--hand",
               "parallel_gripper", "--object", "apple", "--no-rehearsal", "-n", 10, "-o", folder)
    if "has no tasks" in made.stderr:
        return
    expect(made.returncode == 0, f"a plan of a task: {made.stderr}")
    plan = json.loads((folder / "plan.json").read_text())
    seen = see((folder / "report.html").read_text(), folder, TASK)
    if seen is None:
        return
    expect(seen["said"] == [] and seen["loaded"] == 0, f"no error, nothing loaded: {seen}")
    expect(seen["groups"] == 3 and seen["shown"] == 0, "robot, object and surroundings can be hidden")
    expect(abs(seen["length"] - plan["duration_s"]) < 1e-5, "it lasts as long as the plan")
    legs = [leg["leg"] for leg in plan["legs"]]
    expect(seen["stages"] == legs, f"its stages are the legs: {seen['stages']}")
    for at, pose in (("start", "object_start"), ("end", "object_end")):
        off = math.dist(seen[at], plan[pose]["position_m"])
        expect(off < 2e-5, f"the object is {off} m off at the {at}")
    lifted = seen["between"][legs.index("carry")][2] - seen["start"][2]
    expect(lifted > 0.01, f"the object is lifted by {lifted}")


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        expect_without_viewer(folder / "pictures")
        if not (SHARE / "viewer.html").is_file():
            return "the viewer was not built: it needs npm and its registry (BULLET_CCD_VIEWER)"
        if BROWSER is None:
            return "Chromium is not installed"
        expect_task(folder / "task")
        for candidates in (1, 500):
            out = folder / str(candidates)
            table = folder / "table.obj"
            table.write_text("v -1 -1 -0.3\nv 1 -1 -0.3\nv 0 1 -0.3\nf 1 2 3\n")
            scene = ["--scene", table] if candidates == 1 else []
            page, records = plan(out, candidates, *scene)
            meshes = sum(map(len, re.findall(r'"(?:points|triangles)":"([^"]*)"', page)))
            expect(len(page) - meshes < 3e6, f"{len(page)} bytes beside {meshes} of meshes")
            seen = see(page, out)
            if seen is None:
                continue
            expect(seen["said"] == [], f"no error: {seen['said']}")
            expect(seen["loaded"] == 0, "nothing is loaded")
            expect(("obstacles" in seen["boxes"]) == bool(scene), "obstacles are shown if given")
            expect_drawn(seen, out / "grasp_01.glb")
            expect_motion(seen, records[0])
            expect_again(seen["command"], records[0])
            expect_table(seen, records)
    return None


skipped = main()
if failures:
    sys.exit(1)
if skipped:
    print("skipped:", skipped)
    sys.exit(77)
