#include "grasp/formats/grasp_file.h"

#include "grasp/formats/grasp_recorder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
using Json = nlohmann::ordered_json;

/// The file and line that an error is about.
struct Place
{
    const std::filesystem::path& file;
    int line = 0;
};

[[noreturn]] void fail(const Place& place, const std::string& what)
{
    throw std::runtime_error(place.file.string() + ":" + std::to_string(place.line) + ": " + what);
}

const Json& member(const Json& json, const char* key, const Place& place)
{
    if (!json.is_object() || !json.contains(key))
    {
        fail(place,
             std::string("key \"") + key +
                 "\" is missing: the line is cut off or was not written by grasp plan");
    }
    return json.at(key);
}

template <typename T>
T value(const Json& json, const char* key, const Place& place)
{
    const Json& found = member(json, key, place);
    try
    {
        return found.get<T>();
    }
    catch (const Json::exception&)
    {
        fail(place,
             std::string("key \"") + key + "\": unexpected value " + found.dump().substr(0, 60) +
                 ": correct it or plan again");
    }
}

double positive(const Json& json, const char* key, const Place& place)
{
    const auto number = value<double>(json, key, place);
    if (!(number > 0.0))
    {
        fail(place,
             std::string("key \"") + key + "\": " + json.at(key).dump() +
                 " is not above 0: correct it or plan again");
    }
    return number;
}

template <int Size>
Eigen::Matrix<double, Size, 1> vector(const Json& json, const char* key, const Place& place)
{
    const auto numbers = value<std::vector<double>>(json, key, place);
    if (numbers.size() != static_cast<std::size_t>(Size))
    {
        fail(place,
             std::string("key \"") + key + "\": " + std::to_string(numbers.size()) +
                 " numbers where " + std::to_string(Size) + " are needed: correct it");
    }
    return Eigen::Map<const Eigen::Matrix<double, Size, 1>>(numbers.data());
}

Eigen::Isometry3d pose(const Json& json, const char* key, const Place& place)
{
    const Json& found = member(json, key, place);
    const Eigen::Vector4d q = vector<4>(found, "quaternion_wxyz", place);
    if (std::abs(q.norm() - 1.0) > 1e-6)
    {
        fail(place,
             std::string("key \"") + key + "\": the quaternion has length " +
                 std::to_string(q.norm()) + ": it must be 1");
    }
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    X.translation() = vector<3>(found, "position_m", place);
    if (found.contains(kRotationKey))
    {
        using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
        const Eigen::Matrix<double, 9, 1> rows = vector<9>(found, kRotationKey, place);
        const Eigen::Matrix3d R = Eigen::Map<const Rows>(rows.data());
        if (!R.isApprox(X.linear(), 1e-6))
        {
            fail(place,
                 std::string("key \"") + key +
                     "\": its matrix and its quaternion differ: remove the matrix");
        }
        X.linear() = R;
    }
    return X;
}

RejectReason rejectReason(const Json& json, const Place& place)
{
    if (member(json, "reject", place).is_null())
    {
        return RejectReason::None;
    }
    const auto name = value<std::string>(json, "reject", place);
    for (int k = 0; k <= static_cast<int>(RejectReason::OutOfReach); ++k)
    {
        if (name == toString(static_cast<RejectReason>(k)))
        {
            return static_cast<RejectReason>(k);
        }
    }
    fail(place, "key \"reject\": unknown reason \"" + name + "\": read it with a newer version");
}

std::int32_t linkIndex(const Json& json, const HandModel& hand, const Place& place)
{
    const auto name = value<std::string>(json, "link", place);
    const std::int32_t link = hand.robot.tree.findLink(name);
    if (link == kNone)
    {
        fail(place,
             "link \"" + name + "\" is not a link of " + hand.robot.name +
                 ": read the file with the hand that it was written for");
    }
    return link;
}

std::vector<double> positionsFrom(const Json& joints, const HandModel& hand, const Place& place)
{
    const KinematicTree& tree = hand.robot.tree;
    std::vector<double> positions(tree.size(), 0.0);
    for (std::size_t link = 1; link < tree.size(); ++link)
    {
        if (tree.links[link].joint.isMovable())
        {
            positions[link] = value<double>(joints, tree.links[link].joint.name.c_str(), place);
        }
    }
    return positions;
}

