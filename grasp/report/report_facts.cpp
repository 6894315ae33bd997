#include "grasp/report/report_facts.h"

#include "grasp/quality/object_mass.h"

#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <stdexcept>

namespace bullet_ccd::grasp
{
std::string number(double value, int digits)
{
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    return text.data();
}

std::string fixed(double value, int decimals)
{
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
    return text.data();
}

std::string escaped(const std::string& text)
{
    std::string result;
    for (const char letter : text)
    {
        switch (letter)
        {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '"':
                result += "&quot;";
                break;
            default:
                result += letter;
        }
    }
    return result;
}

std::vector<std::pair<std::string, std::string>> reportFacts(const GraspRun& run,
                                                             const HandModel& hand,
                                                             const GraspObject& object,
                                                             std::span<const Grasp> grasps)
{
    std::vector<std::pair<std::string, std::string>> facts;
    const auto fact = [&facts](const char* name, const std::string& value)
    { facts.emplace_back(name, value); };
    fact("Hand",
         hand.robot.name + ", " + std::to_string(hand.fingers.size()) + " fingers, " +
             std::to_string(hand.robot.tree.size()) + " links: " + run.handFile.string());
    fact("Semantics", run.srdfFile.empty() ? "inferred, no SRDF" : run.srdfFile.string());
    fact("Object",
         object.name + ", " + std::to_string(object.tree.mesh().triangles.size()) + " triangles, " +
             (object.watertight ? "closed" : "not closed") + ", largest radius " +
             fixed(1000.0 * object.radius, 1) + " mm: " + run.objectFile.string() +
             (run.objectScale == 1.0 ? "" : ", scaled by " + number(run.objectScale, 6)));
    const PlannerOptions& options = run.options;
    fact("Seed", std::to_string(options.seed));
    fact("Friction",
         number(options.friction, 4) +
             (options.coneEdges > 0
                  ? ", pyramids with " + std::to_string(options.coneEdges) + " edges"
                  : ", exact cones"));
    fact("Force closure", "epsilon of at least " + number(options.forceClosureThreshold, 4));
    fact("Classes", "epsilon below 0.05 is marginal, below 0.2 fair, from there on firm");
    fact("Weight",
         "held in any direction within the efforts: asked for " +
             massText(massOf(object, options.mass)));
    for (const auto& [name, key] :
         {std::pair("Sources", &Grasp::source), std::pair("Preshapes", &Grasp::preshape)})
    {
        if (const std::string shares = sharesText(grasps, key); !shares.empty())
        {
            fact(name, "force closures: " + shares);
        }
    }
    fact("Links stop at", number(1000.0 * options.closing.tolerance, 4) + " mm from the object");
    fact("Contacts",
         "features within " + number(1000.0 * options.closing.contactThreshold, 4) +
             " mm, one every " + number(1000.0 * options.minContactSpacing, 4) + " mm of a link");
    for (const auto* notes : {&hand.robot.notes, &hand.notes})
    {
        for (const std::string& note : *notes)
        {
            fact("Note", note);
        }
    }
    return facts;
}

std::string sharesText(std::span<const Grasp> grasps, std::string Grasp::*key)
{
    std::map<std::string, std::pair<int, int>> counts;
    for (const Grasp& grasp : grasps)
    {
        if (!(grasp.*key).empty())
        {
            auto& [held, tried] = counts[grasp.*key];
            held += grasp.reject == RejectReason::None ? 1 : 0;
            ++tried;
        }
    }
    std::string text;
    for (const auto& [value, count] : counts)
    {
        text += (text.empty() ? "" : ", ") + value + " " + std::to_string(count.first) + " of " +
                std::to_string(count.second);
    }
    return text;
}

std::string outcomeOf(const Grasp& grasp)
{
    if (grasp.reject != RejectReason::None)
    {
        return toString(grasp.reject);
    }
    return grasp.quality.forceClosure ? "force closure" : "grasp";
}

void writePage(const std::string& page, const std::filesystem::path& file)
{
    std::ofstream out(file, std::ios::binary);
    out << page;
    out.close();
    if (!out)
    {
        throw std::runtime_error(file.string() +
                                 ": cannot write the report: check that the folder exists and is "
                                 "writable");
    }
}
}  // namespace bullet_ccd::grasp
