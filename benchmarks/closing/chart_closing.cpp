// Points of the chart of closing hands as JSON; benchmarks/run chart runs this program and draws
// them.
#include "benchmarks/closing/closing_chart.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/rigid/rigid_sets.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <iostream>
#include <nlohmann/json.hpp>

namespace
{
using namespace bullet_ccd::benchmarks;

const ChartFamily kFamily{.name = "closing",
                          .title = "Approach and closing of a hand on an object",
                          .time = "time of an approach and closing",
                          .error = "posture error, of the worst joint [rad]",
                          .missed = "passed by",
                          .late = "other posture",
                          .falseHit = "",
                          .timedOut = "gave up",
                          .peers = {}};
}  // namespace

int main(int argc, char** argv)
{
    std::string output;
    std::string data = defaultDataFolder().string();
    std::vector<std::string> names;
    bool quick = false;
    ClosingChartOptions options;
    CLI::App app("Posture error against time of closing hands, ours and stepping");
    app.add_option("-o,--output", output, "JSON file")->required();
    app.add_option("--data", data, "folder with hands/ and objects/");
    app.add_option("--scene", names, "names of scenes, such as allegro_mug");
    app.add_option("-n,--candidates", options.candidates, "a scene")->check(CLI::PositiveNumber);
    app.add_option("--repeats", options.repeats, "of ours")->check(CLI::PositiveNumber);
    app.add_flag("--quick", quick, "4 candidates a scene, three scenes");
    CLI11_PARSE(app, argc, argv);
    options.data = data;
    try
    {
        std::vector<ClosingPair> pairs = closingPairs();
        if (quick)
        {
            options.candidates = 4;
            pairs.resize(3);
        }
        std::erase_if(
            pairs,
            [&](const ClosingPair& pair)
            { return !names.empty() && std::ranges::find(names, pair.name) == names.end(); });
        nlohmann::json points = nlohmann::json::array();
        for (const ClosingPair& pair : pairs)
        {
            for (const auto& point : chartPoints(makeClosingScene(pair, options)))
            {
                points.push_back(point);
            }
        }
        ChartFamily family = kFamily;
        family.peers = {fclVersion()};
        writeChart(output, family, points);
    }
    catch (const std::exception& error)
    {
        std::cerr << "chart_closing: " << error.what() << '\n';
        return 2;
    }
    return 0;
}
