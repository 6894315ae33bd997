/// Umbrella of the Bullet adapter: worlds, an action for any world, and a shape for moving meshes.
/// Link bullet_ccd::bullet (Bullet in single precision) or bullet_ccd::bullet_float64 (double).
#pragma once

#include "bullet_ccd/bullet/btCcdAction.h"
#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdControl.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdDeformableBodySolver.h"
#include "bullet_ccd/bullet/btCcdDeformableMultiBodyDynamicsWorld.h"
#include "bullet_ccd/bullet/btCcdDiscreteDynamicsWorld.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/bullet/btCcdMultiBodyDynamicsWorld.h"
