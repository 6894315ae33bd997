#include "grasp/report/grasp_picture.h"
#include "grasp/report/report_facts.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>
#include <sstream>
#include <string>

namespace bullet_ccd::grasp
{
namespace
{
constexpr const char* kStyle = R"css(
:root { --ink: #24292f; --soft: #5c6773; --line: #d9dfe6; --paper: #f6f8fa; --card: #ffffff;
        --good: #2f7d4f; --bad: #a4553f; --accent: #2f6690; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.5rem 4rem; max-width: 1180px; background: var(--paper);
       color: var(--ink); font: 15px/1.5 system-ui, -apple-system, "Segoe UI", sans-serif; }
h1 { font-size: 1.6rem; font-weight: 650; margin: 0 0 .2rem; }
h2 { font-size: 1.1rem; font-weight: 650; margin: 2.4rem 0 .8rem; }
.sub { color: var(--soft); margin: 0 0 1.4rem; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: .8rem; }
.tile, figure, .card { background: var(--card); border: 1px solid var(--line); border-radius: 10px; }
.tile { padding: .8rem 1rem; }
.tile b { display: block; font-size: 1.5rem; font-weight: 650; line-height: 1.25; }
.tile span { color: var(--soft); font-size: .85rem; }
.tile.good b { color: var(--good); }
.tile.bad b { color: var(--bad); }
figure { margin: 0 0 1.2rem; overflow: hidden; }
figure img { display: block; width: 100%; height: auto; }
figcaption { display: flex; flex-wrap: wrap; gap: .3rem 1.6rem; padding: .7rem 1rem;
             border-top: 1px solid var(--line); font-variant-numeric: tabular-nums; }
figcaption span { color: var(--soft); }
.card { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .42rem .9rem; text-align: right; white-space: nowrap; }
th { font-weight: 600; font-size: .85rem; color: var(--soft); border-bottom: 1px solid var(--line);
     background: var(--card); }
tbody tr + tr td { border-top: 1px solid #eef1f4; }
tbody tr:hover td { background: #f2f6fa; }
.text { text-align: left; }
.narrow { width: auto; }
.facts th { text-align: left; width: 14rem; border: 0; vertical-align: top; }
.facts td { text-align: left; white-space: normal; overflow-wrap: anywhere; }
#grasps th { padding: 0; }
#grasps button { font: inherit; color: inherit; background: none; border: 0; cursor: pointer;
                 padding: .42rem .9rem; width: 100%; text-align: inherit; }
#grasps button:hover, #grasps th[aria-sort] { color: var(--accent); }
#grasps th[aria-sort=ascending] button::after { content: " \2191"; }
#grasps th[aria-sort=descending] button::after { content: " \2193"; }
.yes { color: var(--good); font-weight: 600; }
.no { color: var(--soft); }
)css";

/// Sorts the table by the column whose heading is pressed; numbers by value, a second press
/// reverses.
constexpr const char* kScript = R"js(
document.querySelectorAll('#grasps th button').forEach((button) => button.addEventListener('click', () => {
  const head = button.parentNode;
  const column = head.cellIndex;
  const body = document.querySelector('#grasps tbody');
  const sorted = head.getAttribute('aria-sort');
  const numeric = !head.classList.contains('text');
  const down = sorted ? sorted === 'ascending' : numeric && column > 1;
  document.querySelectorAll('#grasps th').forEach((other) => other.removeAttribute('aria-sort'));
  head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
  const key = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
  const compare = numeric ? (a, b) => key(a) - key(b) : (a, b) => key(a).localeCompare(key(b));
  [...body.rows].sort((a, b) => (down ? -1 : 1) * compare(a, b)).forEach((row) => body.append(row));
}));
)js";

std::size_t linksInContact(const Grasp& grasp)
{
    std::set<std::int32_t> links;
    for (const GraspContact& contact : grasp.contacts)
    {
        links.insert(contact.link);
    }
    return links.size();
}

void writeTile(std::ostream& out,
               const char* kind,
               const std::string& value,
               const std::string& label)
{
    out << "<div class=\"tile " << kind << "\"><b>" << escaped(value) << "</b><span>"
        << escaped(label) << "</span></div>\n";
}

void writeTiles(std::ostream& out, std::span<const Grasp> grasps)
{
    const auto closures =
        std::count_if(grasps.begin(),
                      grasps.end(),
                      [](const Grasp& grasp) { return grasp.quality.forceClosure; });
    double best = 0.0;
    for (const Grasp& grasp : grasps)
    {
        best = std::max(best, grasp.quality.epsilon);
    }
    out << "<div class=\"tiles\">\n";
    writeTile(out, "", std::to_string(grasps.size()), "candidates");
    writeTile(out, "good", std::to_string(closures), "force closures");
    writeTile(out, "good", fixed(best, 4), "best epsilon");
    for (int i = 1; i <= static_cast<int>(RejectReason::IterationLimit); ++i)
    {
        const auto reason = static_cast<RejectReason>(i);
        const auto count =
            std::count_if(grasps.begin(),
                          grasps.end(),
                          [reason](const Grasp& grasp) { return grasp.reject == reason; });
        if (count > 0)
        {
            writeTile(out, "bad", std::to_string(count), toString(reason));
        }
    }
    out << "</div>\n";
}

/// A volume of 0 was not asked for.
std::string volumeText(const Grasp& grasp)
{
    return grasp.quality.volume > 0.0 ? number(grasp.quality.volume, 4) : "–";
}

void writeFigures(std::ostream& out,
                  std::span<const Grasp> grasps,
                  std::span<const std::filesystem::path> pictures,
                  const std::filesystem::path& folder)
{
    if (pictures.empty())
    {
        return;
    }
    out << "<h2>Best grasps</h2>\n";
    for (std::size_t i = 0; i < std::min(pictures.size(), grasps.size()); ++i)
    {
        const Grasp& grasp = grasps[i];
        // The page and its pictures can be moved together.
        const std::filesystem::path relative =
            std::filesystem::absolute(pictures[i]).lexically_proximate(folder);
        out << "<figure><img src=\"" << linkAddress(relative) << "\" alt=\"Grasp of candidate "
            << grasp.candidate << " from two sides\">\n<figcaption><strong>Candidate "
            << grasp.candidate << "</strong> <div><span>epsilon</span> "
            << fixed(grasp.quality.epsilon, 4) << "</div> <div><span>volume</span> "
            << volumeText(grasp) << "</div> <div><span>contacts</span> " << grasp.contacts.size()
            << "</div> <div><span>links in contact</span> " << linksInContact(grasp)
            << "</div> <div><span>preshape</span> " << escaped(grasp.preshape)
            << "</div></figcaption></figure>\n";
    }
}

void writeRow(std::ostream& out, std::size_t rank, const Grasp& grasp)
{
    const bool isGrasp = grasp.reject == RejectReason::None;
    out << "<tr><td>" << rank << "</td><td>" << grasp.candidate << "</td><td class=\"text "
        << (isGrasp ? "yes" : "no") << "\">" << escaped(outcomeOf(grasp))
        << "</td><td data-value=\"" << number(grasp.quality.epsilon, 17) << "\">"
        << fixed(grasp.quality.epsilon, 4) << "</td><td data-value=\""
        << number(grasp.quality.volume, 17) << "\">" << volumeText(grasp) << "</td><td>"
        << grasp.contacts.size() << "</td><td>" << linksInContact(grasp) << "</td><td>"
        << fixed(1000.0 * grasp.approachDistance, 1) << "</td><td class=\"text\">"
        << escaped(grasp.preshape) << "</td></tr>\n";
}

void writeTable(std::ostream& out, std::span<const Grasp> grasps)
{
    out << "<h2>All candidates</h2>\n<div class=\"card\"><table id=\"grasps\"><thead><tr>";
    struct Column
    {
        const char* title;
        bool isText;
    };
    for (const Column& column : {Column{"Rank", false},
                                 Column{"Candidate", false},
                                 Column{"Outcome", true},
                                 Column{"Epsilon", false},
                                 Column{"Volume", false},
                                 Column{"Contacts", false},
                                 Column{"Links", false},
                                 Column{"Approach [mm]", false},
                                 Column{"Preshape", true}})
    {
        out << "<th" << (column.isText ? " class=\"text\"" : "") << "><button type=\"button\">"
            << column.title << "</button></th>";
    }
    out << "</tr></thead>\n<tbody>\n";
    for (std::size_t i = 0; i < grasps.size(); ++i)
    {
        writeRow(out, i + 1, grasps[i]);
    }
    out << "</tbody></table></div>\n";
}

void writeFacts(std::ostream& out,
                const GraspRun& run,
                const HandModel& hand,
                const GraspObject& object,
                std::span<const Grasp> grasps)
{
    out << "<h2>The run</h2>\n<div class=\"card\"><table class=\"facts\"><tbody>\n";
    for (const auto& [name, value] : reportFacts(run, hand, object, grasps))
    {
        out << "<tr><th>" << name << "</th><td>" << escaped(value) << "</td></tr>\n";
    }
    out << "</tbody></table></div>\n";
}
}  // namespace

