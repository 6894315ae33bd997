#include "grasp/hand/srdf_to_hand.h"

#include "bullet_ccd/io/nearest_name.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "grasp/hand/hand_inference.h"
#include "grasp/hand/preshape_search.h"
#include "grasp/hand/searched_hand.h"
#include "grasp/hand/self_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// Applies one SRDF to a hand of which only `robot` and the trees are filled in.
class SrdfToHand
{
public:
    /// @param kept what was searched for this hand before
    SrdfToHand(const Srdf& srdf, HandModel& hand, std::optional<SearchedHand> kept)
        : m_srdf(srdf), m_hand(hand), m_kept(std::move(kept))
    {
    }

    /// Gives what had to be searched; nothing if nothing had to be.
    std::optional<SearchedHand> apply()
    {
        readFingers();
        readClosing();
        readPreshapes();
        const std::vector<std::pair<std::int32_t, std::int32_t>> disabled = readDisabled();
        readGraspFrames();
        inferSpeeds();
        setSelfPairs(m_hand, disabled);
        return m_hasSearched && !m_kept ? std::optional(std::move(m_searched)) : std::nullopt;
    }

private:
    [[nodiscard]] const KinematicTree& tree() const { return m_hand.robot.tree; }

    void readFingers()
    {
        for (const SrdfGroup& group : m_srdf.groups)
        {
            if (group.hasChain)
            {
                readChain(group);
            }
        }
        dropInnerChains();
        if (m_hand.fingers.empty())
        {
            m_hand.fingers = inferFingers(m_hand.robot, m_hand.palm);
            std::string names;
            for (const Finger& finger : m_hand.fingers)
            {
                names += (names.empty() ? "" : ", ") + finger.name;
            }
            m_hand.notes.push_back("fingers inferred, by their tips: " + names);
        }
        else
        {
            m_hand.palm = palmAbove(tree(), m_hand.fingers);
        }
        if (m_hand.fingers.empty())
        {
            throw std::runtime_error(m_hand.robot.file.string() +
                                     ": no finger: no link with geometry hangs from a movable "
                                     "joint: add collision geometry");
        }
    }

    void readChain(const SrdfGroup& group)
    {
        const std::string where = "group '" + group.name + "'";
        const std::int32_t base = findLink(where, group.baseLink);
        const std::int32_t tip = findLink(where, group.tipLink);
        if (base == tip || !isAncestorOrSelf(tree(), base, tip))
        {
            fail(where,
                 "tip_link '" + group.tipLink + "' does not hang from base_link '" +
                     group.baseLink + "'",
                 "exchange them or correct the names");
        }
        Finger finger;
        finger.name = group.name;
        bool moves = false;
        for (std::int32_t link = tip; link != base; link = linkAt(link).parent)
        {
            finger.links.insert(finger.links.begin(), link);
            moves = moves || linkAt(link).joint.isMovable();
        }
        if (moves)
        {
            m_hand.fingers.push_back(std::move(finger));
        }
    }

    /// Chains that carry other chains are arms or wrists.
    void dropInnerChains()
    {
        std::vector<Finger> outer;
        for (const Finger& finger : m_hand.fingers)
        {
            const bool carries = std::any_of(
                m_hand.fingers.begin(),
                m_hand.fingers.end(),
                [&](const Finger& other) {
                    return &other != &finger &&
                           isAncestorOrSelf(tree(), finger.links.back(), other.links.back());
                });
            if (carries)
            {
                m_hand.notes.push_back("group '" + finger.name +
                                       "' is no finger: another group hangs from its tip");
                continue;
            }
            outer.push_back(finger);
        }
        m_hand.fingers = std::move(outer);
    }

