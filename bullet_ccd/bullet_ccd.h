/// The core: meshes, hierarchies, distances, motions, times of impact and contacts. Link
/// bullet_ccd::core. Files of meshes and robots are in bullet_ccd/io.h, Bullet in
/// bullet_ccd/bullet.h.
///
/// The words of all comments (tolerance, gap, minimum separation, margin) have one meaning, which
/// docs/glossary.md states.
#pragma once

#include "bullet_ccd/contact/find_contacts.h"
#include "bullet_ccd/contact/rigid_contacts.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/hierarchy/ssv_tree_file.h"
#include "bullet_ccd/mesh/make_mesh.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/joint_motion.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "bullet_ccd/toi/articulated_contacts.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "bullet_ccd/toi/first_contact.h"
#include "bullet_ccd/toi/pair_mask.h"
#include "bullet_ccd/toi/rigid_toi.h"
