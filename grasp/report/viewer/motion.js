// Where a grasp is at a time: approach, backing off, closing. Nothing here draws.
import { Quaternion, Vector3 } from 'three';

const APPROACH = 1.0;  // seconds on the slider; the record has a distance, not a time
const BACK_OFF = 0.25;

const place = (pose) => new Vector3(pose[0], pose[1], pose[2]);
const turn = (pose) => new Quaternion(pose[4], pose[5], pose[6], pose[3]);

/// The stages of a grasp, one after the other: { name, from, to } [s on the slider].
export function stagesOf(grasp) {
  const stages = [];
  let time = 0;
  const add = (name, length) => {
    if (length > 0) stages.push({ name, from: time, to: time += length });
  };
  add('approach', grasp.travel > 0 ? APPROACH : 0);
  if (grasp.hand) {
    const gap = place(grasp.hand).distanceTo(contactPlace(grasp)) +
        turn(grasp.hand).angleTo(turn(grasp.start));
    add('back off', gap > 1e-6 ? BACK_OFF : 0);
    add('closing', grasp.end);
  }
  return stages;
}

/// Of the root link where the approach ends.
function contactPlace(grasp) {
  return place(grasp.start).addScaledVector(new Vector3(...grasp.direction), grasp.travel);
}

/// How far through the stage of that name the slider is, in [0, 1]; 0 if there is none.
function share(stages, name, time) {
  const stage = stages.find((candidate) => candidate.name === name);
  return stage ? Math.min(1, Math.max(0, (time - stage.from) / (stage.to - stage.from))) : 0;
}

export const lengthOf = (stages) => (stages.length ? stages[stages.length - 1].to : 0);

/// Where the rising line through the points [shown, time] is at x of that axis: the other one there.
function along(points, x, axis) {
  const found = points.findIndex((point) => point[axis] >= x);
  const next = found < 0 ? points.length - 1 : Math.max(1, found);
  const [a, b] = [points[next - 1], points[next]];
  const length = b[axis] - a[axis];
  const part = length > 0 ? Math.min(1, (x - a[axis]) / length) : 1;
  return a[1 - axis] + part * (b[1 - axis] - a[1 - axis]);
}

/// Seconds since closing began; before that null. The slider passes over slow joints quickly.
export function closingTime(grasp, stages, time) {
  const stage = stages.find((candidate) => candidate.name === 'closing');
  return stage && time >= stage.from ? along(grasp.pace, time - stage.from, 0) : null;
}

/// Seconds on the slider from where closing begins to that time of closing.
export const shownTime = (grasp, time) => along(grasp.pace, time, 1);

/// { position, quaternion } of the root link, { joints } in the order of data.joints.
export function postureAt(data, grasp, time) {
  const stages = stagesOf(grasp);
  const position = place(grasp.start).lerp(contactPlace(grasp), share(stages, 'approach', time));
  const quaternion = turn(grasp.start);
  if (grasp.hand) {
    const hasBackOff = stages.some((stage) => stage.name === 'back off');
    const settled = hasBackOff ? share(stages, 'back off', time)
        : Number(closingTime(grasp, stages, time) !== null || time >= lengthOf(stages));
    position.lerp(place(grasp.hand), settled);
    quaternion.slerp(turn(grasp.hand), settled);
    if (settled === 1) {  // to the last digit
      position.copy(place(grasp.hand));
      quaternion.copy(turn(grasp.hand));
    }
  }
  return { position, quaternion, joints: jointsAt(data, grasp, stages, time) };
}

function jointsAt(data, grasp, stages, time) {
  const open = data.preshapes[grasp.preshape]?.joints ?? grasp.joints ?? data.joints.map(() => 0);
  if (!grasp.hand) return [...open];
  const now = time >= lengthOf(stages) ? Infinity : closingTime(grasp, stages, time) ?? 0;
  return open.map((from, joint) => {
    const [begin, end] = grasp.spans[joint];
    if (now >= end) return grasp.joints[joint];
    return from + (grasp.joints[joint] - from) * Math.max(0, (now - begin) / (end - begin));
  });
}