    void readClosing()
    {
        std::vector<bool> isPassive(tree().size(), false);
        for (const std::string& name : m_srdf.passiveJoints)
        {
            isPassive[findJoint("passive_joint", name)] = true;
        }
        std::vector<int> listed(tree().size(), 0);
        for (const auto& [name, direction, speed] : m_srdf.closings)
        {
            const std::size_t link = findJoint("closing", name);
            const Joint& joint = tree().links[link].joint;
            if (isPassive[link] || !joint.isMovable() || joint.mimicOf != kNone)
            {
                fail("closing",
                     "joint '" + name + "' is " +
                         (isPassive[link]      ? "passive"
                          : !joint.isMovable() ? "fixed"
                                               : "driven by the joint it mimics"),
                     "name a joint that moves by itself, or drop the element");
            }
            listed[link] = direction;
            if (speed != 1.0)
            {
                m_hand.closingSpeeds.resize(tree().size(), 1.0);
                m_hand.closingSpeeds[link] = speed;
            }
        }
        m_hand.closingDirections = inferClosingDirections(m_hand, isPassive);
        std::string inferred;
        for (std::size_t i = 0; i < listed.size(); ++i)
        {
            if (listed[i] != 0)
            {
                m_hand.closingDirections[i] = listed[i];
            }
            else if (m_hand.closingDirections[i] != 0)
            {
                inferred += (inferred.empty() ? "" : ", ") + tree().links[i].joint.name +
                            (m_hand.closingDirections[i] > 0 ? " +" : " -");
            }
        }
        if (!inferred.empty())
        {
            m_hand.notes.push_back("closing directions inferred: " + inferred);
        }
        followMimics();
    }

    void followMimics()
    {
        bool closes = false;
        for (std::size_t i = 0; i < tree().size(); ++i)
        {
            const Joint& joint = tree().links[i].joint;
            if (joint.mimicOf != kNone)
            {
                const int driver =
                    m_hand.closingDirections[static_cast<std::size_t>(joint.mimicOf)];
                const double m = joint.mimicMultiplier;
                m_hand.closingDirections[i] = m > 0.0 ? driver : m < 0.0 ? -driver : 0;
            }
            closes = closes || m_hand.closingDirections[i] != 0;
        }
        if (!closes)
        {
            throw std::runtime_error(m_srdf.file.string() +
                                     ": no joint closes the hand: add <closing joint=\"..\" "
                                     "direction=\"+1\"/> elements to its SRDF");
        }
    }

    void readPreshapes()
    {
        std::map<std::string, bool> isGroup;
        for (const SrdfGroup& group : m_srdf.groups)
        {
            isGroup[group.name] = true;
        }
        for (const SrdfState& state : m_srdf.states)
        {
            const std::string where = "group_state '" + state.name + "'";
            if (!isGroup.contains(state.group))
            {
                std::vector<std::string> names;
                for (const auto& [name, unused] : isGroup)
                {
                    names.push_back(name);
                }
                failName(where, "group", state.group, names);
            }
            setJoints(where, state, preshapeNamed(state.name));
        }
        for (Preshape& preshape : m_hand.preshapes)
        {
            applyMimics(tree(), preshape.positions);
        }
        dropClosedPreshapes();
        std::stable_partition(m_hand.preshapes.begin(),
                              m_hand.preshapes.end(),
                              [](const Preshape& preshape) { return preshape.name == "open"; });
        if (m_hand.preshapes.empty())
        {
            inferPreshapes();
        }
    }

    void inferPreshapes()
    {
        const Preshape open = inferPreshape(m_hand);
        const SrdfGraspFrame* const known = graspFrameOf("");
        const std::optional<Eigen::Isometry3d> frame =
            known == nullptr ? std::nullopt : std::optional(poseOf(*known, open.positions));
        if (!m_kept)
        {
            m_hasSearched = true;
            m_searched.preshapes = searchPreshapes(m_hand, frame).value_or(std::vector<Preshape>());
        }
        m_hand.preshapes = m_kept ? m_kept->preshapes : m_searched.preshapes;
        if (!m_hand.preshapes.empty())
        {
            std::string names;
            for (const Preshape& preshape : m_hand.preshapes)
            {
                names += (names.empty() ? "" : ", ") + preshape.name;
            }
            m_hand.notes.push_back("preshapes inferred by trial grasps: " + names);
            return;
        }
        m_hand.preshapes = inferOpenings(m_hand, open);
        m_hand.notes.push_back(
            std::string(m_hand.preshapes.empty() ? "preshape" : "preshapes open, half and near") +
            " inferred: closing joints opened, all others at 0 or the limit next to it");
        m_hand.preshapes.insert(m_hand.preshapes.begin(), open);
    }

