#include "benchmarks/articulated/human_scene.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tools/support/csv_table.h"
#include "tools/support/pose_text.h"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace fs = std::filesystem;

constexpr std::array<const char*, 6> kChessmen{"king", "queen", "bishop", "knight", "rook", "pawn"};

/// On the board, in the recording's frame.
struct Place
{
    std::size_t man;  ///< index into kChessmen
    double x;         ///< [m]
    double z;         ///< [m]
};

using Places = std::array<Place, 16>;

// clang-format off
/// Found by trying positions 5 cm apart: first those at which a link enters a man between two
/// frames and is through it soon, then those that are passed closely without being touched.
constexpr Places kWalkPlaces{{
    {2, 1.25, -0.10}, {5, 0.85, 0.30}, {0, -0.10, 0.50}, {1, 0.40, 0.55},
    {2, 0.30, -0.30}, {5, -0.35, -0.20}, {5, 0.80, -0.30}, {5, 1.50, 0.30},
    {4, -0.45, 0.15}, {5, 1.65, -0.05}, {5, -0.05, -0.40}, {5, 1.10, -0.45},
    {5, 1.20, 0.45}, {3, 1.55, -0.40}, {4, 0.60, -0.60}, {3, -0.45, -0.55}}};

constexpr Places kRunPlaces{{
    {3, 2.70, -0.10}, {3, 1.50, -0.30}, {4, 0.60, -0.25}, {2, 0.25, 0.30},
    {2, 0.75, 0.30}, {1, 3.05, 0.30}, {0, 1.40, 0.35}, {4, 0.20, -0.30},
    {5, 2.15, -0.10}, {5, 3.10, -0.10}, {5, 2.45, 0.30}, {5, -0.20, -0.30},
    {5, 2.35, -0.35}, {5, 1.95, 0.35}, {5, -0.35, 0.15}, {5, 1.05, -0.35}}};

constexpr Places kKickPlaces{{
    {2, 0.85, -1.05}, {0, 0.50, 0.40}, {1, 1.35, 0.10}, {2, 1.00, -0.25},
    {4, 1.45, -0.70}, {3, 0.90, 0.20}, {4, 0.55, -0.65}, {5, -0.25, 0.20},
    {5, 0.10, -0.10}, {5, 1.35, -0.35}, {3, 1.25, -1.15}, {5, 0.25, -0.45},
    {5, -0.25, -0.15}, {5, 0.05, 0.35}, {5, -0.10, -0.45}, {5, -0.20, 0.55}}};
// clang-format on

/// Links of the recording, parents first.
// clang-format off
constexpr std::array<std::array<const char*, 2>, 15> kLinks{{
    {"root", ""}, {"chest", "root"}, {"neck", "chest"},
    {"left_shoulder", "chest"}, {"left_elbow", "left_shoulder"}, {"left_wrist", "left_elbow"},
    {"right_shoulder", "chest"}, {"right_elbow", "right_shoulder"}, {"right_wrist", "right_elbow"},
    {"left_hip", "root"}, {"left_knee", "left_hip"}, {"left_ankle", "left_knee"},
    {"right_hip", "root"}, {"right_knee", "right_hip"}, {"right_ankle", "right_knee"}}};
// clang-format on

std::size_t indexOf(const std::string& name)
{
    const auto* found =
        std::find_if(kLinks.begin(), kLinks.end(), [&](const auto& l) { return name == l[0]; });
    if (found == kLinks.end())
    {
        throw std::runtime_error("the recording has a link \"" + name + "\" that is not known");
    }
    return static_cast<std::size_t>(found - kLinks.begin());
}

/// Frame, time, link, place, quaternion.
Recording readRecording(const fs::path& path)
{
    const tools::CsvTable table = tools::readCsvTable(path, "name the data folder");
    Recording frames;
    for (const tools::CsvRow& row : table.rows)
    {
        const auto at = [&](std::size_t column) { return table.number(row, column); };
        const auto frame = static_cast<std::size_t>(at(0));
        frames.resize(std::max(frames.size(), frame + 1), std::vector<Isometry3d>(kLinks.size()));
        frames[frame][indexOf(row.cells[2])] =
            tools::poseFrom(std::array{at(6), at(7), at(8), at(9), at(3), at(4), at(5)});
    }
    return frames;
}

