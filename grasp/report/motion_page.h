/// The page of a motion: a scene in three dimensions that moves, and what is said about it.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/report/grasp_model.h"

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// A table with a heading. Cells are plain text; those that begin with a digit or a minus stand at
/// the right.
struct PageTable
{
    std::string title;
    std::vector<std::string> header;  ///< may be empty: rows of name and value
    std::vector<std::vector<std::string>> rows;
};

struct MotionPage
{
    std::string title;
    std::string subtitle{};
    bool isGood = true;  ///< colours the subtitle
    std::vector<PageTable> tables{};
    std::vector<std::string> files{};  ///< to link to, relative to the page
    /// Tracks at these times [s]; a single time for a scene at rest.
    std::vector<float> times{};
    std::vector<MotionTrack> tracks{};
    std::vector<std::pair<std::string, double>> stages{};  ///< names, and when they begin [s]
};

/// One file without a link to anything but `files`: in three dimensions if `viewer`, the template
/// of such pages, is given, else with the picture, which stands in the page's folder, if there is
/// one.
/// Throws std::runtime_error "<file>: <what>: <remedy>".
BULLET_CCD_API void writeMotionPage(const MotionPage& page,
                                    const std::filesystem::path& viewer,
                                    const std::string& picture,
                                    const std::filesystem::path& file);
}  // namespace bullet_ccd::grasp
