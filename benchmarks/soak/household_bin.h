/// Household objects that fall into a bin; the exact check of benchmarks/reference looks at every
/// pose.
#pragma once

#include "benchmarks/reference/audit/world_audit.h"
#include "bullet_ccd/examples/example_support.h"

#include <cstdint>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// A shape, and what is to be known of it.
struct HouseholdObject
{
    std::string name;
    std::shared_ptr<const reference::AuditMesh> audit;
    std::shared_ptr<const SsvTree> tree;
    double mass = 0.0;   ///< [kg]
    double reach = 0.0;  ///< from the centre of mass, the origin [m]
};

/// Number 0 and on: all families in turn, first in their usual sizes, then in sizes by the seed.
[[nodiscard]] HouseholdObject makeHouseholdObject(std::size_t number,
                                                  std::uint64_t seed,
                                                  double density);

struct BinOptions
{
    int objects = 20;
    std::uint64_t seed = 1;                ///< of the places and of the sizes of the objects
    Eigen::Vector2d halfInner{0.25, 0.2};  ///< of the bin; its floor is at z = 0 [m]
};

class HouseholdBin
{
public:
    /// Adds the objects, in a column clear of each other, and a bin whose walls are as high as the
    /// column: all families in turn, at most kSizes sizes of each, 500 to 5000 triangles an object.
    /// Making them takes half a second a kind.
    HouseholdBin(examples::World& world, reference::WorldAudit& audit, const BinOptions& options);

    static constexpr int kSizes = 2;

    /// Of the bodies, in the order of their numbers in the audit.
    [[nodiscard]] const std::vector<std::string>& names() const { return m_names; }
    /// True if every vertex is above the floor and between the walls.
    [[nodiscard]] bool isInside(std::size_t object) const;
    [[nodiscard]] int countInside() const;
    /// Of the centres of mass [m/s].
    [[nodiscard]] double meanSpeed() const;
    [[nodiscard]] std::size_t size() const { return m_objects.size(); }
    [[nodiscard]] const btRigidBody& object(std::size_t i) const { return *m_objects[i].body; }

private:
    struct Object
    {
        btRigidBody* body = nullptr;
        const reference::AuditMesh* mesh = nullptr;
    };

    Eigen::Vector2d m_halfInner;
    double m_top = 0.0;  // of the column of objects at the start
    std::vector<HouseholdObject> m_kinds;
    std::vector<Object> m_objects;
    std::vector<std::string> m_names;

    void addWalls(examples::World& world, reference::WorldAudit& audit);
    void makeKinds(const BinOptions& options);
};
}  // namespace bullet_ccd::benchmarks
