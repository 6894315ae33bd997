#include "tools/grasp_cli/answers/trial_models.h"

#include "bullet_ccd/reduce/reduce_mesh.h"
#include "tools/support/text_table.h"

#include <fmt/format.h>
#include <optional>
#include <utility>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
void reduceTree(SsvTree& tree, double accuracy, TrialModels& models)
{
    const std::size_t before = tree.mesh().triangles.size();
    models.ofTriangles += before;
    std::optional<ReducedModel> model;
    if (accuracy >= smallestAccuracy(tree.mesh()))
    {
        model = reduceMesh(tree.mesh(), {.accuracy = accuracy});
    }
    if (model && model->mesh.triangles.size() < before)
    {
        ++models.shapes[modelKindName(model->kind)];
        tree = buildSsvTree(std::move(model->mesh));
    }
    else
    {
        ++models.shapes["full mesh"];
    }
    models.triangles += tree.mesh().triangles.size();
}
}  // namespace

TrialModels reduceForTrial(grasp::HandModel& hand, grasp::GraspObject& object, double accuracy)
{
    TrialModels models;
    const double share = kModelShare * accuracy;
    reduceTree(object.tree, share, models);
    for (SsvTree& tree : hand.trees)
    {
        reduceTree(tree, share, models);
    }
    return models;
}

std::string plainText(const TrialModels& models)
{
    std::vector<std::string> shapes;
    for (const auto& [kind, count] : models.shapes)
    {
        shapes.push_back(fmt::format("{} {}", count, kind));
    }
    return fmt::format("models: {}; {} of {} triangles",
                       joined(shapes, ", "),
                       models.triangles,
                       models.ofTriangles);
}
}  // namespace bullet_ccd::tools
