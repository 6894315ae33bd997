// The same functions for a build without Bullet in double precision.
#include "benchmarks/peers/bullet_peer.h"

#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
[[noreturn]] void refuse()
{
    throw std::logic_error(
        "Bullet is not part of this build: configure with "
        "BULLET_CCD_BULLET_PRECISION=both or double");
}
}  // namespace

struct BulletHull::Data
{
};

bool isBulletPresent()
{
    return false;
}

BulletHull::BulletHull(const TriangleMesh& /*mesh*/, double /*margin*/)
{
    refuse();
}

BulletHull::~BulletHull() = default;
BulletHull::BulletHull(BulletHull&&) noexcept = default;
BulletHull& BulletHull::operator=(BulletHull&&) noexcept = default;

BulletAnswer bulletCast(BulletCast /*cast*/,
                        const BulletHull& /*a*/,
                        const RigidMotion& /*motionA*/,
                        const BulletHull& /*b*/,
                        const RigidMotion& /*motionB*/)
{
    refuse();
}
}  // namespace bullet_ccd::benchmarks
