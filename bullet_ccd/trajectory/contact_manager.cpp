#include "bullet_ccd/trajectory/contact_manager.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
void requireMargin(double margin)
{
    require(margin > 0.0 && std::isfinite(margin),
            "contact manager: the margin is " + std::to_string(margin) + " m: it must be above 0");
}

/// Distance that the spheres around two hierarchies keep over the whole motion, at least.
double sphereDistance(const RigidBody& a, const RigidBody& b)
{
    // Centres turn about their references; within their radius of these they are always.
    const auto reachOf = [](const RigidBody& body)
    { return body.tree->radius() + (body.tree->origin() - body.motion.reference_B).norm(); };
    const Eigen::Vector3d between =
        b.motion.X_W0 * b.motion.reference_B - a.motion.X_W0 * a.motion.reference_B;
    const Eigen::Vector3d way = b.motion.v_W - a.motion.v_W;
    const double squared = way.squaredNorm();
    const double nearest = squared > 0.0 ? std::clamp(-between.dot(way) / squared, 0.0, 1.0) : 0.0;
    return (between + nearest * way).norm() - reachOf(a) - reachOf(b);
}

/// The contact of a pair, if it comes within its margin.
bool findContact(const RigidBody& a,
                 const RigidBody& b,
                 double margin,
                 double tolerance,
                 ToiWorkspace& work,
                 ManagedContact& contact)
{
    const LeastDistanceResult least =
        leastDistance(a, b, {.tolerance = tolerance, .enough = margin}, work);
    if (least.pair == kNone)
    {
        return false;
    }
    contact.distance = least.distance;
    contact.time = least.time;
    contact.pointA = least.pointA;
    contact.pointB = least.pointB;
    contact.normal = least.normal;
    if (least.found <= tolerance)
    {
        // They touch, or are about to: the first contact says where, and in which direction.
        const ToiResult toi = rigidToi(a, b, {.tolerance = tolerance}, work);
        if (toi.triangleA != kNone)
        {
            contact.distance = isContact(toi.status) ? 0.0 : contact.distance;
            contact.time = toi.time;
            contact.pointA = toi.pointA;
            contact.pointB = toi.pointB;
            contact.normal = toi.normal;
        }
    }
    contact.X_WA = a.motion.at(contact.time).X_W;
    contact.X_WB = b.motion.at(contact.time).X_W;
    return true;
}
}  // namespace

void ContactManager::addObject(const std::string& name, std::shared_ptr<const SsvTree> tree)
{
    require(tree != nullptr, "contact manager: " + name + ": there is no hierarchy");
    Object& object = m_objects[name];
    object.tree = std::move(tree);
    object.motion = {};
    object.isActive = true;
}

bool ContactManager::removeObject(const std::string& name)
{
    return m_objects.erase(name) > 0;
}

bool ContactManager::hasObject(const std::string& name) const
{
    return m_objects.contains(name);
}

ContactManager::Object& ContactManager::at(const std::string& name)
{
    const auto found = m_objects.find(name);
    require(found != m_objects.end(),
            "contact manager: there is no object " + name + ": add it first");
    return found->second;
}

void ContactManager::setPose(const std::string& name, const Eigen::Isometry3d& X_WO)
{
    at(name).motion = restAt(X_WO);
}

void ContactManager::setPoses(const std::string& name,
                              const Eigen::Isometry3d& X_WO0,
                              const Eigen::Isometry3d& X_WO1)
{
    at(name).motion = motionBetween(X_WO0, X_WO1);
}

void ContactManager::setMotion(const std::string& name, const RigidMotion& motion)
{
    at(name).motion = motion;
}

void ContactManager::setActiveObjects(const std::vector<std::string>& names)
{
    for (const std::string& name : names)
    {
        (void)at(name);
    }
    for (auto& [name, object] : m_objects)
    {
        object.isActive = std::ranges::find(names, name) != names.end();
    }
}

void ContactManager::setMargin(double margin)
{
    requireMargin(margin);
    m_margin = margin;
}

void ContactManager::setMargin(const std::string& nameA, const std::string& nameB, double margin)
{
    requireMargin(margin);
    m_margins[std::minmax(nameA, nameB)] = margin;
}

double ContactManager::marginOf(const std::string& nameA, const std::string& nameB) const
{
    const auto found = m_margins.find(std::minmax(nameA, nameB));
    return found != m_margins.end() ? found->second : m_margin;
}

std::vector<ManagedContact> ContactManager::contacts(double tolerance)
{
    std::vector<ManagedContact> contacts;
    for (auto first = m_objects.begin(); first != m_objects.end(); ++first)
    {
        for (auto second = std::next(first); second != m_objects.end(); ++second)
        {
            auto a = first;
            auto b = second;
            if (!a->second.isActive)
            {
                std::swap(a, b);
            }
            if (!a->second.isActive || (m_isAllowed && m_isAllowed(a->first, b->first)))
            {
                continue;
            }
            const RigidBody bodyA{.tree = a->second.tree.get(), .motion = a->second.motion};
            const RigidBody bodyB{.tree = b->second.tree.get(), .motion = b->second.motion};
            const double margin = marginOf(a->first, b->first);
            ManagedContact contact{.nameA = a->first, .nameB = b->first};
            if (!(sphereDistance(bodyA, bodyB) > margin) &&
                findContact(bodyA, bodyB, margin, tolerance, m_scratch.work, contact))
            {
                contacts.push_back(std::move(contact));
            }
        }
    }
    return contacts;
}
}  // namespace bullet_ccd