/// The tree with spherical joints whose offsets are the mean of those of the recording.
KinematicTree makeTree(const Recording& frames)
{
    KinematicTree tree;
    tree.links.resize(kLinks.size());
    for (std::size_t i = 0; i < kLinks.size(); ++i)
    {
        Link& link = tree.links[i];
        link.name = kLinks[i][0];
        if (i == 0)
        {
            continue;
        }
        link.parent = static_cast<std::int32_t>(indexOf(kLinks[i][1]));
        link.joint.type = JointType::Spherical;
        for (const std::vector<Isometry3d>& poses : frames)
        {
            const Isometry3d& X_WP = poses[static_cast<std::size_t>(link.parent)];
            link.X_PL0.translation() +=
                X_WP.inverse() * poses[i].translation() / static_cast<double>(frames.size());
        }
    }
    return tree;
}

/// From frame f to the next.
JointMotion motionOf(const KinematicTree& tree, const Recording& frames, std::size_t f)
{
    JointMotion motion;
    motion.positions.assign(tree.size(), 0.0);
    motion.rates.assign(tree.size(), 0.0);
    motion.balls.resize(tree.size());
    motion.root = motionBetween(frames[f][0], frames[f + 1][0]);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const auto parent = static_cast<std::size_t>(tree.links[i].parent);
        const auto turn = [&](std::size_t frame) -> Eigen::Matrix3d
        { return frames[frame][parent].linear().transpose() * frames[frame][i].linear(); };
        motion.balls[i] = ballBetween(turn(f), turn(f + 1));
    }
    return motion;
}

/// Upright, on y = 0, the tallest (the king) 0.9 m.
std::vector<TriangleMesh> loadPieces(const fs::path& data)
{
    std::vector<TriangleMesh> pieces;
    double kingHeight = 0.0;
    for (const char* name : kChessmen)
    {
        pieces.push_back(loadMeshFile(data / "objects/chess" / (std::string(name) + ".ply")).mesh);
        kingHeight = std::max(kingHeight, bounds(pieces.back()).sizes().maxCoeff());
    }
    for (TriangleMesh& piece : pieces)
    {
        const Eigen::AlignedBox3d box = bounds(piece);
        Eigen::Index up = 0;
        box.sizes().maxCoeff(&up);
        Vector3d base = box.center();
        base[up] = box.min()[up];
        for (Vector3d& vertex : piece.vertices)
        {
            const Vector3d v = (vertex - base) * (0.9 / kingHeight);
            vertex = Vector3d(v[(up + 1) % 3], v[up], v[(up + 2) % 3]);
        }
    }
    return pieces;
}

/// Lowest point of the human in all frames: the height of the board.
double lowestPoint(const HumanScene& scene, const Recording& frames)
{
    double lowest = 0.0;
    for (const std::vector<Isometry3d>& poses : frames)
    {
        for (std::size_t i = 0; i < poses.size(); ++i)
        {
            for (const Vector3d& vertex : scene.links[i].mesh().vertices)
            {
                lowest = std::min(lowest, (poses[i] * vertex).y());
            }
        }
    }
    return lowest;
}

void addObstacle(HumanScene& scene, std::size_t piece, const Vector3d& at)
{
    Isometry3d X = Isometry3d::Identity();
    X.translation() = at;
    scene.obstacles.push_back({.tree = &scene.pieces[piece], .motion = restAt(X)});
    scene.obstacleTriangles += scene.pieces[piece].mesh().triangles.size();
}

