/// The contract that every answer of a time-of-impact query has to meet.
#pragma once

#include "benchmarks/reference/scenes/rigid_scene.h"
#include "bullet_ccd/toi/toi.h"

#include <string>

namespace bullet_ccd::tests
{
/// Expects what ToiStatus and ToiResult promise for `result`, by evaluating distances by brute
/// force at the reported time: gap, witnesses, normal.
void expectHonest(const reference::RigidScene& scene,
                  const ToiResult& result,
                  double tolerance,
                  const std::string& what);
}  // namespace bullet_ccd::tests
