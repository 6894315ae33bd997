#include "grasp/report/motion_page.h"

#include "grasp/report/page_data.h"
#include "grasp/report/report_facts.h"

#include <cctype>
#include <sstream>

namespace bullet_ccd::grasp
{
namespace
{
/// Poses of a page, to a hundredth of a millimetre and a thousandth of a degree.
PageJson shortPose(const Eigen::Isometry3d& X)
{
    PageJson list = poseList(X);
    for (auto& value : list)
    {
        value = std::round(value.get<double>() * 1e5) / 1e5;
    }
    return list;
}

PageJson dataOf(const MotionPage& page)
{
    MeshList meshes;
    PageJson json{{"times", page.times}, {"tracks", PageJson::array()}};
    for (const MotionTrack& track : page.tracks)
    {
        PageJson poses = PageJson::array();
        for (const Eigen::Isometry3d& X : track.poses)
        {
            poses.push_back(shortPose(X));
        }
        json["tracks"].push_back({{"name", track.name},
                                  {"kind", track.kind},
                                  {"mesh", meshes.add(track.tree->mesh())},
                                  {"color", hexColor(track.color)},
                                  {"poses", poses}});
    }
    json["stages"] = PageJson::array();
    for (const auto& [name, from] : page.stages)
    {
        json["stages"].push_back({{"name", name}, {"from", from}});
    }
    json["meshes"] = meshes.json();
    return json;
}

std::string cell(const std::string& tag, const std::string& text, bool isRight)
{
    return "<" + tag + (isRight ? ">" : " class=\"text\">") + escaped(text) + "</" + tag + ">";
}

bool isNumber(const std::string& text)
{
    return !text.empty() &&
           (std::isdigit(static_cast<unsigned char>(text[0])) != 0 || text[0] == '-');
}

std::string bodyOf(const MotionPage& page)
{
    std::ostringstream out;
    for (const PageTable& table : page.tables)
    {
        if (table.rows.empty())
        {
            continue;
        }
        out << "<section><h2>" << escaped(table.title) << "</h2>\n<div class=\"card\"><table"
            << " class=\"" << (table.header.empty() ? "facts" : "narrow") << "\">";
        if (!table.header.empty())
        {
            out << "<thead><tr>";
            for (std::size_t k = 0; k < table.header.size(); ++k)
            {
                out << cell("th", table.header[k], isNumber(table.rows.front()[k]));
            }
            out << "</tr></thead>";
        }
        out << "<tbody>\n";
        for (const std::vector<std::string>& row : table.rows)
        {
            out << "<tr>";
            for (std::size_t k = 0; k < row.size(); ++k)
            {
                const bool isName = table.header.empty() && k == 0;
                out << cell(
                    isName ? "th" : "td", row[k], !table.header.empty() && isNumber(row[k]));
            }
            out << "</tr>\n";
        }
        out << "</tbody></table></div></section>\n";
    }
    if (!page.files.empty())
    {
        out << "<p>Files: ";
        for (std::size_t k = 0; k < page.files.size(); ++k)
        {
            out << (k > 0 ? ", " : "") << "<a href=\"" << linkAddress(page.files[k]) << "\">"
                << escaped(page.files[k]) << "</a>";
        }
        out << "</p>\n";
    }
    return out.str();
}
}  // namespace

void writeMotionPage(const MotionPage& page,
                     const std::filesystem::path& viewer,
                     const std::string& picture,
                     const std::filesystem::path& file)
{
    const std::string title = escaped(page.title);
    const std::string subtitle = std::string("<p class=\"sub ") + (page.isGood ? "yes" : "no") +
                                 "\">" + escaped(page.subtitle) + "</p>\n";
    if (!viewer.empty())
    {
        writePage(filledTemplate(viewer,
                                 {{"@TITLE@", title},
                                  {"@HEAD@", "<h1>" + title + "</h1>\n" + subtitle},
                                  {"@BODY@", bodyOf(page)},
                                  {"@DATA@", scriptText(dataOf(page))}}),
                  file);
        return;
    }
    std::ostringstream out;
    out << pageHead(page.title) << "<h1>" << title << "</h1>\n" << subtitle;
    if (!picture.empty())
    {
        out << "<figure><img src=\"" << linkAddress(picture) << "\" alt=\"" << title
            << "\"></figure>\n";
    }
    out << bodyOf(page) << "</body></html>\n";
    writePage(out.str(), file);
}
}  // namespace bullet_ccd::grasp
