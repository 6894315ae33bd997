/// Which contacts of a patch a solver needs: the reduction below findPatches().
///
/// Four points span the patch. Where it is not flat, bodies stand on what is lowest, whichever way
/// they lean: the gap over the patch is a height field, and what can touch is its lower hull. So
/// points that lie below the hull of those chosen are added. A lean adds a plane to all heights and
/// leaves the hull as it is; so the choice stays while a body rocks.
#pragma once

#include "bullet_ccd/contact/contacts.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace bullet_ccd
{
/// Most points of a patch.
inline constexpr std::int32_t kPointsPerPatch = 12;

/// Where a contact that was reported before would be now, as a point of either body.
struct FormerContact
{
    Eigen::Vector3d onA = Eigen::Vector3d::Zero();
    Eigen::Vector3d onB = Eigen::Vector3d::Zero();
};

class ContactOutline
{
public:
    /// @param members of the patch among the contacts, the deepest first; not empty
    /// @param normal of the patch, unit
    ContactOutline(const std::vector<Contact>& contacts,
                   const std::vector<std::int32_t>& members,
                   const Eigen::Vector3d& normal,
                   double threshold);

    /// Appends the choice, the deepest first. Former points are preferred.
    /// @param most points, from 4 to kPointsPerPatch; the deepest may be one more than 4
    void appendChoice(const std::vector<FormerContact>& former,
                      std::int32_t most,
                      std::vector<Contact>& chosen);

private:
    static constexpr std::size_t kMaxSpots = 64;

    /// A contact over the patch, which is scaled to unit size.
    struct Spot
    {
        Eigen::Vector2d at = Eigen::Vector2d::Zero();
        double gap = 0.0;  ///< relative to the threshold
        std::int32_t contact = kNone;
        bool isFormer = false;
        bool isChosen = false;
    };

    [[nodiscard]] const Spot& spot(int i) const { return m_spots[static_cast<std::size_t>(i)]; }
    [[nodiscard]] Eigen::Vector2d across(std::int32_t contact) const;
    [[nodiscard]] Eigen::Vector2d farthestFrom(const Eigen::Vector2d& place) const;
    void layAxes(const Eigen::Vector3d& normal);
    void addExtreme(const Eigen::Vector3d& direction);
    void addFormer(const std::vector<FormerContact>& former);
    Spot* add(std::int32_t contact);
    [[nodiscard]] double area(const std::array<int, 4>& four) const;
    [[nodiscard]] std::array<int, 4> base() const;
    template <class Filter>
    [[nodiscard]] std::array<int, 4> largest(int count, Filter filter) const;
    [[nodiscard]] double heightOfHull(const Eigen::Vector2d& at) const;
    void choose(int i);
    void chooseLow(std::int32_t most);

    const std::vector<Contact>& m_contacts;
    const std::vector<std::int32_t>& m_members;
    double m_threshold;
    Eigen::Matrix<double, 3, 2> m_axes;
    Eigen::Vector2d m_origin = Eigen::Vector2d::Zero();
    Eigen::Vector2d m_scale = Eigen::Vector2d::Ones();
    std::array<Spot, kMaxSpots> m_spots{};
    int m_count = 0;
    int m_rim = 0;  ///< spots that hold the outline come first
    int m_deepest = 0;
    std::array<int, kPointsPerPatch> m_chosen{};
    int m_chosenCount = 0;
};
}  // namespace bullet_ccd