    Preshape& preshapeNamed(const std::string& name)
    {
        for (Preshape& preshape : m_hand.preshapes)
        {
            if (preshape.name == name)
            {
                return preshape;
            }
        }
        Preshape preshape{name, std::vector<double>(tree().size(), 0.0)};
        for (std::size_t i = 0; i < tree().size(); ++i)
        {
            const Joint& joint = tree().links[i].joint;
            preshape.positions[i] = joint.isMovable() ? clampToLimits(joint, 0.0) : 0.0;
        }
        m_hand.preshapes.push_back(std::move(preshape));
        return m_hand.preshapes.back();
    }

    void setJoints(const std::string& where, const SrdfState& state, Preshape& preshape)
    {
        // Setup tools print limits with a few digits.
        constexpr double kLimitTolerance = 1e-3;
        for (const auto& [name, value] : state.joints)
        {
            const std::size_t link = findJoint(where, name);
            const Joint& joint = tree().links[link].joint;
            const double clamped = clampToLimits(joint, value);
            if (!(std::abs(clamped - value) <= kLimitTolerance))
            {
                fail(where,
                     "joint '" + name + "': value " + std::to_string(value) +
                         " is outside its limits [" + std::to_string(joint.lower) + ", " +
                         std::to_string(joint.upper) + "]",
                     "use a value inside");
            }
            preshape.positions[link] = clamped;
        }
    }

    /// A state at the closing limits is no place to start from.
    void dropClosedPreshapes()
    {
        constexpr double kClosed = 0.8;
        const auto isClosed = [&](const Preshape& preshape)
        {
            double sum = 0.0;
            int count = 0;
            for (std::size_t i = 0; i < tree().size(); ++i)
            {
                const Joint& joint = tree().links[i].joint;
                const double range = joint.upper - joint.lower;
                if (m_hand.closingDirections[i] != 0 && std::isfinite(range) && range > 0.0)
                {
                    const double part = (preshape.positions[i] - joint.lower) / range;
                    sum += m_hand.closingDirections[i] > 0 ? part : 1.0 - part;
                    ++count;
                }
            }
            return count > 0 && sum > kClosed * count;
        };
        for (const Preshape& preshape : m_hand.preshapes)
        {
            if (isClosed(preshape))
            {
                m_hand.notes.push_back("group_state '" + preshape.name +
                                       "' is no preshape: the fingers are closed in it");
            }
        }
        std::erase_if(m_hand.preshapes, isClosed);
    }

    std::vector<std::pair<std::int32_t, std::int32_t>> readDisabled()
    {
        std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
        for (const auto& [a, b] : m_srdf.disabledPairs)
        {
            pairs.emplace_back(findLink("disable_collisions", a),
                               findLink("disable_collisions", b));
        }
        return pairs;
    }

    void readGraspFrames()
    {
        for (const SrdfGraspFrame& frame : m_srdf.graspFrames)
        {
            setGraspFrame(frame);
        }
        if (const SrdfGraspFrame* const shared = graspFrameOf(""))
        {
            m_hand.X_RG = poseOf(*shared, m_hand.preshapes.front().positions);
            return;
        }
        std::string inferred;
        for (Preshape& preshape : m_hand.preshapes)
        {
            if (graspFrameOf(preshape.name) == nullptr)
            {
                preshape.X_RG = preshape.X_RG ? preshape.X_RG : searchedFrame(preshape);
                inferred += (inferred.empty() ? "" : ", ") + preshape.name;
            }
        }
        m_hand.X_RG = *m_hand.preshapes.front().X_RG;
        if (!inferred.empty())
        {
            m_hand.notes.push_back("grasp frame inferred, of preshapes: " + inferred);
        }
    }

    Eigen::Isometry3d searchedFrame(const Preshape& preshape)
    {
        if (m_kept && m_keptFrames < m_kept->frames.size())
        {
            return m_kept->frames[m_keptFrames++];
        }
        m_hasSearched = true;
        return m_searched.frames.emplace_back(searchGraspFrame(m_hand, preshape.positions));
    }

    /// Elements that say how joints close say how fast, too: 1 if they do not.
    void inferSpeeds()
    {
        if (!m_srdf.closings.empty())
        {
            return;
        }
        if (!m_kept)
        {
            m_hasSearched = true;
            m_searched.speeds = searchClosingSpeeds(m_hand);
        }
        m_hand.closingSpeeds = m_kept ? m_kept->speeds : m_searched.speeds;
        std::string slower;
        for (std::size_t i = 0; i < m_hand.closingSpeeds.size(); ++i)
        {
            if (m_hand.closingSpeeds[i] != 1.0)
            {
                std::array<char, 32> ratio{};
                std::snprintf(ratio.data(), ratio.size(), " %g", m_hand.closingSpeeds[i]);
                slower += (slower.empty() ? "" : ", ") + tree().links[i].joint.name + ratio.data();
            }
        }
        if (!slower.empty())
        {
            m_hand.notes.push_back("closing speeds inferred by trial grasps: " + slower);
        }
    }