ApproachOptions samplingFrom(const Json& plan, const Place& place)
{
    ApproachOptions options;
    // Files of versions that knew one source alone do not say so.
    if (!plan.contains("approach"))
    {
        return options;
    }
    const Json& json = plan.at("approach");
    const auto name = value<std::string>(json, "from", place);
    constexpr std::array kSources{ApproachSource::Sphere,
                                  ApproachSource::Surface,
                                  ApproachSource::Boxes,
                                  ApproachSource::Pinch,
                                  ApproachSource::Mixed};
    const auto* const source = std::find_if(
        kSources.begin(), kSources.end(), [&](ApproachSource s) { return name == toString(s); });
    if (source == kSources.end())
    {
        fail(place, "key \"from\": unknown source \"" + name + "\": read it with a newer version");
    }
    options.source = *source;
    options.tableTop = value<bool>(json, "table_top", place);
    options.up = vector<3>(json, "up", place);
    options.maxTilt = value<double>(json, "max_tilt_rad", place);
    options.standoff = value<double>(json, "standoff_m", place);
    options.reach = value<double>(json, "reach_m", place);
    if (!member(json, "roll_rad", place).is_null())
    {
        const Eigen::Vector2d roll = vector<2>(json, "roll_rad", place);
        options.roll = RollLimits{.from = roll[0], .to = roll[1]};
    }
    return options;
}

GraspFileSource sourceFrom(const Json& json, const Place& place)
{
    const Json& hand = member(json, "hand", place);
    const Json& object = member(json, "object", place);
    const Json& plan = member(json, "plan", place);
    const Json& quality = member(json, "quality", place);
    GraspFileSource source;
    source.run.handFile = value<std::string>(hand, "urdf", place);
    if (!member(hand, "srdf", place).is_null())
    {
        source.run.srdfFile = value<std::string>(hand, "srdf", place);
    }
    source.run.objectFile = value<std::string>(object, "file", place);
    source.run.objectScale = positive(object, "scale", place);
    PlannerOptions& options = source.run.options;
    options.seed = value<std::uint64_t>(plan, "seed", place);
    options.candidates = value<std::int64_t>(plan, "candidates", place);
    options.approach = samplingFrom(plan, place);
    // Files of versions that only simulated do not say so.
    options.engine = plan.value("closing_engine", "simulated") == std::string("kinematic")
                         ? ClosingEngine::Kinematic
                         : ClosingEngine::Simulated;
    // Nor do those of versions that closed all fingers together, and did not keep the obstacles.
    if (plan.contains("closing_order"))
    {
        options.closing.order =
            value<std::string>(plan, "closing_order", place) == toString(ClosingOrder::OneByOne)
                ? ClosingOrder::OneByOne
                : ClosingOrder::Together;
        options.closing.firstFingers =
            value<std::vector<std::string>>(plan, "first_fingers", place);
    }
    if (plan.contains("closing_speeds"))
    {
        options.closing.speeds =
            value<std::vector<std::pair<std::string, double>>>(plan, "closing_speeds", place);
    }
    if (plan.contains("obstacles_hash") && !plan.at("obstacles_hash").is_null())
    {
        source.run.obstaclesHash = value<std::string>(plan, "obstacles_hash", place);
    }
    if (plan.contains("robot") && !plan.at("robot").is_null())
    {
        source.run.robot = value<std::string>(plan, "robot", place);
    }
    options.closing.tolerance = value<double>(plan, "tolerance_m", place);
    options.closing.contactThreshold = value<double>(plan, "contact_threshold_m", place);
    options.minContactSpacing = value<double>(plan, "min_contact_spacing_m", place);
    options.forceClosureThreshold = value<double>(plan, "force_closure_threshold", place);
    // Older files lack the mass, or what it follows from; then it was given. What follows from the
    // object follows from it again.
    if (plan.contains("mass_kg") && plan.value("mass_from", "given") == std::string("given"))
    {
        options.mass = positive(plan, "mass_kg", place);
    }
    options.friction = positive(quality, "friction", place);
    options.coneEdges = value<int>(quality, "cone_edges", place);
    source.handHash = value<std::string>(hand, "content_hash", place);
    source.objectHash = value<std::string>(object, "content_hash", place);
    source.version = json.contains("versions") ? json.at("versions").value("bullet_ccd", "") : "";
    return source;
}

