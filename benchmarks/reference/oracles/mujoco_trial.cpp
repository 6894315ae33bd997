#include "benchmarks/reference/oracles/mujoco_trial.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/trial/trial_start.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
using grasp::TrialOutcome;
using Axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

// Of grasp_trial.cpp.
constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kStandTime = 0.25;           // [s]
constexpr double kCloseTime = 1.0;            // [s]
constexpr double kMostCloseTime = 2.0;        // [s]
constexpr double kCloseShare = 0.1;
constexpr double kLeastShare = 0.02;
constexpr double kStalled = 0.05;      // of the speed of closing
constexpr double kDampingTime = 0.02;  // [s]
constexpr double kTouchTime = 0.2;     // [s]
constexpr double kRampTime = 0.25;     // [s]
constexpr double kSettleTime = 1.0;    // [s]
constexpr double kRestSpeed = 5e-3;    // [m/s]
constexpr double kRestSpin = 0.1;      // [rad/s]
constexpr double kSkin = 1e-3;         // [m]

constexpr double kPaceTime = 0.1;                       // [s]
constexpr double kLeftWay = 1e-3;                       // [m]
constexpr double kLeftTurn = std::numbers::pi / 180.0;  // [rad]

constexpr double kFollow = 0.02;  // of the error of a torque, in a step

// So near to the object, or to each other, pieces of links have to come in a posture of the way to
// take part. What moves farther is no longer held. MuJoCo would look at all pairs in all steps,
// which takes ten times as long as the rest of a step.
constexpr double kNearObject = 0.03;        // [m]
constexpr double kNearLink = 0.002;         // [m]
constexpr int kOnTheWay = 4;                // postures of a closing hand
constexpr double kFarBelow = 10.0;          // where a table is that nobody needs [m]
constexpr const char* kFile = "grasp.xml";  // in memory
constexpr double kClearlyApart = 1e-4;      // [m]
constexpr double kSameWay = 0.9;            // cosine of normals of one contact

/// Where the hand is in trials of a grasp: held, squeezed, and closing around the object.
std::vector<grasp::TrialPosture> posturesOf(const grasp::HandModel& hand,
                                            const grasp::GraspObject& object,
                                            const grasp::Grasp& grasp,
                                            const grasp::Squeeze& squeeze)
{
    std::vector<grasp::TrialPosture> postures{grasp::heldStart(hand, object, grasp, kSkin)};
    postures.push_back({.blocked = "", .X_WH = grasp.X_WH, .positions = grasp.positions});
    std::vector<double> pressed = grasp.positions;
    const std::vector<std::int32_t> joints = grasp::independentJoints(hand.robot.tree);
    for (std::size_t j = 0; j < squeeze.targets.size(); ++j)
    {
        pressed[static_cast<std::size_t>(joints[j])] = squeeze.targets[j];
    }
    postures.push_back({.blocked = "", .X_WH = grasp.X_WH, .positions = pressed});
    const grasp::TrialPosture open =
        grasp::openStart(hand, object, grasp, grasp::shippedProtocol("lift"), 1, kSkin);
    if (open.blocked.empty())
    {
        const std::vector<double> end = grasp::closedPositions(hand, open.positions);
        for (int k = 0; k <= kOnTheWay; ++k)
        {
            postures.push_back(open);
            for (std::size_t i = 0; i < end.size(); ++i)
            {
                postures.back().positions[i] +=
                    double(k) / kOnTheWay * (end[i] - open.positions[i]);
            }
        }
    }
    std::erase_if(postures, [](const auto& posture) { return !posture.blocked.empty(); });
    return postures;
}

std::vector<Eigen::AlignedBox3d> boxesOf(const ConvexPieces& pieces, const Eigen::Isometry3d& X)
{
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const TriangleMesh& piece : pieces.pieces)
    {
        boxes.emplace_back();
        for (const Eigen::Vector3d& vertex : piece.vertices)
        {
            boxes.back().extend(X * vertex);
        }
    }
    return boxes;
}

/// The pieces that may meet, and the pairs of them by the names of writeMjcf().
struct Meetings
{
    grasp::MjcfPieces pieces;
    std::set<std::pair<std::string, std::string>> pairs;
};

