/// Continuous collision detection in one client of PyBullet.
#ifndef PYTHON_PYBULLET_SESSION_H
#define PYTHON_PYBULLET_SESSION_H

#include "bullet_ccd/bullet/btCcdAction.h"

#include "python/pybullet/fit.h"
#include "python/pybullet/host_interface.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

class btCollisionDispatcher;

/// An impact as Python sees it.
struct Impact
{
    double m_time;  ///< since the world was made or the plugin was loaded [s]
    int m_bodyA;    ///< body unique id
    int m_linkA;    ///< link index; -1: the base
    int m_bodyB;
    int m_linkB;
    btVector3 m_pointA;  ///< in the world [m]
    btVector3 m_pointB;
    btVector3 m_normal;  ///< unit, from A to B
};

/// Puts a btCcdAction into the world of a client and takes it out again: when the simulation is
/// reset (and into the next world), when the plugin is unloaded, and when the client disconnects,
/// which destroys the world before the plugin is told.
class Session : private HostGraphics, private btCcdImpactListener
{
public:
    /// Registers with the processor, which tells of the world that is there.
    explicit Session(HostProcessor& processor);
    /// Leaves a world that still exists as it was found.
    ~Session() override;
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    HostProcessor& processor() const { return m_processor; }
    /// Why the world of now is left to stock Bullet; empty if it is not.
    const std::string& problem() const { return m_problem; }

    /// Takes the action out, or puts one in again; kept when the simulation is reset.
    void switchOn(bool on);
    /// To be called before and after every step of the world.
    void beforeStep();
    void afterStep();

    /// Throw std::runtime_error where the world of now is left to stock Bullet.
    btCcdAction& action();
    /// Kept when the simulation is reset.
    void setTolerance(double tolerance);
    /// Throw std::invalid_argument if there is no such body or link with a collision shape.
    void setEnabled(int body, int link, bool enabled);
    /// The body with all its links has been put elsewhere.
    void teleported(int body);

    /// How many impacts are kept until they are taken; later ones are only counted.
    void setImpactCapacity(std::size_t capacity) { m_impactCapacity = capacity; }
    /// The oldest that have not been taken, at most `most`.
    std::vector<Impact> takeImpacts(std::size_t most);
    std::size_t lostImpacts() const { return m_lostImpacts; }

private:
    /// An object that was excluded; another one may be made at its address.
    struct Excluded
    {
        btCollisionObject* m_object;
        int m_proxy;
    };

    HostProcessor& m_processor;
    btDiscreteDynamicsWorld* m_world = nullptr;
    btCollisionDispatcher* m_dispatcher = nullptr;
    std::unique_ptr<btCcdAction> m_action;
    bool m_on = true;
    ObjectFit m_objectFit;
    std::string m_problem;
    std::optional<double> m_tolerance;
    double m_time = 0.0;
    std::vector<Excluded> m_excluded;
    std::vector<Impact> m_impacts;
    std::size_t m_impactCapacity = 10000;
    std::size_t m_lostImpacts = 0;

    void onWorld(btDiscreteDynamicsWorld* world) override;
    void onReset() override;
    btCcdAfterImpact onImpact(const btCcdImpact& impact) override;

    void attach();
    void detach(bool worldIsThere);
    void giveUp(const std::string& problem);
    void forgetPairs();
    std::vector<btCollisionObject*> objectsOf(int body);
};

#endif  // PYTHON_PYBULLET_SESSION_H