const Places& placesOf(const std::string& name)
{
    static const std::map<std::string, const Places*> kPlaces{
        {"walk", &kWalkPlaces}, {"run", &kRunPlaces}, {"kick", &kKickPlaces}};
    const auto found = kPlaces.find(name);
    if (found == kPlaces.end())
    {
        throw std::runtime_error("motion \"" + name + "\" is not known: walk, run or kick");
    }
    return *found->second;
}

/// On a board that the lowest foot nearly touches.
void addChessmen(HumanScene& scene,
                 const fs::path& data,
                 const Recording& frames,
                 const Places& places)
{
    scene.pieces.reserve(kChessmen.size() + 1);  // obstacles point to them
    for (const TriangleMesh& mesh : loadPieces(data))
    {
        scene.pieces.push_back(buildSsvTree(mesh));
    }
    constexpr double kHalfThickness = 0.05;
    scene.pieces.push_back(buildSsvTree(makeBox(Vector3d(4.0, kHalfThickness, 4.0))));
    const double floor = lowestPoint(scene, frames) - 1e-3;
    for (const Place& place : places)
    {
        addObstacle(scene, place.man, {place.x, floor, place.z});
    }
    const Vector3d middle = frames[frames.size() / 2][0].translation();
    addObstacle(scene, kChessmen.size(), {middle.x(), floor - kHalfThickness, middle.z()});
}

/// Exempts, at feature level, what intersects at the start.
void addMasks(HumanScene& scene, HumanQuery& query)
{
    for (std::size_t i = 0; i < scene.links.size(); ++i)
    {
        const auto link = static_cast<std::int32_t>(i);
        const Isometry3d X_WL = linkStateAt(scene.tree, query.motion, kNone, link, 0.0).X_W;
        for (std::size_t k = 0; k < scene.obstacles.size(); ++k)
        {
            const SsvTree& tree = *scene.obstacles[k].tree;
            const Isometry3d X_OL = scene.obstacles[k].motion.X_W0.inverse() * X_WL;
            if (treeDistance(scene.links[i], tree, X_OL, 1e-6).triangleA == kNone)
            {
                continue;
            }
            query.storage.push_back(std::make_unique<const PairMask>(
                maskNear(scene.links[i], tree, std::span(&X_OL, 1), kMaskReach)));
            query.masks.push_back({.link = link,
                                   .otherLink = kNone,
                                   .obstacle = static_cast<std::int32_t>(k),
                                   .mask = query.storage.back().get()});
        }
    }
}
}  // namespace

const PairMask* HumanQuery::maskOf(std::int32_t link, std::int32_t obstacle) const
{
    const auto found = std::find_if(masks.begin(),
                                    masks.end(),
                                    [&](const LinkMask& mask)
                                    { return mask.link == link && mask.obstacle == obstacle; });
    return found == masks.end() ? nullptr : found->mask;
}

ArticulatedBody HumanScene::body(const HumanQuery& query) const
{
    return {.tree = &tree,
            .linkTrees = linkTrees,
            .motion = &query.motion,
            .selfPairs = {},
            .masks = query.masks};
}

HumanScene makeHumanScene(const fs::path& data, const std::string& name)
{
    const Places& places = placesOf(name);
    const Recording frames = readRecording(data / "motions/humanoid" / (name + "_poses.csv"));
    HumanScene scene;
    scene.tree = makeTree(frames);
    for (const auto& link : kLinks)
    {
        const std::string file = std::string(link[0]) + ".obj";
        scene.links.push_back(
            buildSsvTree(loadMeshFile(data / "motions/humanoid/meshes" / file).mesh));
        scene.humanTriangles += scene.links.back().mesh().triangles.size();
    }
    for (const SsvTree& tree : scene.links)
    {
        scene.linkTrees.push_back(&tree);
    }
    addChessmen(scene, data, frames, places);
    for (std::size_t f = 0; f + 1 < frames.size(); ++f)
    {
        HumanQuery& query = scene.queries.emplace_back();
        query.motion = motionOf(scene.tree, frames, f);
        addMasks(scene, query);
    }
    return scene;
}
}  // namespace bullet_ccd::benchmarks