    /// Of a preshape, if it is not that of all.
    void setGraspFrame(const SrdfGraspFrame& frame)
    {
        findLink("grasp_frame", frame.link);
        if (frame.preshape.empty())
        {
            return;
        }
        std::vector<std::string> names;
        for (Preshape& preshape : m_hand.preshapes)
        {
            if (preshape.name == frame.preshape)
            {
                preshape.X_RG = poseOf(frame, preshape.positions);
                return;
            }
            names.push_back(preshape.name);
        }
        // States that are no preshapes were noted.
        if (std::ranges::none_of(m_srdf.states,
                                 [&](const SrdfState& state)
                                 { return state.name == frame.preshape; }))
        {
            failName("grasp_frame", "preshape", frame.preshape, names);
        }
    }

    /// What the SRDF says of this preshape alone; of all without a name.
    [[nodiscard]] const SrdfGraspFrame* graspFrameOf(const std::string& preshape) const
    {
        const auto found =
            std::ranges::find(m_srdf.graspFrames, preshape, &SrdfGraspFrame::preshape);
        return found == m_srdf.graspFrames.end() ? nullptr : &*found;
    }

    Eigen::Isometry3d poseOf(const SrdfGraspFrame& frame, const std::vector<double>& positions)
    {
        const std::int32_t link = findLink("grasp_frame", frame.link);
        return linkPoses(tree(),
                         Eigen::Isometry3d::Identity(),
                         positions)[static_cast<std::size_t>(link)] *
               frame.X_LG;
    }

    [[nodiscard]] const Link& linkAt(std::int32_t link) const
    {
        return tree().links[static_cast<std::size_t>(link)];
    }

    std::int32_t findLink(const std::string& where, const std::string& name)
    {
        const std::int32_t link = tree().findLink(name);
        if (link == kNone)
        {
            std::vector<std::string> names;
            for (const Link& other : tree().links)
            {
                names.push_back(other.name);
            }
            failName(where, "link", name, names);
        }
        return link;
    }

    std::size_t findJoint(const std::string& where, const std::string& name)
    {
        const std::int32_t link = tree().findJoint(name);
        if (link == kNone)
        {
            std::vector<std::string> names;
            for (std::size_t i = 1; i < tree().size(); ++i)
            {
                names.push_back(tree().links[i].joint.name);
            }
            failName(where, "joint", name, names);
        }
        return static_cast<std::size_t>(link);
    }

    [[noreturn]] void failName(const std::string& where,
                               const std::string& kind,
                               const std::string& name,
                               const std::vector<std::string>& names)
    {
        const std::string nearest = nearestName(name, names);
        fail(where,
             kind + " '" + name + "' does not exist",
             nearest.empty() ? "there is none to name, drop the element"
                             : "did you mean '" + nearest + "'?");
    }

    [[noreturn]] void fail(const std::string& where,
                           const std::string& what,
                           const std::string& remedy) const
    {
        throw std::runtime_error(m_srdf.file.string() + ": " + where + ": " + what + ": " + remedy);
    }

    const Srdf& m_srdf;
    HandModel& m_hand;
    std::optional<SearchedHand> m_kept;
    std::size_t m_keptFrames = 0;  // that were used
    SearchedHand m_searched;
    bool m_hasSearched = false;
};
}  // namespace

void applySrdf(const Srdf& srdf, HandModel& hand, const std::filesystem::path& cacheFolder)
{
    if (cacheFolder.empty())
    {
        static_cast<void>(SrdfToHand(srdf, hand, std::nullopt).apply());
        return;
    }
    const std::filesystem::path file = cacheFolder / searchedHandFileName(hand.robot, srdf.file);
    const auto searched =
        SrdfToHand(srdf, hand, loadSearchedHand(file, hand.robot.tree.size())).apply();
    if (searched)
    {
        saveSearchedHand(*searched, file);
    }
}
}  // namespace bullet_ccd::grasp