Meetings meetingsOf(const grasp::HandModel& hand,
                    const grasp::GraspObject& object,
                    const grasp::Grasp& grasp,
                    const grasp::Squeeze& squeeze,
                    const grasp::MjcfPieces& pieces)
{
    using Piece = std::pair<std::size_t, std::size_t>;  // of a link; the object comes last
    const std::size_t links = pieces.links.size();
    const KinematicTree& tree = hand.robot.tree;
    std::set<std::pair<Piece, Piece>> pairs;
    for (grasp::TrialPosture& posture : posturesOf(hand, object, grasp, squeeze))
    {
        applyMimics(tree, posture.positions);
        const std::vector<Eigen::Isometry3d> poses =
            linkPoses(tree, posture.X_WH, posture.positions);
        std::vector<std::vector<Eigen::AlignedBox3d>> boxes;
        for (std::size_t link = 0; link < links; ++link)
        {
            boxes.push_back(boxesOf(pieces.links[link], poses[link]));
        }
        boxes.push_back(boxesOf(pieces.object, Eigen::Isometry3d::Identity()));
        const auto meet = [&](std::size_t a, std::size_t b, double near)
        {
            for (std::size_t i = 0; i < boxes[a].size(); ++i)
            {
                for (std::size_t j = 0; j < boxes[b].size(); ++j)
                {
                    if (boxes[a][i].exteriorDistance(boxes[b][j]) < near)
                    {
                        pairs.insert({{a, i}, {b, j}});
                    }
                }
            }
        };
        for (std::size_t link = 0; link < links; ++link)
        {
            meet(link, links, kNearObject);
        }
        for (const auto& [a, b] : hand.selfPairs)
        {
            meet(static_cast<std::size_t>(a), static_cast<std::size_t>(b), kNearLink);
        }
    }
    Meetings meetings{
        .pieces = {.links = std::vector<ConvexPieces>(links), .object = pieces.object},
        .pairs = {}};
    std::map<Piece, std::string> names;
    const auto nameOf = [&](const Piece& piece)
    {
        if (piece.first == links)
        {
            return "object_" + std::to_string(piece.second);
        }
        std::string& name = names[piece];
        if (name.empty())
        {
            std::vector<TriangleMesh>& kept = meetings.pieces.links[piece.first].pieces;
            name = fmt::format("link{}_{}", piece.first, kept.size());
            kept.push_back(pieces.links[piece.first].pieces[piece.second]);
        }
        return name;
    };
    for (const auto& [a, b] : pairs)
    {
        meetings.pairs.insert({nameOf(a), nameOf(b)});
    }
    for (std::size_t k = 0; k < pieces.object.pieces.size(); ++k)
    {
        meetings.pairs.insert({"table", "object_" + std::to_string(k)});
    }
    return meetings;
}

mjfCollision collideHulls = nullptr;  // MuJoCo's own

/// The vertices of a hull in its own frame, as columns.
Eigen::Map<const Eigen::Matrix3Xf> verticesOf(const mjModel* model, int geometry)
{
    const int mesh = model->geom_dataid[geometry];
    return {model->mesh_vert + 3 * model->mesh_vertadr[mesh], 3, model->mesh_vertnum[mesh]};
}

/// How a hull leaves another one that it meets.
struct WayOut
{
    double depth;
    Eigen::Vector3d normal;  ///< outwards, of the face through which it leaves, W
};

/// The shortest way of `other` out of `hull` through a face, if one is shorter than `depth`.
/// @param point  in both of them, W: ways through faces that are farther from it are longer
WayOut wayOut(const mjModel* model,
              const mjData* data,
              int hull,
              int other,
              double depth,
              const Eigen::Vector3d& point)
{
    using Point = Eigen::Map<const Eigen::Vector3d>;
    const int mesh = model->geom_dataid[hull];
    const Eigen::Map<const Eigen::Matrix3Xi> faces(
        model->mesh_face + 3 * model->mesh_faceadr[mesh], 3, model->mesh_facenum[mesh]);
    const Eigen::Map<const Eigen::Matrix3Xf> vertices = verticesOf(model, hull);
    const Axes R_WH(data->geom_xmat + 9 * hull);
    const Axes R_WO(data->geom_xmat + 9 * other);
    const Eigen::Vector3d inside = R_WH.transpose() * (point - Point(data->geom_xpos + 3 * hull));
    const Eigen::Vector3d way =
        R_WH.transpose() * (Point(data->geom_xpos + 3 * other) - Point(data->geom_xpos + 3 * hull));
    WayOut nearest{depth, Eigen::Vector3d::Zero()};
    for (const Eigen::Vector3i& face : faces.colwise())
    {
        const Eigen::Vector3d a = vertices.col(face[0]).cast<double>();
        const Eigen::Vector3d normal = (vertices.col(face[1]).cast<double>() - a)
                                           .cross(vertices.col(face[2]).cast<double>() - a);
        const double size = normal.norm();
        if (std::abs(normal.dot(a - inside)) >= nearest.depth * size)
        {
            continue;
        }
        const Eigen::Vector3d outwards = normal / size;
        const Eigen::Vector3f seen = (R_WO.transpose() * (R_WH * outwards)).cast<float>();
        const double lowest = (seen.transpose() * verticesOf(model, other)).minCoeff();
        const double out = outwards.dot(a - way) - lowest;
        if (out < nearest.depth)
        {
            nearest = {out, R_WH * outwards};
        }
    }
    return nearest;
}

