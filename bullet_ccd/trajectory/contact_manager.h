/// Objects by name, some of which move from one pose to another: what planners that optimise
/// trajectories (TrajOpt, Tesseract) ask of collision detection.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/least_distance.h"

#include <Eigen/Geometry>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd
{
/// Two objects that come within their margin of each other.
struct ManagedContact
{
    std::string nameA;  ///< of an active object
    std::string nameB;
    /// The certified least distance over the motion [m]; 0 if the surfaces touch at some time.
    double distance = 0.0;
    /// In [0, 1]: of the least distance, or of the first contact if the surfaces touch.
    double time = 0.0;
    Eigen::Isometry3d X_WA = Eigen::Isometry3d::Identity();  ///< poses at that time
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();  ///< closest points at that time, in W [m]
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
    /// Unit, from A to B, in W: moving A against it raises the distance. Zero if the surfaces
    /// intersect at the start.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// A copy answers for itself and shares the hierarchies: make one for each thread.
class BULLET_CCD_API ContactManager
{
public:
    /// Adds an object at rest at the identity, or replaces the one of that name.
    /// Throws std::invalid_argument for a null pointer.
    void addObject(const std::string& name, std::shared_ptr<const SsvTree> tree);
    /// False if there is no such object.
    bool removeObject(const std::string& name);
    [[nodiscard]] bool hasObject(const std::string& name) const;

    /// The object rests at a pose.
    /// Throws std::invalid_argument, as all below, for a name that does not exist.
    void setPose(const std::string& name, const Eigen::Isometry3d& X_WO);
    /// The object moves from one pose to another: its origin on a straight line, turning by the
    /// shortest arc.
    void setPoses(const std::string& name,
                  const Eigen::Isometry3d& X_WO0,
                  const Eigen::Isometry3d& X_WO1);
    /// Any other rigid motion, such as a piece of an arc that a joint describes.
    void setMotion(const std::string& name, const RigidMotion& motion);

    /// Pairs are tested if one of the two is active. By default all objects are.
    void setActiveObjects(const std::vector<std::string>& names);

    /// The distance within which contacts are reported [m]; > 0.
    void setMargin(double margin);
    /// The same of one pair, in whatever order: it goes before the one of all, whichever is set
    /// later, and holds for what is added by these names later.
    void setMargin(const std::string& nameA, const std::string& nameB, double margin);

    /// Pairs for which the function is true are not tested.
    using IsAllowed = std::function<bool(const std::string&, const std::string&)>;
    void setAllowed(IsAllowed isAllowed) { m_isAllowed = std::move(isAllowed); }

    /// All pairs that come within their margin, by their names.
    ///
    /// Guarantee: a pair that is not among them keeps its margin, up to the tolerance, at all times
    /// of the motion; distances are never above the truth and at most the tolerance below it.
    /// @param tolerance [m]
    /// Throws std::invalid_argument as leastDistance() does.
    [[nodiscard]] std::vector<ManagedContact> contacts(double tolerance = kDefaultTolerance);

private:
    struct Object
    {
        std::shared_ptr<const SsvTree> tree;
        RigidMotion motion;
        bool isActive = true;
    };
    struct Scratch
    {
        Scratch() = default;
        Scratch(const Scratch& /*other*/) {}
        Scratch& operator=(const Scratch& /*other*/) { return *this; }
        ToiWorkspace work;
    };
    using Pair = std::pair<std::string, std::string>;

    [[nodiscard]] Object& at(const std::string& name);
    [[nodiscard]] double marginOf(const std::string& nameA, const std::string& nameB) const;

    std::map<std::string, Object> m_objects;
    double m_margin = 0.01;
    std::map<Pair, double> m_margins;
    IsAllowed m_isAllowed;
    Scratch m_scratch;
};
}  // namespace bullet_ccd
