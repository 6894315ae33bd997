// The same functions for a build without FCL.
#include "benchmarks/peers/fcl_peer.h"

#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
[[noreturn]] void refuse()
{
    throw std::logic_error("FCL is not part of this build: install libfcl-dev and configure again");
}
}  // namespace

struct FclModel::Data
{
};

bool isFclPresent()
{
    return false;
}

std::string fclVersion()
{
    return "";
}

FclModel::FclModel(const TriangleMesh& /*mesh*/)
{
    refuse();
}

FclModel::~FclModel() = default;
FclModel::FclModel(FclModel&&) noexcept = default;
FclModel& FclModel::operator=(FclModel&&) noexcept = default;

FclAnswer fclNaive(const FclBody& /*a*/, const FclBody& /*b*/, int /*samples*/)
{
    refuse();
}

FclAnswer fclAdvancement(const FclBody& /*a*/, const FclBody& /*b*/, double /*timeTolerance*/)
{
    refuse();
}

bool fclOverlap(const FclBody& /*a*/, const FclBody& /*b*/, double /*t*/)
{
    refuse();
}

bool fclOverlap(const FclModel& /*a*/,
                const Eigen::Isometry3d& /*X_WA*/,
                const FclModel& /*b*/,
                const Eigen::Isometry3d& /*X_WB*/)
{
    refuse();
}

std::optional<double> firstOverlap(const FclBody& /*a*/,
                                   const FclBody& /*b*/,
                                   double /*from*/,
                                   double /*end*/)
{
    refuse();
}

double fclDistance(const FclBody& /*a*/, const FclBody& /*b*/, double /*t*/)
{
    refuse();
}

double fclDistance(const FclModel& /*a*/,
                   const Eigen::Isometry3d& /*X_WA*/,
                   const FclModel& /*b*/,
                   const Eigen::Isometry3d& /*X_WB*/)
{
    refuse();
}

std::size_t fclBytes(const FclModel& /*model*/)
{
    refuse();
}
}  // namespace bullet_ccd::benchmarks