/// Most hulls whose bounding spheres meet are apart by their boxes, and MuJoCo has no contact of
/// what is apart. Its own answer takes tens of times as long as that of the boxes.
///
/// Of long or flat hulls that meet far from their middles, its own answer (MPR of libccd) may be
/// centimetres too deep, along their length, and throws them apart. Where the way out through a
/// face is shorter and another one, its points get the depth and the normal of that.
int collideByBoxes(
    const mjModel* model, const mjData* data, mjContact* contact, int a, int b, mjtNum margin)
{
    using Point = Eigen::Map<const Eigen::Vector3d>;
    const Axes R_WA(data->geom_xmat + 9 * a);
    const Axes R_WB(data->geom_xmat + 9 * b);
    // Half of boxes about the origins of the geometries.
    const Point sizeA(model->geom_size + 3 * a);
    const Point sizeB(model->geom_size + 3 * b);
    const Eigen::Vector3d way = Point(data->geom_xpos + 3 * b) - Point(data->geom_xpos + 3 * a);
    const Eigen::Matrix3d R_AB = R_WA.transpose() * R_WB;
    const Eigen::Matrix3d shares = R_AB.cwiseAbs();
    const Eigen::Array3d gapA = (R_WA.transpose() * way).cwiseAbs() - sizeA - shares * sizeB;
    const Eigen::Array3d gapB =
        (R_WB.transpose() * way).cwiseAbs() - sizeB - shares.transpose() * sizeA;
    const double apart = std::max(margin, 0.0) + kClearlyApart;
    if (gapA.maxCoeff() > apart || gapB.maxCoeff() > apart)
    {
        return 0;
    }
    const int count = collideHulls(model, data, contact, a, b, margin);
    if (count == 0)
    {
        return 0;
    }
    const Point inside(contact->pos);
    WayOut out = wayOut(model, data, a, b, -contact->dist, inside);
    const WayOut back = wayOut(model, data, b, a, out.depth, inside);
    out = back.depth < out.depth ? WayOut{back.depth, -back.normal} : out;
    if (out.depth >= -contact->dist || Point(contact->frame).dot(out.normal) > kSameWay)
    {
        return count;
    }
    for (int k = 0; k < count; ++k)
    {
        contact[k].dist = -out.depth;
        Eigen::Map<Eigen::Vector3d>(contact[k].frame) = out.normal;
        Eigen::Map<Eigen::Vector3d>(contact[k].frame + 3).setZero();
    }
    return count;
}

/// Puts the vertices of pieces into a text behind `at`: files of them take longer than all else.
void insertVertices(std::string& text,
                    std::size_t& at,
                    const std::string& body,
                    const ConvexPieces& pieces)
{
    for (std::size_t k = 0; k < pieces.pieces.size(); ++k)
    {
        const std::string file = fmt::format("file=\"{}_{}.obj\"", body, k);
        std::string vertices = "vertex=\"";
        for (const Eigen::Vector3d& vertex : pieces.pieces[k].vertices)
        {
            vertices += fmt::format("{:.9g} {:.9g} {:.9g} ", vertex.x(), vertex.y(), vertex.z());
        }
        at = text.find(file, at);
        text.replace(at, file.size(), vertices + '"');
    }
}