std::string linkAddress(const std::filesystem::path& file)
{
    std::string result;
    for (const char letter : file.generic_string())
    {
        const auto byte = static_cast<unsigned char>(letter);
        const bool plain = (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                           (letter >= '0' && letter <= '9') ||
                           std::string("-_.~/").find(letter) != std::string::npos;
        std::array<char, 4> code{};
        std::snprintf(code.data(), code.size(), "%%%02X", static_cast<unsigned>(byte));
        result += plain ? std::string(1, letter) : std::string(code.data());
    }
    return result;
}

std::string pageHead(const std::string& title)
{
    return std::string("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n") +
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
           escaped(title) + "</title>\n<style>" + kStyle + "</style></head>\n<body>\n";
}

void writeReport(const GraspRun& run,
                 const HandModel& hand,
                 const GraspObject& object,
                 std::span<const Grasp> grasps,
                 std::span<const std::filesystem::path> pictures,
                 const std::filesystem::path& file)
{
    std::ostringstream page;
    const std::string title = "Grasps of " + object.name + " by " + hand.robot.name;
    page << pageHead(title) << "<h1>" << escaped(title) << "</h1>\n<p class=\"sub\">"
         << grasps.size() << " of " << run.options.candidates << " candidates tried, seed "
         << run.options.seed << ", friction " << number(run.options.friction, 4) << "</p>\n";
    writeTiles(page, grasps);
    writeFigures(page, grasps, pictures, std::filesystem::absolute(file).parent_path());
    writeTable(page, grasps);
    writeFacts(page, run, hand, object, grasps);
    page << "<script>" << kScript << "</script>\n</body></html>\n";

    writePage(page.str(), file);
}
}  // namespace bullet_ccd::grasp
