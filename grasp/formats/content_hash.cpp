#include "grasp/formats/content_hash.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>

namespace bullet_ccd::grasp
{
namespace
{
/// FNV-1a over 64-bit words.
class Hash
{
public:
    void add(std::uint64_t word)
    {
        for (int byte = 0; byte < 8; ++byte)
        {
            m_value = (m_value ^ ((word >> (8 * byte)) & 0xff)) * 0x100000001b3U;
        }
    }
    void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
    void add(std::int32_t value)
    {
        add(static_cast<std::uint64_t>(static_cast<std::int64_t>(value)));
    }
    void add(const std::string& text)
    {
        add(static_cast<std::uint64_t>(text.size()));
        for (const char c : text)
        {
            add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
        }
    }
    void add(const Eigen::Isometry3d& X)
    {
        const Eigen::Matrix4d& matrix = X.matrix();
        std::for_each(matrix.data(), matrix.data() + matrix.size(), [&](double v) { add(v); });
    }

    [[nodiscard]] std::uint64_t value() const { return m_value; }

private:
    std::uint64_t m_value = 0xcbf29ce484222325U;
};

std::string hexadecimal(std::uint64_t value)
{
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
    return text.data();
}

void addLink(Hash& hash, const Link& link)
{
    hash.add(link.name);
    hash.add(link.parent);
    hash.add(link.X_PL0);
    hash.add(link.joint.name);
    hash.add(static_cast<std::int32_t>(link.joint.type));
    for (int k = 0; k < 3; ++k)
    {
        hash.add(link.joint.axis[k]);
    }
    hash.add(link.joint.lower);
    hash.add(link.joint.upper);
    hash.add(link.joint.mimicOf);
    hash.add(link.joint.mimicMultiplier);
    hash.add(link.joint.mimicOffset);
}
}  // namespace

std::string contentHash(const HandModel& hand)
{
    Hash hash;
    for (std::size_t link = 0; link < hand.robot.tree.size(); ++link)
    {
        addLink(hash, hand.robot.tree.links[link]);
        if (hand.linkTrees[link] != nullptr)
        {
            hash.add(contentHash(hand.linkTrees[link]->mesh()));
        }
        hash.add(static_cast<std::int32_t>(hand.closingDirections[link]));
    }
    for (const double speed : hand.closingSpeeds)
    {
        hash.add(speed);
    }
    for (const Preshape& preshape : hand.preshapes)
    {
        hash.add(preshape.name);
        std::for_each(preshape.positions.begin(),
                      preshape.positions.end(),
                      [&](double position) { hash.add(position); });
        if (preshape.X_RG)
        {
            hash.add(*preshape.X_RG);
        }
    }
    for (const auto& [first, second] : hand.selfPairs)
    {
        hash.add(first);
        hash.add(second);
    }
    hash.add(hand.X_RG);
    return hexadecimal(hash.value());
}

std::string contentHash(const GraspObject& object)
{
    return hexadecimal(contentHash(object.tree.mesh()));
}

std::string contentHash(std::span<const RigidBody> obstacles)
{
    Hash hash;
    for (const RigidBody& obstacle : obstacles)
    {
        hash.add(contentHash(obstacle.tree->mesh()));
        hash.add(obstacle.motion.X_W0);
    }
    return obstacles.empty() ? std::string() : hexadecimal(hash.value());
}
}  // namespace bullet_ccd::grasp