/// Makes `count` pairs of the only one of a model. MuJoCo takes half a second to compile ten
/// thousand, because it compares each with all others.
void repeatPair(mjModel& model, int count, PairMemory& memory)
{
    model.npair = count;
    memory.numbers.resize(std::size_t(count) * 4);
    memory.values.resize(std::size_t(count) * (mjNREF + mjNIMP + 7));
    const auto repeat = [count](auto*& values, int size, auto*& place)
    {
        const auto* one = std::exchange(values, place);
        for (int k = 0; k < count; ++k)
        {
            place = std::copy_n(one, size, place);
        }
    };
    int* number = memory.numbers.data();
    for (int** numbers :
         {&model.pair_dim, &model.pair_geom1, &model.pair_geom2, &model.pair_signature})
    {
        repeat(*numbers, 1, number);
    }
    mjtNum* value = memory.values.data();
    repeat(model.pair_solref, mjNREF, value);
    repeat(model.pair_solimp, mjNIMP, value);
    repeat(model.pair_margin, 1, value);
    repeat(model.pair_gap, 1, value);
    repeat(model.pair_friction, 5, value);
}

mjModel* compiled(const grasp::HandModel& hand,
                  const grasp::GraspObject& object,
                  const grasp::Grasp& grasp,
                  const grasp::Squeeze& squeeze,
                  const grasp::MjcfPieces& pieces,
                  PairMemory& pairs)
{
    const Meetings meetings = meetingsOf(hand, object, grasp, squeeze, pieces);
    std::ostringstream model;
    grasp::writeMjcf(model, hand, object, grasp, squeeze, meetings.pieces, {.mass = 1.0});
    std::string text = model.str();
    std::size_t at = 0;
    for (std::size_t link = 0; link < meetings.pieces.links.size(); ++link)
    {
        insertVertices(text, at, fmt::format("link{}", link), meetings.pieces.links[link]);
    }
    insertVertices(text, at, "object", meetings.pieces.object);
    const auto insertBehind = [&text](const std::string& place, const std::string& what)
    { text.insert(text.find(place) + place.size(), what); };
    const std::string geom = "<geom type=\"mesh\" ";
    const std::size_t looks = text.find(geom) + geom.size();
    insertBehind("<default>", "<pair " + text.substr(looks, text.find("/>", looks) - looks) + "/>");
    insertBehind("<option ", "collision=\"predefined\" ");
    insertBehind("<worldbody>",
                 R"(<geom name="table" type="plane" pos="0 0 -1" size="1 1 1"/>)"
                 R"(<geom name="none" type="sphere" size="1"/>)");
    text.insert(text.find("</mujoco>"),
                R"(<size nconmax="300" njmax="1500"/>)"
                R"(<contact><pair geom1="table" geom2="none"/></contact>)");
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), kFile, static_cast<int>(text.size()));
    std::memcpy(files->filedata[0], text.data(), text.size());
    char error[1000] = "";
    static std::mutex mutex;  // MuJoCo keeps the last file that it read
    const std::scoped_lock lock(mutex);
    mjfCollision& collide = mjCOLLISIONFUNC[mjGEOM_MESH][mjGEOM_MESH];
    if (collide != &collideByBoxes)
    {
        collideHulls = std::exchange(collide, &collideByBoxes);
    }
    mjModel* compiled = mj_loadXML(kFile, files.get(), error, sizeof error);
    mj_deleteVFS(files.get());
    if (compiled == nullptr)
    {
        throw std::runtime_error(hand.robot.name + ", " + object.name + ": MuJoCo: " + error);
    }
    std::map<std::string, int> geometries;
    for (int geometry = 0; geometry < compiled->ngeom; ++geometry)
    {
        geometries[mj_id2name(compiled, mjOBJ_GEOM, geometry)] = geometry;
    }
    repeatPair(*compiled, static_cast<int>(meetings.pairs.size()), pairs);
    int pair = 0;
    for (const auto& [a, b] : meetings.pairs)
    {
        // As MuJoCo sorts them: planes first, and bodies as they come.
        const auto sorted = std::minmax(geometries.at(a), geometries.at(b));
        compiled->pair_geom1[pair] = sorted.first;
        compiled->pair_geom2[pair++] = sorted.second;
    }
    return compiled;
}
}  // namespace

