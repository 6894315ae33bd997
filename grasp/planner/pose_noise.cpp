#include "grasp/planner/pose_noise.h"

#include "bullet_ccd/math/check.h"
#include "grasp/planner/grasp_planner.h"

#include <algorithm>
#include <random>
#include <set>

namespace bullet_ccd::grasp
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

class NoiseSource
{
public:
    explicit NoiseSource(const PoseNoise& noise) : m_noise(noise), m_engine(noise.seed) {}

    /// An error of a pose, about the point.
    Isometry3d next(const Vector3d& center)
    {
        const Vector3d rotation = m_noise.rotation * vector();
        const Vector3d shift = m_noise.position * vector();
        const double angle = rotation.norm();
        Isometry3d error = Isometry3d::Identity();
        error.translate(center + shift);
        if (angle > 0.0)
        {
            error.rotate(Eigen::AngleAxisd(angle, rotation / angle));
        }
        error.translate(-center);
        return error;
    }

private:
    Vector3d vector()
    {
        const double x = m_normal(m_engine);
        const double y = m_normal(m_engine);
        return {x, y, m_normal(m_engine)};
    }

    const PoseNoise& m_noise;
    std::mt19937_64 m_engine;
    std::normal_distribution<double> m_normal;
};

std::set<std::int32_t> linksOf(const Grasp& grasp)
{
    std::set<std::int32_t> links;
    for (const GraspContact& contact : grasp.contacts)
    {
        links.insert(contact.link);
    }
    return links;
}
}  // namespace

double PoseRobustness::medianEpsilon() const
{
    return epsilons.empty() ? 0.0 : epsilons[epsilons.size() / 2];
}

PoseRobustness poseRobustness(const HandModel& hand,
                              const GraspObject& object,
                              const Grasp& grasp,
                              const PoseNoise& noise,
                              const PlannerOptions& options,
                              const CloseHand& close)
{
    require(noise.position >= 0.0 && noise.rotation >= 0.0 && noise.trials >= 0,
            "poseRobustness: standard deviations and the number of trials must not be negative");
    const Preshape* preshape = findPreshape(hand, grasp.preshape);
    require(preshape != nullptr,
            "poseRobustness: the hand has no preshape of the grasp's name: is it another hand?");
    PlannerOptions scoring = options;
    scoring.volumes = 0;
    NoiseSource source(noise);
    const Vector3d way = grasp.X_WH.translation() - grasp.X_WStart.translation();
    PoseRobustness robustness;
    for (int trial = 0; trial < noise.trials; ++trial)
    {
        const Isometry3d error = source.next(object.centerOfMass);
        const Grasp repeated = closeAtPose(
            hand, object, error * grasp.X_WStart, error.linear() * way, *preshape, scoring, close);
        ++robustness.trials;
        const bool holds = repeated.reject == RejectReason::None;
        robustness.forceClosures += holds ? 1 : 0;
        robustness.sameLinks += linksOf(repeated) == linksOf(grasp) ? 1 : 0;
        robustness.epsilons.push_back(holds ? repeated.quality.epsilon : 0.0);
    }
    std::sort(robustness.epsilons.begin(), robustness.epsilons.end());
    return robustness;
}
}  // namespace bullet_ccd::grasp