Grasp graspFrom(const Json& json, const HandModel& hand, const Place& place)
{
    Grasp grasp;
    grasp.candidate = value<std::int64_t>(json, "candidate", place);
    grasp.reject = rejectReason(json, place);
    grasp.preshape = value<std::string>(json, "preshape", place);
    const Json& approach = member(json, "approach", place);
    grasp.X_WStart = pose(approach, "start_pose_in_object", place);
    grasp.approach_W = vector<3>(approach, "direction", place);
    if (approach.contains("from") && !approach.at("from").is_null())  // older files do not have it
    {
        grasp.source = value<std::string>(approach, "from", place);
    }
    grasp.approachDistance = value<double>(approach, "travel_to_contact_m", place);
    if (approach.contains("obstacles_in_reach"))  // older files do not have it
    {
        grasp.obstaclesInReach = value<std::int64_t>(approach, "obstacles_in_reach", place);
    }
    if (!member(json, "hand_pose_in_object", place).is_null())
    {
        grasp.X_WH = pose(json, "hand_pose_in_object", place);
        grasp.positions = positionsFrom(member(json, "joints", place), hand, place);
    }
    for (const Json& contact : member(json, "contacts", place))
    {
        grasp.contacts.push_back({.link = linkIndex(contact, hand, place),
                                  .point = vector<3>(contact, "point_m", place),
                                  .normal = vector<3>(contact, "normal_into_object", place),
                                  .gap = value<double>(contact, "gap_m", place)});
    }
    for (const Json& stop : member(json, "stops", place))
    {
        grasp.stops.push_back({.link = linkIndex(stop, hand, place),
                               .time = value<double>(stop, "time_s", place),
                               .byObject = value<std::string>(stop, "by", place) == "object"});
    }
    const Json& quality = member(json, "quality", place);
    grasp.quality.epsilon = value<double>(quality, "epsilon", place);
    if (!member(quality, "volume", place).is_null())
    {
        grasp.quality.volume = value<double>(quality, "volume", place);
    }
    grasp.quality.forceClosure = value<bool>(quality, "force_closure", place);
    if (quality.contains("weight") && !quality.at("weight").is_null())  // older files lack it
    {
        const Json& weight = quality.at("weight");
        grasp.quality.largestMass = member(weight, "largest_mass_kg", place).is_null()
                                        ? std::numeric_limits<double>::infinity()
                                        : value<double>(weight, "largest_mass_kg", place);
    }
    return grasp;
}

/// The line for a record of a journal, which has no rank.
int rankFrom(const Json& json, const Place& place)
{
    if (!json.contains("rank") || json.at("rank").is_null())
    {
        return place.line;
    }
    const int rank = value<int>(json, "rank", place);
    if (rank < 1)
    {
        fail(place, "key \"rank\": " + std::to_string(rank) + ": ranks begin with 1: correct it");
    }
    return rank;
}

/// Fails for a line that is no JSON from its character `at` on: NaN and such have a key.
[[noreturn]] void failAt(const std::string& line, std::size_t at, const Place& place)
{
    constexpr const char* kBeside = " \t,:[]{}\"";
    const std::size_t begin = at == 0 ? 0 : line.find_last_of(kBeside, at) + 1;
    const std::size_t colon = line.rfind("\":", begin);
    if (at < line.size() && begin <= at && colon != std::string::npos && colon > 0)
    {
        const std::size_t key = line.rfind('"', colon - 1) + 1;
        const std::string word = line.substr(begin, line.find_first_of(kBeside, at) - begin);
        fail(place,
             "key \"" + line.substr(key, colon - key) + "\": unexpected value " +
                 word.substr(0, 60) + ": correct it or plan again");
    }
    fail(place, "not a JSON record: the line is damaged or cut off; plan again");
}

Json recordFrom(const std::string& line, const Place& place)
{
    Json json;
    try
    {
        json = Json::parse(line);
    }
    catch (const Json::parse_error& error)
    {
        failAt(line, error.byte - 1, place);
    }
    catch (const Json::out_of_range&)  // 1e999
    {
        fail(place, "a number is too large: correct it or plan again");
    }
    const auto schema = value<std::string>(json, "schema", place);
    if (schema != kGraspSchema)
    {
        fail(place,
             "schema \"" + schema + "\" is not known: this version reads \"" + kGraspSchema + "\"");
    }
    return json;
}

