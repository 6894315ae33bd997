/// SRDF as a file says it: names and numbers, checked for form only (see hand_model.h for meaning).
#pragma once

#include "bullet_ccd/export.h"

#include <Eigen/Geometry>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
struct SrdfGroup
{
    std::string name;
    std::vector<std::string> links;  ///< that it lists, the tip of its chain among them
    bool hasChain = false;
    std::string baseLink;  ///< of the chain
    std::string tipLink;
};

/// One group_state; states of the same name but different groups are parts of one preshape.
struct SrdfState
{
    std::string name;
    std::string group;
    std::vector<std::pair<std::string, double>> joints;
};

struct SrdfClosing
{
    std::string joint;
    int direction = 1;   ///< +1 or -1
    double speed = 1.0;  ///< ratio to the usual speed, finite and > 0
};

struct SrdfGraspFrame
{
    std::string preshape;  ///< that it belongs to; empty: to all that have none of their own
    std::string link;
    Eigen::Isometry3d X_LG = Eigen::Isometry3d::Identity();
};

/// A hand of a robot, as MoveIt's users say it.
struct SrdfEndEffector
{
    std::string name;
    std::string parentLink;  ///< that carries it
    std::string group;       ///< its links
};

struct Srdf
{
    std::filesystem::path file;
    std::vector<SrdfGroup> groups;
    std::vector<SrdfState> states;
    std::vector<std::pair<std::string, std::string>> disabledPairs;
    std::vector<std::string> passiveJoints;
    std::vector<SrdfClosing> closings;
    std::vector<SrdfGraspFrame> graspFrames;  ///< at most one a preshape
    std::vector<SrdfEndEffector> endEffectors;
};

/// Reads a file; elements that hands do not need are skipped.
/// Throws std::runtime_error: "<file>: line <n>: <element>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API Srdf readSrdf(const std::filesystem::path& path);
}  // namespace bullet_ccd::grasp
