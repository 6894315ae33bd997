/// Settings of a world or action, and of single objects in it.
#ifndef BT_CCD_SETTINGS_H
#define BT_CCD_SETTINGS_H

#include <limits>
#include <string>

/// What is swept of an object's motion.
enum class btCcdMode
{
    /// Nothing: the object is left to Bullet, including Bullet's own motion clamping.
    Off,
    /// It counts as moving without turning, from where it is when the step begins or an impact
    /// turns it aside. So no motion along a line is missed; what its spin carries through something
    /// is. Cheaper than Full for what spins fast and is nearly round. Links of multibodies are
    /// taken as Full.
    TranslationOnly,
    /// All of it.
    Full,
};

/// Settings of one object.
struct btCcdObjectSettings
{
    btCcdMode m_mode = btCcdMode::Full;
    /// Distance at which its shape, if a stock one, counts as touching [m], > 0. Of the world's and
    /// those of the two objects of a pair, the smallest holds; so an object may only be finer.
    double m_tolerance = std::numeric_limits<double>::infinity();
    /// How many times the limits of btCcdBudget an impact of the object may use, >= 0; of two that
    /// meet, the larger number holds. Above 1 it is answered when others give way already; 0 lets
    /// it give way at once, which is cheap: for debris. (Worlds; an action has no budget.)
    double m_priority = 1.0;

    friend bool operator==(const btCcdObjectSettings&, const btCcdObjectSettings&) = default;
};

/// How much work the impacts of a step may be. A body that has used up its part yields in the
/// order of btCcdYield; nothing goes through it or it through anything, unless it is squeezed.
struct btCcdBudget
{
    int m_impactsPerInstant = 12;  ///< answers to a body while time stands still
    int m_impactsPerBody = 24;     ///< of one body in a step
    int m_impactsPerStep = 20000;  ///< of all bodies; then whatever meets is held at once
    double m_seconds = 0.0;  ///< likewise, by the clock; 0: no limit. Results depend on the machine
};

/// Settings of a world or action.
struct btCcdSettings
{
    /// Distance at which stock shapes count as touching [m], > 0. Choose 1/1000 to 1/100 of the
    /// smallest thing in the world; in single precision at least 1000 times the rounding of the
    /// largest coordinate. Meshes are stopped at their margins instead.
    double m_tolerance = 2e-4;
    /// Meshes may be stopped at any gap from three eighths of their margins up, in place of just
    /// above these, so that few are met twice; and their contacts, which follow what moves, may be
    /// older than a step: they are looked for anew when the two have moved relative to each other
    /// by a thirty-second of their margins.
    bool m_anyWithin = false;
    btCcdBudget m_budget;
    /// Of all objects without settings of their own. With m_mode = Off only those objects are swept
    /// that are switched on one by one.
    btCcdObjectSettings m_objects;
    /// Level of the bounding volumes that debugDrawWorld() draws in wire frame mode; >= 0.
    int m_drawLevel = 0;
    /// Folder in which the hierarchies of meshes and hulls of 1,000 triangles or more are kept, so
    /// that the next run of the program loads them; empty: none. A file belongs to the content of a
    /// mesh and is checked; one that is damaged or old is made anew. It is made if it is not there;
    /// what cannot be written is no error. Stock meshes and height fields of more than 20,000
    /// triangles are not kept, because only pieces of them are converted.
    std::string m_hierarchyFolder{};
};

#endif  // BT_CCD_SETTINGS_H