/// Calls `record(json, place)` for every line that is not blank, until it returns false.
/// @param damaged  not null: an error goes there, and the next line is read
void forEachRecord(const std::filesystem::path& path,
                   const std::function<bool(const Json&, const Place&)>& record,
                   std::vector<std::string>* damaged = nullptr)
{
    std::ifstream in(path);
    if (!in || std::filesystem::is_directory(path))
    {
        throw std::runtime_error(path.string() +
                                 ": cannot be opened: give a file that grasp plan wrote");
    }
    std::string line;
    for (int number = 1; std::getline(in, line); ++number)
    {
        if (line.find_first_not_of(" \t\r") == std::string::npos)
        {
            continue;
        }
        const Place place{.file = path, .line = number};
        try
        {
            if (!record(recordFrom(line, place), place))
            {
                return;
            }
        }
        catch (const std::runtime_error& error)
        {
            if (damaged == nullptr)
            {
                throw;
            }
            damaged->emplace_back(error.what());
        }
    }
}
}  // namespace

Grasp asRecorded(Grasp grasp)
{
    for (Eigen::Isometry3d* const X : {&grasp.X_WH, &grasp.X_WStart})
    {
        // As the recorder writes it, and as it is read.
        const Eigen::Quaterniond written = Eigen::Quaterniond(X->linear()).normalized();
        X->linear() = written.normalized().toRotationMatrix();
    }
    return grasp;
}

void writeGrasps(std::ostream& out,
                 const GraspRun& run,
                 const HandModel& hand,
                 const GraspObject& object,
                 std::span<const Grasp> grasps)
{
    const GraspRecorder recorder(run, hand, object);
    int rank = 1;
    for (const Grasp& grasp : grasps)
    {
        out << recorder.ranked(grasp, rank++) << '\n';
    }
}

GraspFileSource readGraspSource(const std::filesystem::path& path, bool skipDamaged)
{
    std::optional<GraspFileSource> source;
    std::vector<std::string> damaged;
    forEachRecord(
        path,
        [&](const Json& json, const Place& place)
        {
            source = sourceFrom(json, place);
            return false;
        },
        skipDamaged ? &damaged : nullptr);
    if (!source && !damaged.empty())
    {
        throw std::runtime_error(damaged.front());
    }
    if (!source)
    {
        throw std::runtime_error(path.string() + ":1: no records: plan grasps first");
    }
    return *source;
}

std::vector<Grasp> readGrasps(const std::filesystem::path& path,
                              const HandModel& hand,
                              std::vector<std::string>* damaged,
                              std::vector<int>* ranks)
{
    std::vector<Grasp> grasps;
    std::map<int, int> lines;  // of ranks
    std::optional<GraspFileSource> first;
    forEachRecord(
        path,
        [&](const Json& json, const Place& place)
        {
            const GraspFileSource source = sourceFrom(json, place);
            first = first ? first : source;
            if (source.handHash != first->handHash || source.objectHash != first->objectHash)
            {
                fail(place,
                     "another hand or object than in the first line: keep one file for "
                     "each pair");
            }
            Grasp grasp = graspFrom(json, hand, place);
            if (ranks != nullptr)
            {
                const int rank = rankFrom(json, place);
                const auto [other, isNew] = lines.emplace(rank, place.line);
                if (!isNew)
                {
                    fail(place,
                         "key \"rank\": " + std::to_string(rank) + " is that of line " +
                             std::to_string(other->second) + ", too: correct one of them");
                }
                ranks->push_back(rank);
            }
            grasps.push_back(std::move(grasp));
            return true;
        },
        damaged);
    return grasps;
}

Grasp readGrasp(const std::string& record, const HandModel& hand)
{
    const std::filesystem::path file = "record";
    const Place place{.file = file, .line = 1};
    return graspFrom(recordFrom(record, place), hand, place);
}

std::vector<Preshape> readPreshapes(const std::filesystem::path& path, const HandModel& hand)
{
    std::vector<Preshape> preshapes;
    forEachRecord(
        path,
        [&](const Json& json, const Place& place)
        {
            const auto name = value<std::string>(json, "preshape", place);
            const bool known = std::any_of(preshapes.begin(),
                                           preshapes.end(),
                                           [&](const Preshape& p) { return p.name == name; });
            // Records of earlier versions have no positions.
            if (!known && json.contains("preshape_joints") && !json.at("preshape_joints").is_null())
            {
                preshapes.push_back(
                    {.name = name,
                     .positions = positionsFrom(json.at("preshape_joints"), hand, place)});
            }
            return true;
        });
    return preshapes;
}
}  // namespace bullet_ccd::grasp
