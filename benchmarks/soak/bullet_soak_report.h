/// What the soaks of Bullet worlds print at the end.
#pragma once

#include "benchmarks/reference/audit/mesh_audit.h"
#include "bullet_ccd/bullet/btCcdControl.h"

#include <string>

namespace bullet_ccd::tests
{
void printCounters(const btCcdControl& control, double seconds);

/// @param deepest sentence about the deepest penetration; empty if there is none
void printAudit(const AuditResult& seen, const std::string& deepest);
}  // namespace bullet_ccd::tests
