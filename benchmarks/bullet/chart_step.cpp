// Points of the chart of whole Bullet steps as JSON; benchmarks/run chart runs this program and
// draws them.
#include "benchmarks/bullet/step_chart.h"

#include <LinearMath/btScalar.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <iostream>
#include <nlohmann/json.hpp>

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    std::string output;
    std::vector<std::string> names = stepScenes();
    int volleys = 4;
    bool quick = false;
    CLI::App app("Time of a frame against what is seen of contacts, stock Bullet and ours");
    app.add_option("-o,--output", output, "JSON file")->required();
    app.add_option("--scene", names, "names of scenes, such as boxes_sheet");
    app.add_option("-n,--volleys", volleys, "worlds of 25 bodies a scene")
        ->check(CLI::PositiveNumber);
    app.add_flag("--quick", quick, "one world a scene");
    CLI11_PARSE(app, argc, argv);
    try
    {
        nlohmann::json points = nlohmann::json::array();
        for (const std::string& name : names)
        {
            for (const auto& point : chartPoints(makeStepScene(name, quick ? 1 : volleys)))
            {
                points.push_back(point);
            }
        }
        const std::string version = fmt::format("Bullet {}", btGetVersion());
        writeChart(output,
                   {.name = "step",
                    .title = "A frame of 1/60 s of a Bullet world",
                    .time = "time of a frame with 25 bodies",
                    .error = "depth or distance [m]",
                    .missed = "went through",
                    .late = "half in",
                    .falseHit = "kept away",
                    .timedOut = "",
                    .peers = {version}},
                   points);
    }
    catch (const std::exception& error)
    {
        std::cerr << "chart_step: " << error.what() << '\n';
        return 2;
    }
    return 0;
}