MujocoTrials::MujocoTrials(const grasp::HandModel& hand,
                           const grasp::GraspObject& object,
                           const grasp::Grasp& grasp,
                           const grasp::Squeeze& squeeze,
                           const grasp::MjcfPieces& pieces)
    : m_hand(hand),
      m_object(object),
      m_model(compiled(hand, object, grasp, squeeze, pieces, m_pairMemory), &mj_deleteModel),
      m_data(mj_makeData(m_model.get()), &mj_deleteData),
      m_joints(grasp::independentJoints(hand.robot.tree)),
      m_table(mj_name2id(m_model.get(), mjOBJ_GEOM, "table")),
      m_body(m_model->nbody - 1),
      m_inertia(m_model->body_inertia + 3 * m_body)
{
    for (int pair = 0; pair < m_model->npair; ++pair)
    {
        m_pairs[std::minmax(m_model->pair_geom1[pair], m_model->pair_geom2[pair])] = pair;
    }
    for (const Link& link : hand.robot.tree.links)
    {
        const std::string name = link.joint.isMovable() ? link.joint.name : "";
        const int joint = mj_name2id(m_model.get(), mjOBJ_JOINT, name.c_str());
        m_places.push_back(joint < 0 ? -1 : m_model->jnt_qposadr[joint]);
    }
}

void MujocoTrials::begin(const std::vector<double>& positions,
                         double mass,
                         double friction,
                         double torsion)
{
    m_model->body_mass[m_body] = mass;
    Eigen::Map<Eigen::Vector3d>(m_model->body_inertia + 3 * m_body) = mass * m_inertia;
    for (int pair = 0; pair < m_model->npair; ++pair)
    {
        Eigen::Map<Eigen::Vector3d>(m_model->pair_friction + 5 * pair) << friction, friction,
            torsion;
        m_model->pair_dim[pair] = torsion > 0.0 ? 4 : 3;
        m_model->pair_margin[pair] = 0.0;
    }
    mj_setConst(m_model.get(), m_data.get());
    mj_resetData(m_model.get(), m_data.get());
    for (std::size_t i = 0; i < m_places.size(); ++i)
    {
        if (m_places[i] >= 0)
        {
            m_data->qpos[m_places[i]] = positions[i];
        }
    }
    mj_forward(m_model.get(), m_data.get());
    // Pieces bulge beyond the surfaces. Where that puts them into each other at the start, when
    // hand and object are apart, they press once they are deeper.
    for (const mjContact* contact = m_data->contact; contact != m_data->contact + m_data->ncon;
         ++contact)
    {
        if (contact->geom1 != m_table && contact->geom2 != m_table)
        {
            double& margin =
                m_model->pair_margin[m_pairs.at(std::minmax(contact->geom1, contact->geom2))];
            margin = std::min(margin, contact->dist);
        }
    }
    mj_forward(m_model.get(), m_data.get());
    refer();
}

void MujocoTrials::drive(std::size_t joint, double effort, double target)
{
    m_model->actuator_forcerange[2 * joint] = -effort;
    m_model->actuator_forcerange[2 * joint + 1] = effort;
    m_data->ctrl[joint] = target;
}

void MujocoTrials::step(const Eigen::Vector3d& force)
{
    Eigen::Map<Eigen::Vector3d>(m_data->xfrc_applied + 6 * m_body) = force;
    mj_step(m_model.get(), m_data.get());
}

Eigen::Vector3d MujocoTrials::center() const
{
    return Eigen::Map<const Eigen::Vector3d>(m_data->xipos + 3 * m_body);
}

Eigen::Matrix3d MujocoTrials::axes() const
{
    return Axes(m_data->xmat + 9 * m_body);
}

double MujocoTrials::turned() const
{
    return Eigen::AngleAxisd(m_axes.transpose() * axes()).angle();
}

void MujocoTrials::refer()
{
    m_center = center();
    m_axes = axes();
}

bool MujocoTrials::touches() const
{
    return std::any_of(m_data->contact,
                       m_data->contact + m_data->ncon,
                       [this](const mjContact& c)
                       { return c.geom1 != m_table && c.geom2 != m_table; });
}

bool MujocoTrials::isAtRest() const
{
    mjtNum speed[6];
    mj_objectVelocity(m_model.get(), m_data.get(), mjOBJ_BODY, m_body, speed, 0);
    return mju_norm3(speed + 3) < kRestSpeed && mju_norm3(speed) < kRestSpin;
}

