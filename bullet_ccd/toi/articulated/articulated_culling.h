/// Which pairs of links and obstacles can meet in an interval of time: spatial culling.
#pragma once

#include "bullet_ccd/motion/frame_sweep.h"
#include "bullet_ccd/toi/articulated/body_boxes.h"
#include "bullet_ccd/toi/articulated/near_times.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <vector>

namespace bullet_ccd
{
/// Throws std::invalid_argument where sizes do not agree, a pair names no links with geometry, or
/// the motion is not finite.
void checkBody(const ArticulatedBody& body);

/// A link with geometry, and its box over the interval in hand.
struct SweptLink
{
    std::int32_t link = kNone;
    std::int32_t frame = 0;  ///< that it is fixed to
    OrientedBox inFrame{};
    double size = 0.0;          ///< radius of the box at rest [m]
    SweptBox swept{};           ///< widened by the reach of a contact
    std::int64_t interval = 0;  ///< that `swept` belongs to
};

/// A pair that can meet in the interval.
struct Candidate
{
    std::int32_t slotA = kNone;  ///< into links()
    std::int32_t slotB = kNone;  ///< of another link, or kNone
    std::int32_t obstacle = kNone;
    const PairMask* mask = nullptr;
    std::int32_t root = kNone;  ///< the candidate of the whole step that it comes from
    double from = 0.0;          ///< they may meet only between these two times
    double until = 1.0;
};

/// The links of one query and where they are.
class LinkCulling
{
public:
    /// @param reach distance at which links and obstacles count as in contact [m]
    void reset(const ArticulatedBody& body, const Environment& environment, double reach);

    [[nodiscard]] MovingFrames& frames() { return m_frames; }
    [[nodiscard]] const std::vector<SweptLink>& links() const { return m_links; }
    /// How many pairs move relative to each other.
    [[nodiscard]] std::int64_t pairCount() const { return m_pairCount; }

    /// Appends all pairs that move relative to each other.
    void allPairs(std::vector<Candidate>& out);
    /// Appends those of them whose boxes over [0, 1] meet.
    /// @param bySlices  boxes are around slices of the motion, which also say from when to when the
    ///                  pairs may meet; else they are those that pairsOfInterval() goes on from
    void pairsOfStep(bool bySlices, std::vector<Candidate>& out);
    /// Appends those of in[begin, end) whose boxes over the interval meet.
    void pairsOfInterval(std::vector<Candidate>& candidates,
                         std::size_t begin,
                         std::size_t end,
                         double from,
                         double to);
    /// True if halves of the interval are worth their cost for these pairs.
    [[nodiscard]] bool isWide(const std::vector<Candidate>& candidates,
                              std::size_t begin,
                              std::size_t end) const;

private:
    /// A box over some consecutive links.
    struct Node
    {
        Eigen::AlignedBox3d box{};
        std::int32_t right = kNone;  ///< child, the left one follows; kNone for a single link
        std::int32_t slot = kNone;
    };

    void collectSelfPairs();
    void startInterval(double from, double to);
    void startSlices();
    void narrow(std::vector<Candidate>& pairs, std::size_t begin);
    const SweptLink& sweep(std::int32_t slot);
    void buildNodes(std::int32_t begin, std::int32_t end);
    void traverse(std::int32_t linkNode, std::int32_t obstacleNode, std::vector<Candidate>& out);
    void addObstaclePair(std::int32_t slot, std::int32_t obstacle, std::vector<Candidate>& out);
    [[nodiscard]] bool meets(const Candidate& candidate, double from, double to);

    ArticulatedBody m_body;
    const Environment* m_environment = nullptr;
    double m_reach = 0.0;
    MovingFrames m_frames;
    FrameSweep m_sweep;
    NearTimes m_nearTimes;
    std::vector<FrameBall> m_balls;  ///< around the links
    std::int32_t m_base = 0;         ///< frame that the boxes are seen from
    std::vector<SweptLink> m_links;
    std::vector<std::int32_t> m_slotOfLink;
    std::vector<Candidate> m_selfPairs;
    std::vector<Node> m_nodes;
    std::int64_t m_pairCount = 0;
    std::int64_t m_interval = 0;
};
}  // namespace bullet_ccd
