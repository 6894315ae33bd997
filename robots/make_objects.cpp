// make_objects: writes household objects as OBJ files, with a table of what was written.
#include "bullet_ccd/io/mesh_file.h"
#include "robots/shapes/household_objects.h"
#include "robots/shapes/large_objects.h"
#include "tools/support/command_line.h"
#include "tools/support/option_values.h"
#include "tools/support/text_table.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace
{
using namespace bullet_ccd;

struct Options
{
    std::int64_t count = 0;
    std::uint64_t seed = 1;
    std::filesystem::path folder;
    std::vector<std::string> families;
    bool named = false;
    bool large = false;
};

struct Order
{
    std::string name;
    std::string family;  ///< empty: a large object
    std::optional<std::uint64_t> seed;
};

/// Seed of object `index`: SplitMix64, so that neighbouring indices share nothing.
std::uint64_t objectSeed(std::uint64_t seed, std::uint64_t index)
{
    std::uint64_t z = seed + (index + 1) * 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31U);
}

std::vector<Order> ordersFor(const Options& options)
{
    const std::vector<std::string>& families =
        options.families.empty() ? shapes::objectFamilies() : options.families;
    std::vector<Order> orders;
    for (std::size_t i = 0; options.named && i < families.size(); ++i)
    {
        orders.push_back({families[i], families[i], std::nullopt});
    }
    for (std::size_t i = 0; options.large && i < shapes::largeObjectNames().size(); ++i)
    {
        orders.push_back({shapes::largeObjectNames()[i], "", std::nullopt});
    }
    for (std::int64_t i = 0; i < options.count; ++i)
    {
        const auto index = static_cast<std::uint64_t>(i);
        const std::string& family = families[index % families.size()];
        std::ostringstream name;
        name << family << '_' << std::setw(3) << std::setfill('0') << i;
        orders.push_back({name.str(), family, objectSeed(options.seed, index)});
    }
    return orders;
}

/// Makes and writes one object; returns its line of the manifest.
std::string fulfil(const Order& order, const std::filesystem::path& folder)
{
    const TriangleMesh mesh = order.family.empty() ? shapes::makeLargeObject(order.name)
                                                   : shapes::makeObject(order.family, order.seed);
    writeObj(mesh, folder / (order.name + ".obj"));
    const Eigen::Vector3d extent = bounds(mesh).sizes();
    std::ostringstream line;
    line << std::setprecision(6) << order.name << ',' << order.family << ','
         << (order.seed ? std::to_string(*order.seed) : "") << ',' << mesh.triangles.size() << ','
         << massProperties(mesh).volume << ',' << extent.x() << ',' << extent.y() << ','
         << extent.z();
    return line.str();
}

/// All objects, on all cores; which thread makes an object does not change it.
std::vector<std::string> fulfilAll(const std::vector<Order>& orders,
                                   const std::filesystem::path& folder)
{
    std::vector<std::string> lines(orders.size());
    std::atomic<std::size_t> next = 0;
    std::exception_ptr failure;
    std::mutex failureMutex;
    const auto work = [&]
    {
        try
        {
            for (std::size_t i = next++; i < orders.size(); i = next++)
            {
                lines[i] = fulfil(orders[i], folder);
            }
        }
        catch (...)
        {
            const std::lock_guard lock(failureMutex);
            failure = std::current_exception();
            next = orders.size();
        }
    };
    {
        std::vector<std::jthread> threads;
        const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
        for (std::size_t i = 0; i < std::min(cores, orders.size()); ++i)
        {
            threads.emplace_back(work);
        }
    }
    if (failure)
    {
        std::rethrow_exception(failure);
    }
    return lines;
}

/// Makes the folder, and a file in it to see that it can be written: objects take a while to make.
void prepareFolder(const std::filesystem::path& folder)
{
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error || !std::filesystem::is_directory(folder, error))
    {
        throw std::runtime_error(
            folder.string() + ": the folder cannot be made" +
            (error ? " (" + error.message() + ")" : "") +
            ": give -o a folder that you may write to, and no file of that name");
    }
    if (!std::ofstream(folder / "manifest.csv"))
    {
        throw std::runtime_error(folder.string() +
                                 ": the folder cannot be written to: give -o another one, or "
                                 "change its rights");
    }
}

void run(const Options& options)
{
    prepareFolder(options.folder);
    const std::vector<Order> orders = ordersFor(options);
    const std::vector<std::string> lines = fulfilAll(orders, options.folder);
    const std::filesystem::path path = options.folder / "manifest.csv";
    std::ofstream manifest(path);
    manifest << "name,family,seed,triangles,volume_m3,extent_x_m,extent_y_m,extent_z_m\n";
    for (const std::string& line : lines)
    {
        manifest << line << '\n';
    }
    manifest.close();
    if (!manifest)
    {
        throw std::runtime_error(path.string() +
                                 ": cannot be written: check the disk and the "
                                 "rights of the folder");
    }
    std::cout << "wrote " << orders.size() << (orders.size() == 1 ? " object" : " objects")
              << " and manifest.csv to " << options.folder.string() << '\n';
}

void addOptions(CLI::App& app, Options& options)
{
    app.add_option("-n,--count",
                   options.count,
                   "How many objects to make of sizes that are drawn; the families take turns.")
        ->check(tools::within(std::int64_t{1}, std::int64_t{100000}))
        ->type_name("N");
    app.add_flag("--named",
                 options.named,
                 "Make one object of usual size per family: mug.obj, bottle.obj and so on.");
    app.add_flag("--large",
                 options.large,
                 "Make the objects that take two hands: " +
                     tools::joined(shapes::largeObjectNames(), ", ") + ".");
    app.add_option("-s,--seed", options.seed, "What all sizes are drawn from.")
        ->check(tools::wholeNumber())
        ->capture_default_str()
        ->type_name("S");
    app.add_option("-o,--output", options.folder, "The folder to write to. It is made if needed.")
        ->required()
        ->type_name("FOLDER");
    app.add_option("--family",
                   options.families,
                   "Only make these families. The families are " +
                       tools::joined(shapes::objectFamilies(), ", ") + ". Default: all.")
        ->check(tools::oneOf(shapes::objectFamilies()))
        ->type_name("NAME...");
}

constexpr const char* kFooter =
    "The same options write the same bytes. manifest.csv lists what was written.\n"
    "\n"
    "Exit codes: 0 if everything was written, 2 for wrong options, 3 if the folder cannot be "
    "written "
    "to.\n"
    "\n"
    "Examples:\n"
    "  make_objects --named -o objects\n"
    "  make_objects -n 100 --seed 7 -o objects\n"
    "  make_objects -n 20 --family mug jug -o vessels";
}  // namespace

int main(int argc, char** argv)
{
    Options options;
    return tools::runProgram(
        argc,
        argv,
        {.name = "make_objects",
         .about = "Makes household objects as OBJ files: closed triangle meshes in metres, z up, "
                  "standing on z = 0. Give -n, --named or --large.",
         .footer = kFooter},
        [&](CLI::App& app, int&)
        {
            addOptions(app, options);
            app.callback(
                [&]
                {
                    if (options.count == 0 && !options.named && !options.large)
                    {
                        throw CLI::ValidationError(
                            "-n", "nothing to make: give -n N, --named or --large");
                    }
                    run(options);
                });
        });
}