grasp::TrialResult MujocoTrials::run(const grasp::Grasp& grasp,
                                     const grasp::Squeeze& squeeze,
                                     const grasp::TrialProtocol& protocol,
                                     double mass,
                                     double friction,
                                     double torsion)
{
    grasp::TrialResult result;
    result.reason = squeeze.reason;
    if (!squeeze.exists())
    {
        return result;
    }
    const bool isHeld = protocol.start == grasp::TrialStart::Held;
    const grasp::TrialPosture start =
        isHeld ? grasp::heldStart(m_hand, m_object, grasp, kSkin)
               : grasp::openStart(m_hand, m_object, grasp, protocol, 1, kSkin);
    if (!start.blocked.empty())
    {
        result.outcome = TrialOutcome::NeverTouched;
        result.reason = start.blocked;
        return result;
    }
    const Eigen::Quaterniond q(start.X_WH.linear());
    Eigen::Map<Eigen::Vector3d>(m_model->body_pos + 3) = start.X_WH.translation();
    Eigen::Map<Eigen::Vector4d>(m_model->body_quat + 4) << q.w(), q.vec();
    const bool stands = protocol.start == grasp::TrialStart::Table;
    double& table = m_model->geom_pos[3 * m_table + 2];
    table =
        grasp::lowestHeight(m_object.tree, Eigen::Isometry3d::Identity(), Eigen::Vector3d::UnitZ());
    table -= stands ? 0.0 : kFarBelow;
    begin(start.positions, mass, friction, torsion);
    const auto drives = [&](auto&& set)
    {
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            set(j, static_cast<std::size_t>(m_joints[j]));
        }
    };
    const Eigen::Vector3d weight(0.0, 0.0, stands ? -mass * kStandardGravity : 0.0);
    const double& time = m_data->time;
    const auto gentle = [&](std::size_t j)
    {
        return std::max(kCloseShare * std::abs(squeeze.torques[j]),
                        kLeastShare * squeeze.efforts[j].limit);
    };
    while (stands && time < kStandTime)
    {
        drives([&](std::size_t j, std::size_t link)
               { drive(j, squeeze.efforts[j].limit, start.positions[link]); });
        step(weight);
    }
    if (way() > protocol.heldWay || turned() > protocol.heldTurn)
    {
        result.outcome = TrialOutcome::NotSettled;
        result.reason = "the object does not stand on the table by itself";
        return result;
    }
    if (isHeld)
    {
        while (time < kTouchTime)
        {
            const double share = std::min(1.0, 2.0 * time / kTouchTime);
            drives(
                [&](std::size_t j, std::size_t link)
                {
                    const double from = start.positions[link];
                    drive(j, gentle(j), from + share * (grasp.positions[link] - from));
                });
            step(weight);
        }
    }
    else
    {
        // As fast as ours, until all have stopped; joints that are stopped are pressed gently, and
        // others may come. Targets wait for their joints, which would fly to them where the object
        // gives way.
        const std::vector<double> end = grasp::closedPositions(m_hand, start.positions);
        std::vector<double> targets = start.positions;
        const double began = time;
        bool isMoving = true;
        while (isMoving && time < began + kMostCloseTime && way() <= protocol.lostWay)
        {
            const std::vector<double> before(m_data->qpos, m_data->qpos + m_model->nq);
            const auto speed = [&](std::size_t link)
            { return (end[link] - start.positions[link]) / kCloseTime; };
            drives(
                [&](std::size_t j, std::size_t link)
                {
                    if (speed(link) == 0.0)
                    {
                        drive(j, squeeze.efforts[j].limit, start.positions[link]);
                        return;
                    }
                    const double ahead =
                        gentle(j) / squeeze.stiffness[j] + kDampingTime * std::abs(speed(link));
                    const double here = before[static_cast<std::size_t>(m_places[link])];
                    const double next = targets[link] + speed(link) * m_model->opt.timestep;
                    const auto [low, high] = std::minmax(start.positions[link], end[link]);
                    targets[link] =
                        std::clamp(std::clamp(next, here - ahead, here + ahead), low, high);
                    drive(j, gentle(j), targets[link]);
                });
            step(weight);
            isMoving = time < began + 0.25 * kCloseTime || !isAtRest();
            drives(
                [&](std::size_t, std::size_t link)
                {
                    const auto place = static_cast<std::size_t>(m_places[link]);
                    const double most = kStalled * std::abs(speed(link)) * m_model->opt.timestep;
                    isMoving = isMoving ||
                               (most > 0.0 && std::abs(m_data->qpos[place] - before[place]) > most);
                });
        }
    }
    const double pressed = time;
    std::vector<double> from;
    drives([&](std::size_t, std::size_t link) { from.push_back(m_data->qpos[m_places[link]]); });
    while (way() <= protocol.lostWay && time < pressed + kRampTime + kSettleTime &&
           !(time > pressed + 1.5 * kRampTime && isAtRest()))
    {
        const double share = std::min(1.0, (time - pressed) / kRampTime);
        drives(
            [&](std::size_t j, std::size_t)
            {
                // Contacts give way by more than skins do, so the targets go on until the
                // controllers press with the squeeze's torques; they never yield. Then they stay,
                // as ours do.
                const double torque = share * squeeze.torques[j];
                const double error = torque - m_data->actuator_force[j];
                const bool goesOn = time < pressed + 1.5 * kRampTime && error * torque > 0.0;
                from[j] += goesOn ? kFollow * error / squeeze.stiffness[j] : 0.0;
                drive(j, squeeze.efforts[j].limit, from[j] + torque / squeeze.stiffness[j]);
            });
        step(weight);
    }
    result.outcome = way() > protocol.lostWay ? TrialOutcome::Ejected
                     : !touches()             ? TrialOutcome::NeverTouched
                     : !isAtRest()            ? TrialOutcome::NotSettled
                                              : TrialOutcome::Held;
    refer();
    double end = time;
    for (const grasp::TrialPhase& phase : protocol.phases)
    {
        require(phase.kind == grasp::TrialPhase::Kind::Load ||
                    phase.kind == grasp::TrialPhase::Kind::Lift,
                "MujocoTrials: only loads and lifts are known: give another protocol");
        const double began = end;
        const double height = table;
        end += phase.time;
        double looked = time;
        Eigen::Vector3d centerThen = center();
        Eigen::Matrix3d axesThen = axes();
        while (result.outcome == TrialOutcome::Held && time < end)
        {
            if (phase.kind == grasp::TrialPhase::Kind::Load && time >= looked + kPaceTime)
            {
                // As brief trials of ours.
                const double paces = (end - time) / (time - looked);
                const double wayLeft = paces * (center() - centerThen).norm();
                const double turnLeft =
                    paces * Eigen::AngleAxisd(axesThen.transpose() * axes()).angle();
                if (wayLeft <= kLeftWay && turnLeft <= kLeftTurn &&
                    result.slip + wayLeft <= protocol.heldWay &&
                    result.turn + turnLeft <= protocol.heldTurn)
                {
                    end = time;
                    break;
                }
                looked = time;
                centerThen = center();
                axesThen = axes();
            }
            Eigen::Vector3d acceleration =
                phase.amount * kStandardGravity * phase.direction.normalized();
            if (phase.kind == grasp::TrialPhase::Kind::Lift)
            {
                // The hand stays: the table sinks, and what accelerates the hand acts on the
                // object.
                const double omega = std::numbers::pi / phase.time;
                const double turn = omega * (time - began);
                table = height - 0.5 * phase.amount * (1.0 - std::cos(turn));
                acceleration.x() = acceleration.y() = 0.0;
                acceleration.z() =
                    -kStandardGravity - 0.5 * phase.amount * omega * omega * std::cos(turn);
            }
            step(mass * acceleration);
            result.slip = std::max(result.slip, way());
            result.turn = std::max(result.turn, turned());
            const bool isWithin =
                result.slip <= protocol.heldWay && result.turn <= protocol.heldTurn;
            if (!isWithin && result.reason.empty())
            {
                result.reason = fmt::format("first in phase {}, after {:.3g} s",
                                            &phase - protocol.phases.data() + 1,
                                            time - began);
            }
            if (!(way() <= protocol.lostWay))
            {
                result.outcome = TrialOutcome::Dropped;
            }
        }
    }
    if (result.outcome == TrialOutcome::Held && !result.reason.empty())
    {
        result.outcome = TrialOutcome::Slipped;
    }
    return result;
}
}  // namespace bullet_ccd::reference
