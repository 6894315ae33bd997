/// CSV files of rigid time-of-impact queries.
///
/// The first line names the columns, in any order, in one of two forms that the names tell apart:
///
/// - poses:  id, then qw qx qy qz tx ty tz with each of the prefixes a0_ a1_ b0_ b1_: body A and B
///           at t = 0 and t = 1; the origins move on straight lines, the bodies turn along the
///           shortest arc at constant rate (motionBetween());
/// - twists: id, then the start poses a0_.. b0_.. and vx vy vz wx wy wz with the prefixes a_ b_:
///           velocity of the body's origin and angular velocity [rad], in world axes, per interval.
///
/// Lengths have the unit of the meshes. Spaces around cells, quotes, empty lines, a byte order mark
/// and line ends of any system are accepted; ids are any text.
#pragma once

#include "bullet_ccd/motion/rigid_motion.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
struct RigidQuery
{
    std::string id;
    RigidMotion motionA;
    RigidMotion motionB;
    std::size_t line = 0;  ///< in the file, from 1
};

/// A row that is no query.
struct BadRow
{
    std::string id;  ///< as far as it could be read
    std::size_t line = 0;
    std::string message;  ///< "<file>:<line>: <column>: <what, value>: <remedy>"
};

enum class QueryForm
{
    Poses,
    Twists,
};

struct QueryFile
{
    QueryForm form = QueryForm::Poses;
    std::vector<RigidQuery> queries;  ///< in the order of the file
    std::vector<BadRow> badRows;      ///< likewise
};

/// Reads all rows. Quaternions are normalised if their length is 1 within kQuaternionSlack; a row
/// that has another one, a cell that is missing or empty, or anything but finite numbers becomes a
/// bad row.
/// Throws std::runtime_error "<path>: <what>: <remedy>" if the file cannot be read or its first
/// line does not name the columns of one form, each once.
[[nodiscard]] QueryFile readQueryFile(const std::filesystem::path& path);
}  // namespace bullet_ccd::tools
