/// What the pages say in words about a run.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/formats/grasp_file.h"

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// Name and value of what was set, and what was noted about hand and object; plain text.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> reportFacts(
    const GraspRun& run,
    const HandModel& hand,
    const GraspObject& object,
    std::span<const Grasp> grasps);

/// How many of the candidates of each value of `key` (&Grasp::source or &Grasp::preshape) are force
/// closures: "sphere 3 of 12, boxes 0 of 4"; empty if none has a value.
[[nodiscard]] BULLET_CCD_API std::string sharesText(std::span<const Grasp> grasps,
                                                    std::string Grasp::*key);

/// Such as "force closure" or "no approach hit".
[[nodiscard]] std::string outcomeOf(const Grasp& grasp);

/// With so many significant digits, or decimals.
[[nodiscard]] std::string number(double value, int digits);
[[nodiscard]] BULLET_CCD_API std::string fixed(double value, int decimals);

/// For HTML.
[[nodiscard]] std::string escaped(const std::string& text);

/// A file as the address of a link: everything that is not plain is written as %XX.
[[nodiscard]] std::string linkAddress(const std::filesystem::path& file);

/// Of a page of pictures: up to the begin of its body, with style.
[[nodiscard]] std::string pageHead(const std::string& title);

/// Writes the page; throws std::runtime_error "<file>: <what>: <remedy>".
void writePage(const std::string& page, const std::filesystem::path& file);
}  // namespace bullet_ccd::grasp
