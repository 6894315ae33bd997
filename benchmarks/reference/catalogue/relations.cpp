#include "benchmarks/reference/catalogue/relations.h"

#include "benchmarks/reference/catalogue/case_parts.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>

namespace bullet_ccd::reference
{
namespace
{
RigidCase movedCase(RigidCase tested, const Eigen::Isometry3d& X)
{
    tested.scene = moved(tested.scene, X);
    return tested;
}

ArticulatedCase movedCase(ArticulatedCase tested, const Eigen::Isometry3d& X)
{
    tested.motion.root = moved(tested.motion.root, X);
    for (TriangleMesh& mesh : tested.obstacles)
    {
        mesh = placed(mesh, X);
    }
    return tested;
}

bool canBeSwapped(const RigidCase&)
{
    return true;
}

bool canBeSwapped(const ArticulatedCase& tested)
{
    return !tested.selfPairs.empty();
}

RigidCase swappedCase(RigidCase tested)
{
    tested.scene = swapped(tested.scene);
    return tested;
}

ArticulatedCase swappedCase(ArticulatedCase tested)
{
    for (auto& [a, b] : tested.selfPairs)
    {
        std::swap(a, b);
    }
    return tested;
}

RigidCase rescaledCase(RigidCase tested, double unit)
{
    tested.scene = scaled(tested.scene, unit);
    return tested;
}

ArticulatedCase rescaledCase(ArticulatedCase tested, double unit)
{
    for (std::size_t i = 0; i < tested.tree.size(); ++i)
    {
        Link& link = tested.tree.links[i];
        link.X_PL0.translation() *= unit;
        if (link.joint.type == JointType::Prismatic)
        {
            tested.motion.positions[i] *= unit;
            tested.motion.rates[i] *= unit;
        }
        tested.linkMeshes[i] = scaled(tested.linkMeshes[i], unit);
    }
    tested.motion.root = scaled(tested.motion.root, unit);
    for (TriangleMesh& mesh : tested.obstacles)
    {
        mesh = scaled(mesh, unit);
    }
    return tested;
}

/// Calls change(mesh) for every mesh.
template <typename Change>
RigidCase withMeshes(RigidCase tested, const Change& change)
{
    tested.scene.meshA = change(tested.scene.meshA);
    tested.scene.meshB = change(tested.scene.meshB);
    return tested;
}

template <typename Change>
ArticulatedCase withMeshes(ArticulatedCase tested, const Change& change)
{
    for (std::vector<TriangleMesh>* meshes : {&tested.linkMeshes, &tested.obstacles})
    {
        for (TriangleMesh& mesh : *meshes)
        {
            mesh = change(mesh);
        }
    }
    return tested;
}

template <typename Case>
Variant<Case> whole(const std::string& name, Case tested)
{
    const CaseAnswer answer = tested.answer;
    return {.name = name, .legs = {{.tested = std::move(tested)}}, .answer = answer};
}

template <typename Case>
std::vector<Variant<Case>> reversedVariants(const Case& tested)
{
    double start = 1.0;
    CaseAnswer answer = tested.answer;
    if (answer.startsTouching)
    {
        return {};
    }
    if (answer.time)
    {
        const double left = 10.0 * answer.finest();
        start = *answer.time - 1.5 * leadTime(answer, left);
        answer = {.clearance = 0.5 * left,
                  .length = answer.length,
                  .tolerances = {answer.tolerances.back()}};
    }
    if (start <= 0.0)
    {
        return {};
    }
    Case back = partOf(tested, start, 0.0);
    back.answer = answer;
    return {whole("backwards", std::move(back))};
}

std::vector<double> cutsOf(const CaseAnswer& answer)
{
    if (!answer.time)
    {
        return {0.5, 0.382};
    }
    const double time = *answer.time;
    std::vector<double> cuts{0.5 * time,
                             time - leadTime(answer, 3.0 * answer.finest()),
                             time - leadTime(answer, 0.5 * answer.finest()),
                             0.5 * (time + 1.0)};
    std::erase_if(cuts, [](double cut) { return cut <= 0.0 || cut >= 1.0; });
    return cuts;
}

template <typename Case>
std::vector<Variant<Case>> splitVariants(const Case& tested)
{
    std::vector<Variant<Case>> variants;
    for (const double cut : cutsOf(tested.answer))
    {
        variants.push_back(
            {.name = "at " + std::to_string(cut),
             .legs = {{.tested = partOf(tested, 0.0, cut), .begin = 0.0, .end = cut},
                      {.tested = partOf(tested, cut, 1.0), .begin = cut, .end = 1.0}},
             .answer = tested.answer});
    }
    return variants;
}

template <typename Case>
std::vector<Variant<Case>> makeVariants(const Case& tested, Relation relation)
{
    std::vector<Variant<Case>> variants;
    const bool exactly = tested.answer.hangsOnRounding;
    Random random(12);
    switch (relation)
    {
        case Relation::Moved:
            for (int i = 0; i < 3 && !exactly; ++i)
            {
                const Eigen::Isometry3d X = random.pose(10.0 * tested.answer.length);
                variants.push_back(whole("frame " + std::to_string(i + 1), movedCase(tested, X)));
            }
            break;
        case Relation::Swapped:
            if (canBeSwapped(tested))
            {
                variants.push_back(whole("swapped", swappedCase(tested)));
            }
            break;
        case Relation::Rescaled:
            for (const double unit : {1e-3, 1e3})
            {
                if (!exactly)
                {
                    Case other = rescaledCase(tested, unit);
                    other.answer = scaled(other.answer, unit);
                    variants.push_back(whole(unit < 1.0 ? "x 0.001" : "x 1000", std::move(other)));
                    variants.back().unit = unit;
                }
            }
            break;
        case Relation::Permuted:
            for (int i = 0; i < 2; ++i)
            {
                variants.push_back(whole(
                    "order " + std::to_string(i + 1),
                    withMeshes(tested,
                               [&](const TriangleMesh& mesh) { return permuted(mesh, random); })));
            }
            break;
        case Relation::Subdivided:
            variants.push_back(whole("four each", withMeshes(tested, subdivided)));
            break;
        case Relation::Reversed:
            return exactly ? variants : reversedVariants(tested);
        case Relation::Split:
            return exactly ? variants : splitVariants(tested);
    }
    return variants;
}
}  // namespace

const char* nameOf(Relation relation)
{
    constexpr std::array<const char*, kRelations.size()> kNames{
        "moved", "swapped", "rescaled", "permuted", "subdivided", "reversed", "split"};
    return kNames[static_cast<std::size_t>(relation)];
}

std::vector<Variant<RigidCase>> variantsOf(const RigidCase& tested, Relation relation)
{
    return makeVariants(tested, relation);
}

std::vector<Variant<ArticulatedCase>> variantsOf(const ArticulatedCase& tested, Relation relation)
{
    return makeVariants(tested, relation);
}

RigidCase partOf(const RigidCase& tested, double begin, double end)
{
    RigidCase part = tested;
    part.scene.motionA = bullet_ccd::partOf(tested.scene.motionA, begin, end);
    part.scene.motionB = bullet_ccd::partOf(tested.scene.motionB, begin, end);
    return part;
}

ArticulatedCase partOf(const ArticulatedCase& tested, double begin, double end)
{
    ArticulatedCase part = tested;
    part.motion = bullet_ccd::partOf(tested.motion, begin, end);
    return part;
}

TriangleMesh subdivided(const TriangleMesh& mesh)
{
    TriangleMesh result{.vertices = mesh.vertices, .triangles = {}};
    const auto addMiddle = [&](std::int32_t i, std::int32_t j)
    {
        const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(i)];
        const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(j)];
        result.vertices.push_back(0.5 * (a + b));
        return static_cast<std::int32_t>(result.vertices.size()) - 1;
    };
    for (const Triangle& t : mesh.triangles)
    {
        const std::int32_t ab = addMiddle(t[0], t[1]);
        const std::int32_t bc = addMiddle(t[1], t[2]);
        const std::int32_t ca = addMiddle(t[2], t[0]);
        result.triangles.push_back({t[0], ab, ca});
        result.triangles.push_back({ab, t[1], bc});
        result.triangles.push_back({ca, bc, t[2]});
        result.triangles.push_back({ab, bc, ca});
    }
    return result;
}
}  // namespace bullet_ccd::reference
