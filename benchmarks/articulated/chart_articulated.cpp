// Points of the articulated chart as JSON; benchmarks/run chart runs this program and draws them.
#include "benchmarks/articulated/human_chart.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/rigid/rigid_sets.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    std::string output;
    std::string data = defaultDataFolder().string();
    std::vector<std::string> motions{"walk", "run", "kick"};
    HumanChartOptions options;
    CLI::App app("Time against error of times of contact of a human among chessmen");
    app.add_option("-o,--output", output, "JSON file")->required();
    app.add_option("--data", data, "folder with motions/ and objects/");
    app.add_option("--motion", motions, "walk, run, kick");
    app.add_option("--repeats", options.repeats, "of fast methods")->check(CLI::PositiveNumber);
    app.add_flag("--quick", options.quick, "12 queries a motion");
    CLI11_PARSE(app, argc, argv);
    options.data = data;
    try
    {
        nlohmann::json points = nlohmann::json::array();
        for (const std::string& motion : motions)
        {
            for (const auto& point : chartPoints(makeHumanChartScene(motion, options)))
            {
                points.push_back(point);
            }
        }
        ChartFamily family = toiFamily("articulated", "Time of contact of a moving human");
        family.peers = {fclVersion()};
        writeChart(output, family, points);
    }
    catch (const std::exception& error)
    {
        std::cerr << "chart_articulated: " << error.what() << '\n';
        return 2;
    }
    return 0;
}
