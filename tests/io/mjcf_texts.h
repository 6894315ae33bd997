/// MJCF files that use what Menagerie uses, for closed forms and for comparisons with MuJoCo.
#pragma once

#include <string>

namespace bullet_ccd::tests
{
inline std::string mjcf(const std::string& body, const std::string& sections = "")
{
    return "<?xml version=\"1.0\"?>\n<!-- <robot> --><mujoco model=\"m\">" + sections +
           "<worldbody>" + body + "</worldbody></mujoco>";
}

/// A hand with all kinds of joints, orientations, primitives, classes, actuators and couplings.
inline const std::string kMjcfHand = R"(<mujoco model="odd_hand">
<compiler angle="degree" eulerseq="XyZ" autolimits="true"/>
<default>
  <geom density="500"/>
  <position kp="3" forcerange="-4 4"/>
  <default class="hand">
    <joint range="-30 60" damping="0.1"/>
    <default class="pad">
      <geom type="box" size="0.01 0.02 0.005" euler="10 20 30"/>
      <joint axis="0 1 0"/>
    </default>
    <default class="visual"><geom contype="0" conaffinity="0" density="0"/></default>
  </default>
</default>
<worldbody>
  <geom type="plane" size="1 1 0.1"/>
  <light pos="0 0 1"/>
  <body name="palm" pos="0 0 0.3" quat="0.5 0.5 0.5 0.5" childclass="hand">
    <geom name="palm" class="pad" mass="0.3"/>
    <geom class="visual" type="sphere" size="0.5"/>
    <body name="a" pos="0.1 0 0" axisangle="0 1 1 25">
      <joint name="a1" axis="1 0 0" pos="0.01 0.02 0.03" ref="12"/>
      <joint name="a2" class="pad" range="-10 80" pos="-0.02 0 0.01"/>
      <joint name="a3" type="slide" axis="0 3 4" range="-0.01 0.02" ref="0.004"/>
      <geom type="capsule" size="0.01" fromto="0 0 0 0.02 0.03 0.06"/>
      <geom type="cylinder" size="0.01 0.02" pos="0 0.02 0" zaxis="1 2 3"/>
      <body name="a_tip" pos="0 0.05 0.02" xyaxes="0 1 0.2 -1 0.3 0">
        <inertial pos="0.01 0 0.002" euler="5 15 25" mass="0.05" diaginertia="4e-5 3e-5 2e-5"/>
        <joint name="a4" class="pad" type="hinge" limited="false"/>
        <geom class="pad"/>
        <geom type="ellipsoid" size="0.01 0.015 0.02" quat="0 1 0 0.3"/>
      </body>
    </body>
    <body name="b" pos="-0.1 0 0" euler="15 -25 35">
      <joint name="b1" axis="0 0 1" ref="-7"/>
      <geom type="box" size="0.008 0.01 0.02" pos="0 0 0.01"/>
      <geom type="box" size="0.012" fromto="0.03 0.01 0.02 0.01 0.08 0.06"/>
      <body name="b_tip" pos="0 0 0.05">
        <inertial pos="0 0 0.01" mass="0.02" fullinertia="3e-6 4e-6 5e-6 1e-7 2e-7 3e-7"/>
        <joint name="b2" axis="0 1 0" range="0 90"/>
        <geom type="box" size="0.008" fromto="0.01 0.02 0 0.03 0 0.04"/>
        <site name="s"/>
      </body>
    </body>
    <body name="c" pos="0 0.1 0">
      <joint name="c1" axis="1 0 0" ref="5"/>
      <geom type="sphere" size="0.01" contype="2" conaffinity="0"/>
      <body name="d" pos="0 0.05 0">
        <joint name="d1" axis="1 0 0" range="-10 100"/>
        <geom type="sphere" size="0.01"/>
      </body>
    </body>
  </body>
</worldbody>
<tendon>
  <fixed name="cd"><joint joint="c1" coef="0.5"/><joint joint="d1" coef="1"/></fixed>
</tendon>
<equality>
  <joint joint1="b2" joint2="b1" polycoef="0.1 2 0 0 0"/>
</equality>
<actuator>
  <position joint="a1"/>
  <motor joint="a2" gear="3" ctrlrange="-2 1"/>
  <general joint="a3" forcerange="-7 9"/>
  <position tendon="cd" forcerange="-10 10"/>
</actuator>
</mujoco>)";
}  // namespace bullet_ccd::tests
