// What scenes of pages share: renderer, light, camera and controls. Drawn whenever something has changed.
import {
  DirectionalLight, DoubleSide, HemisphereLight, MeshStandardMaterial, PerspectiveCamera, Scene,
  Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

export const SEE_THROUGH = 0.6;

export const material = (color, opacity = 1) => new MeshStandardMaterial({
  color, roughness: 0.7, metalness: 0, side: DoubleSide, transparent: opacity < 1, opacity,
});

export function setPose(node, pose) {
  node.position.set(pose[0], pose[1], pose[2]);
  node.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
}

export class Stage {
  /// Throws if the browser has no WebGL. Whoever extends it has frame(), which is called until the
  /// user has chosen a view.
  constructor(canvas) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.camera = new PerspectiveCamera(30, 1, 0.001, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.invalidate());
    this.controls.addEventListener('start', () => { this.keepsView = true; });
    this.keepsView = false;
    this.scene = new Scene();
    this.scene.add(new HemisphereLight('#ffffff', '#8a8f98', 2.2), this.camera);
    const lamp = new DirectionalLight('#ffffff', 1.9);
    lamp.position.set(-1, 1.5, 2);
    this.camera.add(lamp, lamp.target);
  }

  /// The points fill the picture, seen from that direction (unit, towards the viewer).
  look(corners, target, towards) {
    this.keepsView = false;
    this.camera.position.copy(target).add(towards);
    this.camera.lookAt(target);
    this.camera.updateMatrixWorld();
    const vertical = Math.tan(this.camera.fov * Math.PI / 360);
    const turned = this.camera.quaternion.clone().invert();
    const distance = Math.max(...corners.map((corner) => {
      const p = corner.sub(target).applyQuaternion(turned);
      return 1.08 * Math.max(Math.abs(p.y), Math.abs(p.x) / this.camera.aspect) / vertical + p.z;
    }));
    this.camera.position.copy(target).addScaledVector(towards, distance);
    this.camera.near = distance / 200;
    this.camera.far = 50 * distance;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(target);
    this.controls.update();
    this.invalidate();
  }

  /// Draws now, and when the canvas changes its size.
  watch(canvas) {
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  resize() {
    const { clientWidth, clientHeight } = this.renderer.domElement.parentElement;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / Math.max(1, clientHeight);
    this.camera.updateProjectionMatrix();
    if (!this.keepsView) this.frame();
    this.invalidate();
  }

  invalidate() {
    this.pending ??= requestAnimationFrame(() => this.render());
  }

  render() {
    cancelAnimationFrame(this.pending);
    this.pending = undefined;
    this.renderer.render(this.scene, this.camera);
  }
}

/// Of the node's own box, in W.
export function cornersOf(mesh) {
  mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
  const { min, max } = mesh.geometry.boundingBox;
  return [...Array(8).keys()].map((k) => new Vector3(
      k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z)
      .applyMatrix4(mesh.matrixWorld));
}
