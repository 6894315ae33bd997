// Hand, object and what belongs to them.
import {
  Box3, BoxGeometry, ConeGeometry, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Mesh,
  Quaternion, SphereGeometry, Vector3,
} from 'three';
import { geometryOf } from './geometry.js';
import { closingTime, lengthOf, postureAt, stagesOf } from './motion.js';
import { SEE_THROUGH, Stage, cornersOf, material, setPose } from './stage.js';

const CONTACT = '#db123d';
const OBSTACLE = '#8c939c';
// Shares of the object's radius.
const BALL = 0.03;
const CONE = 0.34;

export class GraspScene extends Stage {
  /// Throws if the browser has no WebGL.
  constructor(canvas, data) {
    super(canvas);
    this.data = data;
    this.geometries = data.meshes.map(geometryOf);
    this.buildScene();
    this.watch(canvas);
  }

  buildScene() {
    const { data } = this;
    this.object = new Mesh(this.geometries[data.object.mesh],
                           material(data.object.color, SEE_THROUGH));
    this.object.renderOrder = 2;  // what is behind it or in it is there already
    this.obstacles = new Group();
    for (const { mesh, pose } of data.obstacles) {
      const obstacle = new Mesh(this.geometries[mesh], material(OBSTACLE));
      setPose(obstacle, pose);
      this.obstacles.add(obstacle);
    }
    this.contacts = new Group();
    this.cones = new Group();
    this.ball = new SphereGeometry(BALL * data.object.radius, 20, 14);
    this.cone = this.coneGeometry();
    this.buildHand();
    this.scene.add(this.object, this.obstacles, this.contacts, this.cones, this.hand, this.boxes);
    this.boxes.visible = false;
  }

  /// One node a link, each in its parent's.
  buildHand() {
    this.links = [];
    this.hand = new Group();
    this.boxes = new Group();  // like the hand's root, but hidden apart from it
    for (const { name, parent, pose, mesh, color } of this.data.links) {
      const node = new Group();
      node.name = name;
      setPose(node, pose);
      if (mesh !== null) node.add(new Mesh(this.geometries[mesh], material(color)));
      (parent < 0 ? this.hand : this.links[parent]).add(node);
      this.links.push(node);
    }
  }

  /// Apex at the origin, open towards +z.
  coneGeometry() {
    const height = CONE * this.data.object.radius;
    return new ConeGeometry(this.data.friction * height, height, 40, 1)
        .translate(0, -height / 2, 0).rotateX(-Math.PI / 2);
  }

  /// Another grasp, from a side from which it is seen well unless the user has chosen one.
  select(grasp) {
    this.grasp = grasp;
    this.stages = stagesOf(grasp);
    this.buildContacts();
    this.buildBoxes();
    this.seek(lengthOf(this.stages));
    if (!this.keepsView) this.frame();
  }

  buildContacts() {
    this.contacts.clear();
    this.cones.clear();
    for (const { point, normal } of this.grasp.contacts ?? []) {
      const ball = new Mesh(this.ball, material(CONTACT));
      ball.position.set(...point);
      const cone = new Mesh(this.cone, material(CONTACT, 0.45));
      cone.material.depthWrite = false;
      cone.renderOrder = 1;
      cone.position.set(...point);
      cone.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...normal).normalize());
      this.contacts.add(ball);
      this.cones.add(cone);
    }
  }

  buildBoxes() {
    for (const box of this.boxes.children) box.geometry.dispose();
    this.boxes.clear();
    for (const { link, min, max } of this.data.preshapes[this.grasp.preshape]?.boxes ?? []) {
      const size = new Vector3(...max).sub(new Vector3(...min));
      const edges = new EdgesGeometry(new BoxGeometry(size.x, size.y, size.z));
      const lines = new LineSegments(
          edges, new LineBasicMaterial({ color: this.data.links[link].color }));
      lines.position.set(...max).add(new Vector3(...min)).multiplyScalar(0.5);
      this.boxes.add(lines);
    }
  }

  /// Hand and contacts as they are at this time of the slider.
  seek(time) {
    this.posture = postureAt(this.data, this.grasp, time);
    this.hand.position.copy(this.posture.position);
    this.hand.quaternion.copy(this.posture.quaternion);
    this.placeBoxes();
    this.data.joints.forEach(({ link, axis, prismatic }, joint) => {
      const along = new Vector3(...axis);
      const value = this.posture.joints[joint];
      const node = this.links[link];
      setPose(node, this.data.links[link].pose);
      if (prismatic) {
        node.position.add(along.multiplyScalar(value).applyQuaternion(node.quaternion));
      } else {
        node.quaternion.multiply(new Quaternion().setFromAxisAngle(along, value));
      }
    });
    this.showContacts(time);
    this.invalidate();
  }

  /// The boxes hold where the hand closes.
  placeBoxes() {
    if (this.grasp.hand) setPose(this.boxes, this.grasp.hand);
    else setPose(this.boxes, this.grasp.start);
  }

  /// A contact is there from when its link is stopped; at the end all are.
  showContacts(time) {
    const now = time >= lengthOf(this.stages) ? Infinity : closingTime(this.grasp, this.stages, time) ?? -1;
    (this.grasp.contacts ?? []).forEach(({ link }, contact) => {
      const stop = this.grasp.stops.find((candidate) => candidate.link === link);
      const isThere = now >= (stop ? stop.time : Infinity);
      this.contacts.children[contact].visible = isThere;
      this.cones.children[contact].visible = isThere;
    });
  }

  setSeeThrough(on) {
    this.object.material.transparent = on;
    this.object.material.opacity = on ? SEE_THROUGH : 1;
    this.object.material.needsUpdate = true;
    this.invalidate();
  }

  /// Object, palm and fingers fill the picture, whatever is shown now.
  frame() {
    if (!this.grasp) return;
    this.scene.updateMatrixWorld(true);
    const corners = cornersOf(this.object);
    const box = new Box3().setFromObject(this.object);
    this.data.links.forEach(({ mesh, framed }, link) => {
      if (mesh === null || !framed) return;
      corners.push(...cornersOf(this.links[link].children[0]));
      box.expandByObject(this.links[link].children[0]);
    });
    const target = box.getCenter(new Vector3());
    this.look(corners, target, this.bestDirection());
  }

  /// Unit, towards the viewer: the approach from the side, and contacts that no link hides. A link
  /// stands in front of its contact when the contact's normal points away from the viewer.
  bestDirection() {
    const approach = new Vector3(...this.grasp.direction);
    const contacts = this.grasp.contacts ?? [];
    const score = (direction) => {
      const seen = contacts.reduce((sum, { normal }) => {
        const dot = new Vector3(...normal).dot(direction);
        return sum + (dot < -0.3 ? 0 : 1 - 0.5 * dot * dot);
      }, 0);
      return 1 - Math.abs(approach.dot(direction)) + seen / Math.max(1, contacts.length);
    };
    const directions = [0.2, 0.5, 0.9].flatMap((up) => [...Array(12).keys()].map((k) => {
      const around = (k + 0.25) * Math.PI / 6;
      return new Vector3(Math.cos(around), Math.sin(around), up).normalize();
    }));
    return directions.reduce((best, next) => (score(next) > score(best) ? next : best));
  }
}
