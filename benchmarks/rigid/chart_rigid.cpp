// Points of the rigid chart as JSON; benchmarks/run chart runs this program and draws them.
#include "benchmarks/peers/bullet_peer.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/rigid/rigid_scenes.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <iostream>
#include <nlohmann/json.hpp>

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    std::string output;
    std::string data = defaultDataFolder().string();
    std::vector<std::string> sets = rigidChartSets();
    RigidChartOptions options;
    CLI::App app("Time against error of rigid times of contact, ours and peers");
    app.add_option("-o,--output", output, "JSON file")->required();
    app.add_option("--data", data, "folder with motions/ and rigid_queries/");
    app.add_option("--set", sets, "names of query sets");
    app.add_option("--peer-seconds", options.peerSeconds, "limit of a query of a slow peer")
        ->check(CLI::PositiveNumber);
    app.add_option("--repeats", options.repeats, "of fast methods")->check(CLI::PositiveNumber);
    app.add_flag("--quick", options.quick, "12 queries a set");
    CLI11_PARSE(app, argc, argv);
    try
    {
        if (!isFclPresent())
        {
            fmt::print("FCL is not part of this build (libfcl-dev): its methods are left out\n");
        }
        if (!isBulletPresent())
        {
            fmt::print("Bullet in double precision is not part of this build: no convex casts\n");
        }
        MeshLibrary meshes(data);
        nlohmann::json points = nlohmann::json::array();
        for (const std::string& set : sets)
        {
            const ChartScene scene = makeRigidScene(set, meshes, options);
            for (const auto& point : chartPoints(scene))
            {
                points.push_back(point);
            }
        }
        ChartFamily family = toiFamily("rigid", "Time of contact of two rigid bodies");
        family.peers = {fclVersion(), isBulletPresent() ? "Bullet" : ""};
        writeChart(output, family, points);
    }
    catch (const std::exception& error)
    {
        std::cerr << "chart_rigid: " << error.what() << '\n';
        return 2;
    }
    return 0;
}
