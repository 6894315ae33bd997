// Meshes of the page's data as geometries of three.js.
import { BufferAttribute, BufferGeometry } from 'three';

const SMOOTH = Math.cos(35 / 180 * Math.PI);  // edges that are sharper than this stay edges

function bytesOf(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) bytes[i] = letters.charCodeAt(i);
  return bytes.buffer;
}

/// { points, triangles } of a packed mesh: three numbers each [m, indices].
export function unpack(mesh) {
  const steps = new Uint16Array(bytesOf(mesh.points));
  const points = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; ++i) {
    points[i] = mesh.origin[i % 3] + mesh.step[i % 3] * steps[i];
  }
  return { points, triangles: new Uint32Array(bytesOf(mesh.triangles)) };
}

/// Unit normals of the triangles, times twice their areas.
function faceNormals({ points, triangles }) {
  const normals = new Float32Array(triangles.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const u = [0, 1, 2].map((k) => points[b + k] - points[a + k]);
    const v = [0, 1, 2].map((k) => points[c + k] - points[a + k]);
    normals[t] = u[1] * v[2] - u[2] * v[1];
    normals[t + 1] = u[2] * v[0] - u[0] * v[2];
    normals[t + 2] = u[0] * v[1] - u[1] * v[0];
  }
  return normals;
}

/// Triangles around each vertex: those of vertex v stand in `list` from first[v] to first[v + 1].
function facesAround({ points, triangles }) {
  const first = new Uint32Array(points.length / 3 + 1);
  for (const vertex of triangles) ++first[vertex + 1];
  for (let v = 1; v < first.length; ++v) first[v] += first[v - 1];
  const next = first.slice();
  const list = new Uint32Array(triangles.length);
  triangles.forEach((vertex, corner) => { list[next[vertex]++] = Math.floor(corner / 3); });
  return { first, list };
}

/// One vertex a corner; normals are smooth across shallow edges and broken at sharp ones.
export function geometryOf(packed) {
  const mesh = unpack(packed);
  const faces = faceNormals(mesh);
  const lengths = new Float32Array(faces.length / 3);
  lengths.forEach((_, f) => {
    lengths[f] = Math.hypot(faces[3 * f], faces[3 * f + 1], faces[3 * f + 2]) || 1;
  });
  const { first, list } = facesAround(mesh);
  const positions = new Float32Array(3 * mesh.triangles.length);
  const normals = new Float32Array(positions.length);
  mesh.triangles.forEach((vertex, corner) => {
    const own = Math.floor(corner / 3);
    for (let k = 0; k < 3; ++k) positions[3 * corner + k] = mesh.points[3 * vertex + k];
    for (let i = first[vertex]; i < first[vertex + 1]; ++i) {
      const f = list[i];
      const dot = faces[3 * own] * faces[3 * f] + faces[3 * own + 1] * faces[3 * f + 1] +
          faces[3 * own + 2] * faces[3 * f + 2];
      if (f === own || dot > SMOOTH * lengths[own] * lengths[f]) {
        for (let k = 0; k < 3; ++k) normals[3 * corner + k] += faces[3 * f + k];
      }
    }
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new BufferAttribute(normals, 3));
  geometry.normalizeNormals();
  return geometry;
}
