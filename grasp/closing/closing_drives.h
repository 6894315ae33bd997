/// The joints of a closing hand: which still run, how fast, and until when.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/closing/closing.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
/// One ratio to the usual speed per link: what the options say, else what the hand says, else 1.
/// Throws std::invalid_argument for a joint that the hand does not have or that does not close by
/// itself, and for ratios that are not finite and > 0.
[[nodiscard]] BULLET_CCD_API std::vector<double> closingSpeeds(const HandModel& hand,
                                                               const ClosingOptions& options);

/// Every closing joint runs at constant speed towards its limit, and its mimic joints with it,
/// until it is there or a link that it moves is stopped. Positions follow from the time since it
/// began alone, so they do not depend on the steps in which it is gone through. Joints may have to
/// wait for their turns.
class BULLET_CCD_API ClosingDrives
{
public:
    static constexpr double kRevoluteSpeed = 1.0;   ///< [rad/s]
    static constexpr double kPrismaticSpeed = 0.1;  ///< [m/s]

    /// Closing begins at time 0 with these positions, one entry a link. Mimic joints start where
    /// the joints they follow want them, whatever `positions` says of them.
    /// The joints with the first turn begin at once; see closingTurns(), empty for all.
    /// @param speeds ratios to the speeds above; see closingSpeeds(), empty for those of the hand
    /// Throws std::invalid_argument if `positions` has not one finite entry a link.
    ClosingDrives(const HandModel& hand,
                  const std::vector<double>& positions,
                  std::vector<std::int32_t> turns = {},
                  const std::vector<double>& speeds = {});

    /// When the first of the running drives is at its limit [s]; infinite if none runs.
    [[nodiscard]] double nextLimit() const;
    /// The same for the joints above these links.
    [[nodiscard]] double nextLimit(std::span<const std::int32_t> links) const;
    [[nodiscard]] bool isRunning() const;
    /// The largest ratio of a running drive to its usual speed; 1 if none runs. Steps of time that
    /// are divided by it move joints as far as the same steps do at the usual speeds.
    [[nodiscard]] double pace() const;
    /// If nothing runs, the joints with the next turn begin, now.
    void beginNext();
    /// Of the last advanceTo() [s].
    [[nodiscard]] double time() const { return m_time; }
    /// Of the joint above each link, now [rad/s, m/s].
    [[nodiscard]] const std::vector<double>& speeds() const { return m_speeds; }
    [[nodiscard]] const std::vector<double>& positions() const { return m_positions; }
    /// Where the joints would be at this time >= that of the last advanceTo(), if nothing stopped
    /// before [s].
    void positionsAt(double time, std::vector<double>& positions) const;
    /// Moves on; drives that are at their limits stop there, exactly.
    void advanceTo(double time);
    /// Stops the joints between the link and the root, and what is coupled to them, and notes the
    /// link as stopped at this time if any was running, or waiting for its turn. Returns true if it
    /// was noted now: a link is noted once.
    /// @pre advanceTo(time) has been called
    bool stopLink(std::int32_t link, double time, bool byObject);
    [[nodiscard]] const std::vector<StopEvent>& stops() const { return m_stops; }

private:
    /// The joints that move as one: a closing joint and its mimics. One a link; most are unused.
    struct Drive
    {
        double speed = 0.0;      // of the closing joint, signed
        double ratio = 1.0;      // of it to the usual speed
        double beginTime = 0.0;  // [s]
        double limitTime = 0.0;  // [s]; before it begins: how long it takes
        bool running = false;
        bool waiting = false;
    };

    const HandModel& m_hand;
    std::vector<Drive> m_drives;
    std::vector<double> m_start;   // positions at time 0
    std::vector<double> m_closed;  // at the limits
    std::vector<double> m_speeds;
    std::vector<double> m_positions;
    std::vector<StopEvent> m_stops;
    std::vector<std::int32_t> m_turns;  // one a link, or none
    double m_time = 0.0;

    [[nodiscard]] std::size_t driverOf(std::size_t link) const;
    void stopDrive(std::size_t driver);
};
}  // namespace bullet_ccd::grasp
