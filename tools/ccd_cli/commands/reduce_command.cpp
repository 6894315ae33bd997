#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/reduce/reduce_mesh.h"
#include "tools/ccd_cli/commands/commands.h"
#include "tools/support/command_line.h"
#include "tools/support/option_values.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_file.h"

#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
struct ReduceArguments
{
    std::string mesh;
    std::string output;
    std::string kind;
    ReduceOptions options;
    double timeLimit = 0.0;
    bool json = false;
};

constexpr const char* kAnyKind = "cheapest";

std::string array(const Eigen::Vector3d& v)
{
    return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

/// Size and place of a sphere, capsule or box.
std::string jsonSolid(const ReducedModel& model)
{
    const Eigen::Quaterniond turn(model.pose.linear());
    std::string text = fmt::format(R"("position": {}, "quaternion": [{}, {}, {}, {}])",
                                   array(model.pose.translation()),
                                   turn.w(),
                                   turn.x(),
                                   turn.y(),
                                   turn.z());
    switch (model.kind)
    {
        case ModelKind::Sphere:
            return text + fmt::format(R"(, "radius": {})", model.radius);
        case ModelKind::Capsule:
            return text +
                   fmt::format(R"(, "radius": {}, "height": {})", model.radius, model.height);
        case ModelKind::Box:
            return text + fmt::format(R"(, "half_extents": {})", array(model.halfExtents));
        default:
            return {};
    }
}

std::string jsonReport(const TriangleMesh& full, const ReducedModel& model, double accuracy)
{
    const std::string solid = jsonSolid(model);
    return fmt::format(
        R"({{"kind": "{}", "accuracy": {}, "triangles": {}, "full_triangles": {}, )"
        R"("deviation": {}, "full_from_model": [{}, {}], "model_from_full": [{}, {}]{}{}}})"
        "\n",
        modelKindName(model.kind),
        accuracy,
        model.mesh.triangles.size(),
        full.triangles.size(),
        model.deviation(),
        model.fullFromModel.lower,
        model.fullFromModel.upper,
        model.modelFromFull.lower,
        model.modelFromFull.upper,
        solid.empty() ? "" : ", ",
        solid);
}

std::string textReport(const TriangleMesh& full, const ReducedModel& model, double accuracy)
{
    std::string text = fmt::format("model       {} of {} triangles, in place of {}\n",
                                   modelKindName(model.kind),
                                   model.mesh.triangles.size(),
                                   full.triangles.size());
    if (model.radius > 0.0)
    {
        text += fmt::format("radius      {:.6g}\n", model.radius);
    }
    if (model.kind == ModelKind::Capsule)
    {
        text += fmt::format("height      {:.6g} between the centres of the ends\n", model.height);
    }
    if (model.kind == ModelKind::Box)
    {
        text += fmt::format("extents     {:.6g} {:.6g} {:.6g}\n",
                            2.0 * model.halfExtents.x(),
                            2.0 * model.halfExtents.y(),
                            2.0 * model.halfExtents.z());
    }
    text += fmt::format(
        "deviation   certified {:.4g} of {:.4g}: the full surface from the model {:.4g} to {:.4g}, "
        "the model from the full surface {:.4g} to {:.4g}\n",
        model.deviation(),
        accuracy,
        model.fullFromModel.lower,
        model.fullFromModel.upper,
        model.modelFromFull.lower,
        model.modelFromFull.upper);
    return text;
}

int runReduce(ReduceArguments arguments)
{
    if (std::filesystem::path(arguments.output).extension() != ".obj")
    {
        throw CLI::ValidationError(
            "--output", arguments.output + ": the model is an OBJ file: end its name in .obj");
    }
    requireOtherFile(arguments.output, {arguments.mesh});
    requireWritable(arguments.output);
    for (const ModelKind kind :
         {ModelKind::Sphere, ModelKind::Capsule, ModelKind::Box, ModelKind::Hull, ModelKind::Mesh})
    {
        if (arguments.kind == modelKindName(kind))
        {
            arguments.options.kind = kind;
        }
    }
    const TriangleMesh full = loadMeshFile(arguments.mesh).mesh;
    const StopRequest stop(arguments.timeLimit);
    arguments.options.stop = stop.condition();
    std::optional<ReducedModel> model;
    try
    {
        model = reduceMesh(full, arguments.options);
    }
    catch (const QueryStopped&)
    {
        return stop.finish("bullet-ccd reduce", 0, 1, "models", kNothingFound);
    }
    catch (const std::invalid_argument& error)
    {
        throw std::runtime_error(fmt::format("{}: {}", arguments.mesh, error.what()));
    }
    if (!model)
    {
        fmt::print(stderr,
                   "bullet-ccd reduce: {}: no {} keeps the accuracy of {}: allow more, or take "
                   "--kind {}\n",
                   arguments.mesh,
                   arguments.kind,
                   arguments.options.accuracy,
                   kAnyKind);
        return kNothingFound;
    }
    writeObj(model->mesh, arguments.output);
    fmt::print("{}",
               arguments.json ? jsonReport(full, *model, arguments.options.accuracy)
                              : textReport(full, *model, arguments.options.accuracy));
    return kDone;
}
}  // namespace

void addReduceCommand(CLI::App& app, int& exitCode)
{
    CLI::App* command = app.add_subcommand(
        "reduce", "Makes a smaller model of a mesh that keeps an accuracy, with a certificate.");
    command->footer(
        "No point of the model is farther from the surface of the mesh than the accuracy, and no "
        "point of the mesh farther from that of the model: two models that are g apart stand for "
        "bodies that are g apart, up to the sum of both deviations. The deviation is computed for "
        "all points of the surfaces, not sampled. The output is the mesh itself if nothing smaller "
        "keeps the accuracy.\n"
        "\n"
        "Exit codes: 0 if a model was written, 1 if no model of --kind keeps the accuracy or "
        "--time-limit ended the search, 2 for wrong options, 3 for bad input, 130 after Ctrl-C.\n"
        "\n"
        "Example:\n"
        "  bullet-ccd reduce mug.obj -o mug_small.obj --accuracy 5e-4");
    const auto arguments = std::make_shared<ReduceArguments>();
    arguments->kind = kAnyKind;
    command->add_option("MESH", arguments->mesh, "The mesh.")->type_name("MESH")->required();
    command->add_option("-o,--output", arguments->output, "Where to write the model.")
        ->type_name("OBJ")
        ->required();
    command
        ->add_option("--accuracy",
                     arguments->options.accuracy,
                     "How far the surfaces may be from each other, in the unit of the mesh.")
        ->type_name("LENGTH")
        ->required();
    command->add_flag("--contains",
                      arguments->options.contains,
                      "The model contains the whole body, which must be closed.");
    command
        ->add_option("--kind",
                     arguments->kind,
                     "What the model may be: sphere, capsule, box, hull, mesh, or the cheapest of "
                     "them that keeps the accuracy.")
        ->type_name("NAME")
        ->check(oneOf({kAnyKind, "sphere", "capsule", "box", "hull", "mesh"}))
        ->capture_default_str();
    addTimeLimitOption(*command, arguments->timeLimit, "Give up");
    command->add_flag("--json", arguments->json, "Print the report as one JSON object.");
    command->callback([arguments, &exitCode] { exitCode = runReduce(*arguments); });
}
}  // namespace bullet_ccd::tools
