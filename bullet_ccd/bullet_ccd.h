/// Umbrella of the core: meshes, hierarchies, distances, motions, times of impact and contacts.
/// Link bullet_ccd::core. bullet_ccd/io.h reads files of meshes and robots, bullet_ccd/bullet.h is
/// the adapter for Bullet.
///
/// Tolerance, gap, minimum separation and margin have one meaning in all comments;
/// docs/glossary.md defines them.
#pragma once

#include "bullet_ccd/contact/contacts.h"
#include "bullet_ccd/convex/convex_toi.h"
#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "bullet_ccd/toi/least_distance.h"
#include "bullet_ccd/toi/model_use.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "bullet_ccd/trajectory/contact_manager.h"
#include "bullet_ccd/trajectory/trajectory.h"
