#include "robots/shapes/household_objects.h"

#include "bullet_ccd/math/pose.h"
#include "robots/shapes/polygonize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

namespace bullet_ccd::shapes
{
namespace
{
constexpr double kPi = std::numbers::pi;

/// Sizes of one object: the usual ones, or drawn evenly from their ranges.
class Sizes
{
public:
    explicit Sizes(std::optional<std::uint64_t> seed)
    {
        if (seed)
        {
            m_random.emplace(*seed);
        }
    }

    double between(double low, double usual, double high)
    {
        if (!m_random)
        {
            return usual;
        }
        // By hand: the distributions of the standard library may differ between platforms.
        const double share = static_cast<double>((*m_random)() >> 11) * 0x1.0p-53;
        return low + share * (high - low);
    }

private:
    std::optional<std::mt19937_64> m_random;
};

/// What a family makes.
struct Recipe
{
    Solid solid;
    PolygonizeOptions options = {};
};

/// Vessels have much surface, and rims that need many triangles.
constexpr PolygonizeOptions kVessel = {
    .cell = 2.0e-3, .chordError = 2.5e-4, .shortestEdge = 2.8e-3, .longestEdge = 1.5e-2};

/// Small enough for rims that look round.
constexpr PolygonizeOptions kSmallVessel = {
    .cell = 1.6e-3, .chordError = 1.0e-4, .shortestEdge = 1.6e-3, .longestEdge = 1.5e-2};

Eigen::Isometry3d turnedTo(const Eigen::Vector3d& direction)
{
    return Eigen::Isometry3d(rotationBetween(Eigen::Vector3d::UnitZ(), direction));
}

Solid along(const Eigen::Vector3d& direction, const Solid& solid)
{
    return placed(solid, turnedTo(direction));
}

/// Half ring in the xz plane that leaves a wall at (x, z +- half) and reaches out to x + depth.
Solid handleRing(double x, double z, double depth, double half, double radius)
{
    std::vector<TubePoint> points;
    constexpr int kPieces = 14;
    for (int i = 0; i <= kPieces; ++i)
    {
        const double angle = kPi * (static_cast<double>(i) / kPieces - 0.5);
        points.push_back({{x + depth * std::cos(angle), 0.0, z + half * std::sin(angle)}, radius});
    }
    return tube(points);
}

/// What a vessel of the given wall can hold; cutting it off keeps handles out of the vessel.
Solid hollowOf(Profile wallCurve, double wall)
{
    const Eigen::Vector2d above = wallCurve.back() + Eigen::Vector2d(0.0, 0.05);
    wallCurve.push_back(above);  // out of the vessel, so that its rim gets no ledge
    wallCurve.emplace_back(0.0, above.y());
    return lathe(wallCurve, -0.5 * wall);
}

Recipe mug(Sizes& sizes)
{
    const double radius = sizes.between(0.034, 0.040, 0.046);
    const double height = sizes.between(0.080, 0.095, 0.110);
    const double depth = sizes.between(0.026, 0.030, 0.034);
    const double grip = sizes.between(0.0050, 0.0058, 0.0070);
    constexpr double kWall = 0.0048;
    const Profile curve = smoothCurve(Profile{{0.0, 0.5 * kWall},
                                              {radius - 0.010, 0.5 * kWall},
                                              {radius - 0.003, 0.0055},
                                              {radius, 0.014},
                                              {radius, height - 0.5 * kWall}},
                                      5);
    const Solid handle = handleRing(radius - 0.002, 0.52 * height, depth, 0.33 * height, grip);
    return {cut(blend(latheShell(curve, kWall), handle, 0.003), hollowOf(curve, kWall)),
            kSmallVessel};
}

Recipe bottle(Sizes& sizes)
{
    const double radius = sizes.between(0.028, 0.034, 0.042);
    const double height = sizes.between(0.180, 0.220, 0.260);
    const double neck = sizes.between(0.011, 0.013, 0.016);
    const double shoulder = height - sizes.between(0.088, 0.090, 0.110);
    constexpr double kRound = 0.003;
    Profile curve = smoothCurve(Profile{{radius - kRound, shoulder},
                                        {radius - 0.007, shoulder + 0.018},
                                        {neck + 0.003, shoulder + 0.045},
                                        {neck - kRound, height - 0.035},
                                        {neck - kRound, height - 0.022}},
                                4);
    Profile profile = {{0.0, kRound}, {radius - kRound, kRound}};
    profile.insert(profile.end(), curve.begin(), curve.end());
    profile.insert(
        profile.end(),
        {{neck + 0.001, height - 0.022}, {neck + 0.001, height - kRound}, {0.0, height - kRound}});
    return {lathe(profile, kRound)};
}

Recipe bowl(Sizes& sizes)
{
    const double radius = sizes.between(0.055, 0.068, 0.085);
    const double height = sizes.between(0.045, 0.056, 0.070);
    constexpr double kWall = 0.0050;
    const double foot = 0.42 * radius;
    const Solid body = latheShell(smoothCurve(Profile{{0.0, 0.008},
                                                      {foot, 0.0095},
                                                      {0.80 * radius, 0.42 * height},
                                                      {radius, height - 0.5 * kWall}},
                                              7),
                                  kWall);
    const Solid ring = latheShell({{foot, 0.0025}, {foot, 0.0090}}, kWall);
    return {blend(body, ring, 0.002), kVessel};
}

Recipe can(Sizes& sizes)
{
    const double radius = sizes.between(0.030, 0.033, 0.042);
    const double height = sizes.between(0.080, 0.115, 0.130);
    Solid body = roundedCylinder(radius, 0.0, height, 0.0020);
    body = blendCut(body, roundedCylinder(radius - 0.005, height - 0.004, 1.0, 0.001), 0.001);
    body = blendCut(body, roundedCylinder(radius - 0.005, -1.0, 0.004, 0.001), 0.001);
    return {body};
}

Recipe box(Sizes& sizes)
{
    const Eigen::Vector3d half(sizes.between(0.018, 0.026, 0.035),
                               sizes.between(0.030, 0.045, 0.065),
                               sizes.between(0.035, 0.060, 0.100));
    return {roundedBox(half, 0.004), {.longestEdge = 1.0e-2}};
}

Recipe plate(Sizes& sizes)
{
    const double radius = sizes.between(0.080, 0.095, 0.125);
    const double height = sizes.between(0.018, 0.022, 0.028);
    constexpr double kWall = 0.0055;
    const double flat = 0.60 * radius;
    return {latheShell(smoothCurve(Profile{{0.0, 0.5 * kWall},
                                           {flat, 0.5 * kWall},
                                           {flat + 0.012, 0.007},
                                           {radius, height - 0.5 * kWall}},
                                   6),
                       kWall),
            kVessel};
}

Recipe glass(Sizes& sizes)
{
    const double bottom = sizes.between(0.024, 0.028, 0.032);
    const double top = bottom + sizes.between(0.003, 0.007, 0.012);
    const double height = sizes.between(0.095, 0.125, 0.150);
    constexpr double kWall = 0.0042;
    return {latheShell(smoothCurve(Profile{{0.0, 0.5 * kWall + 0.002},
                                           {bottom - 0.006, 0.5 * kWall + 0.002},
                                           {bottom, 0.007},
                                           {top, height - 0.5 * kWall}},
                                   5),
                       kWall),
            kSmallVessel};
}

/// Pulls the part of a vessel that lies towards -x outwards near its rim.
Solid withSpout(const Solid& vessel, double radius, double height, double reach)
{
    const auto warp = [=](const Eigen::Vector3d& p)
    {
        const double up = std::clamp((p.z() / height - 0.65) / 0.35, 0.0, 1.3);
        const double across = p.y() / (0.45 * radius);
        const double side = std::clamp(-p.x() / radius, 0.0, 1.0);
        const double share = up * up * side * std::exp(-across * across);
        return Eigen::Vector3d(p + Eigen::Vector3d(reach * share, 0.0, 0.0));
    };
    return warped(vessel, warp, 1.6);
}

Recipe jug(Sizes& sizes)
{
    const double belly = sizes.between(0.044, 0.050, 0.058);
    const double height = sizes.between(0.140, 0.165, 0.190);
    const double throat = belly * sizes.between(0.68, 0.75, 0.82);
    constexpr double kWall = 0.0055;
    const Profile curve = smoothCurve(Profile{{0.0, 0.5 * kWall},
                                              {0.62 * belly, 0.5 * kWall},
                                              {0.75 * belly, 0.008},
                                              {belly, 0.36 * height},
                                              {throat, 0.78 * height},
                                              {throat + 0.005, height - 0.5 * kWall}},
                                      9);
    const Solid body = withSpout(latheShell(curve, kWall), throat, height, 0.016);
    const Solid ring = handleRing(throat - 0.002, 0.53 * height, 0.046, 0.30 * height, 0.0075);
    PolygonizeOptions options = kSmallVessel;
    options.chordError = 3.5e-4;
    options.shortestEdge = 3.2e-3;
    return {cut(blend(body, ring, 0.003), hollowOf(curve, kWall)), options};
}

Recipe wineGlass(Sizes& sizes)
{
    const double radius = sizes.between(0.030, 0.034, 0.040);
    const double height = sizes.between(0.150, 0.180, 0.210);
    const double stem = height * sizes.between(0.42, 0.48, 0.52);
    constexpr double kWall = 0.0040;
    const Solid cup = latheShell(smoothCurve(Profile{{0.0, stem},
                                                     {0.62 * radius, stem + 0.012},
                                                     {radius, 0.5 * (stem + height)},
                                                     {0.86 * radius, height - 0.5 * kWall}},
                                             6),
                                 kWall);
    const Solid foot = roundedCylinder(radius, 0.0, 0.0044, 0.0022);
    const Solid column = tube({{{0, 0, 0.003}, 0.0042}, {{0, 0, stem}, 0.0042}});
    return {blend(blend(cup, column, 0.005), foot, 0.005), kVessel};
}

Recipe pan(Sizes& sizes)
{
    const double radius = sizes.between(0.060, 0.070, 0.085);
    const double height = sizes.between(0.032, 0.040, 0.052);
    const double length = sizes.between(0.110, 0.130, 0.150);
    constexpr double kWall = 0.0050;
    const Profile curve = smoothCurve(Profile{{0.0, 0.5 * kWall},
                                              {radius - 0.014, 0.5 * kWall},
                                              {radius - 0.004, 0.008},
                                              {radius, height - 0.5 * kWall}},
                                      5);
    const double z = 0.75 * height;
    const Solid grip =
        tube(smoothCurve(std::vector<TubePoint>{{{radius, 0, z}, 0.0060},
                                                {{radius + 0.3 * length, 0, z + 0.006}, 0.0075},
                                                {{radius + 0.7 * length, 0, z + 0.012}, 0.0105},
                                                {{radius + length, 0, z + 0.012}, 0.0095}},
                         4));
    return {cut(blend(latheShell(curve, kWall), grip, 0.004), hollowOf(curve, kWall)), kVessel};
}

Recipe screwdriver(Sizes& sizes)
{
    const double radius = sizes.between(0.011, 0.014, 0.017);
    const double grip = sizes.between(0.085, 0.098, 0.115);
    const double shaft = sizes.between(0.070, 0.090, 0.120);
    const double rod = sizes.between(0.0030, 0.0036, 0.0045);
    constexpr double kRound = 0.003;
    const Solid plain = lathe(smoothCurve(Profile{{0.0, kRound},
                                                  {0.75 * radius - kRound, kRound + 0.002},
                                                  {radius - kRound, 0.018},
                                                  {radius - kRound, 0.60 * grip},
                                                  {0.60 * radius - kRound, 0.80 * grip},
                                                  {0.72 * radius - kRound, grip - 0.006},
                                                  {0.0, grip - kRound}},
                                          3),
                              kRound);
    const Solid handle = [=](const Eigen::Vector3d& p)
    {
        // Six flutes that fade out towards both ends.
        const double fade = std::clamp(std::min(p.z() - 0.010, 0.70 * grip - p.z()) / 0.02, 0., 1.);
        const double wave = 0.5 - 0.5 * std::cos(6.0 * std::atan2(p.y(), p.x()));
        return (plain(p) + 0.0016 * fade * wave) / 1.3;
    };
    const Solid rodSolid = tube({{{0, 0, 0.5 * grip}, rod}, {{0, 0, grip + shaft}, rod}});
    const Solid blade =
        moved(roundedBox({0.0014, 1.5 * rod, 0.012}, 0.0010), {0.0, 0.0, grip + shaft});
    const Solid whole = blend(blend(handle, rodSolid, 0.002), blade, 0.003);
    return {along({1, 0, 0}, whole),
            {.cell = 1.2e-3, .chordError = 1.2e-4, .shortestEdge = 1.5e-3}};
}

Recipe hammer(Sizes& sizes)
{
    const double length = sizes.between(0.200, 0.240, 0.280);
    const double grip = sizes.between(0.011, 0.0130, 0.0155);
    const double head = sizes.between(0.011, 0.0135, 0.0160);
    const double half = sizes.between(0.042, 0.050, 0.056);
    const Solid shaft =
        stretched(tube(smoothCurve(std::vector<TubePoint>{{{0, 0, grip}, 0.95 * grip},
                                                          {{0.25 * length, 0, grip}, grip},
                                                          {{0.6 * length, 0, grip}, 0.75 * grip},
                                                          {{length, 0, grip}, 0.75 * grip}},
                                   4)),
                  {1.0, 1.15, 1.0});
    const Eigen::Vector3d middle(length, 0.0, grip);
    const Solid face =
        moved(along({0, 1, 0}, roundedCylinder(head, -0.4 * half, half, 0.003)), middle);
    // The other end is a wedge that runs out across the handle.
    const Solid wedge = [=](const Eigen::Vector3d& p)
    {
        const Eigen::Vector3d q = p - middle;
        const double thickness =
            0.0025 + (head - 0.0025) * std::clamp(1.0 + q.y() / half, 0.0, 1.0);
        const Eigen::Vector3d scaled(q.x() * (head / thickness), q.y() + 0.5 * half, q.z());
        return roundedBox({head, 0.5 * half, head}, 0.002)(scaled) / (head / thickness + 1.0);
    };
    return {blend(blend(face, wedge, 0.002), shaft, 0.003)};
}

Recipe banana(Sizes& sizes)
{
    const double bend = sizes.between(0.100, 0.115, 0.140);
    const double span = sizes.between(1.25, 1.45, 1.65);
    const double thick = sizes.between(0.015, 0.0175, 0.020);
    std::vector<TubePoint> points;
    for (const auto& [share, radius] : std::array<std::pair<double, double>, 8>{{{0.0, 0.24},
                                                                                 {0.10, 0.26},
                                                                                 {0.20, 0.62},
                                                                                 {0.35, 0.94},
                                                                                 {0.55, 1.0},
                                                                                 {0.75, 0.90},
                                                                                 {0.92, 0.50},
                                                                                 {1.0, 0.24}}})
    {
        const double angle = span * (share - 0.5);
        points.push_back({{bend * std::sin(angle), -bend * std::cos(angle), 0.0}, thick * radius});
    }
    return {tube(smoothCurve(points, 8))};
}

Recipe brush(Sizes& sizes)
{
    const double length = sizes.between(0.120, 0.140, 0.170);
    const double width = sizes.between(0.020, 0.026, 0.032);
    const double grip = sizes.between(0.008, 0.0095, 0.012);
    const double bristles = sizes.between(0.016, 0.020, 0.026);
    const Solid handle =
        tube(smoothCurve(std::vector<TubePoint>{{{-length, 0, bristles}, grip},
                                                {{-0.6 * length, 0, bristles}, grip},
                                                {{-0.2 * length, 0, bristles}, 0.65 * grip},
                                                {{0, 0, bristles}, 0.75 * grip}},
                         4));
    const Solid back = moved(roundedBox({0.036, width, 0.007}, 0.006), {0.030, 0.0, bristles});
    const Solid tuft = moved(roundedBox({0.032, width - 0.004, 0.5 * bristles}, 0.003),
                             {0.030, 0.0, 0.5 * bristles});
    return {blend(blend(back, handle, 0.006), tuft, 0.001)};
}

Recipe soapDispenser(Sizes& sizes)
{
    const double radius = sizes.between(0.026, 0.031, 0.036);
    const double height = sizes.between(0.100, 0.120, 0.145);
    const double depth = sizes.between(0.75, 0.85, 1.0);
    const Solid body = stretched(roundedCylinder(radius, 0.0, height, 0.010), {1.0, depth, 1.0});
    const Solid collar = roundedCylinder(0.012, height - 0.004, height + 0.014, 0.002);
    const Solid rod = tube({{{0, 0, height}, 0.0045}, {{0, 0, height + 0.034}, 0.0045}});
    const Solid nozzle =
        tube(smoothCurve(std::vector<TubePoint>{{{-0.004, 0, height + 0.036}, 0.0075},
                                                {{0.012, 0, height + 0.037}, 0.0065},
                                                {{0.028, 0, height + 0.035}, 0.0050},
                                                {{0.034, 0, height + 0.030}, 0.0040}},
                         3));
    return {blend(blend(blend(body, collar, 0.002), rod, 0.002), nozzle, 0.002)};
}

Recipe playBall(Sizes& sizes)
{
    return {ball(sizes.between(0.025, 0.033, 0.045)), {.chordError = 0.5e-4}};
}

Recipe spoon(Sizes& sizes)
{
    const double length = sizes.between(0.150, 0.180, 0.210);
    const double width = sizes.between(0.022, 0.025, 0.030);
    const double grip = sizes.between(0.0045, 0.0055, 0.0065);
    const Eigen::Vector3d shape(1.4, 1.0, 0.50);
    const Solid outer = stretched(ball(width), shape);
    const Solid inner = moved(stretched(ball(width - 0.003), shape), {0.0, 0.0, 0.0045});
    const Solid lid = moved(roundedBox({0.2, 0.2, 0.2}, 0.0), {0.0, 0.0, 0.2});
    const Solid bowlPart = blendCut(blendCut(outer, lid, 0.0008), inner, 0.0008);
    const double start = 1.4 * width;
    const Solid handle =
        tube(smoothCurve(std::vector<TubePoint>{{{start - 0.003, 0, -0.004}, 0.0040},
                                                {{start + 0.25 * length, 0, 0.004}, 0.85 * grip},
                                                {{start + 0.7 * length, 0, 0.006}, grip},
                                                {{start + length, 0, 0.004}, 1.2 * grip}},
                         4));
    return {blend(bowlPart, handle, 0.003), {.cell = 1.2e-3, .shortestEdge = 1.6e-3}};
}

Recipe apple(Sizes& sizes)
{
    const double radius = sizes.between(0.032, 0.037, 0.043);
    const double squat = sizes.between(0.86, 0.92, 1.0);
    Profile profile;
    constexpr int kPieces = 36;
    for (int i = 0; i <= kPieces; ++i)
    {
        const double angle = kPi * (static_cast<double>(i) / kPieces - 0.5);
        const double c = std::cos(angle);
        // Dimples at both poles, the upper one deeper.
        const double dimple = (angle > 0.0 ? 0.36 : 0.22) * std::exp(-(c * c) / 0.10);
        profile.emplace_back(
            i == 0 || i == kPieces ? 0.0 : radius * c * (1.0 + 0.05 * std::sin(angle)),
            radius * squat * std::sin(angle) * (1.0 - dimple));
    }
    const double crown = 0.64 * radius * squat;
    const Solid stalk = tube({{{0, 0, crown - 0.006}, 0.0022},
                              {{0.002, 0, crown + 0.007}, 0.0022},
                              {{0.005, 0, crown + 0.017}, 0.0026}});
    return {blend(lathe(profile, 0.0), stalk, 0.002)};
}

Recipe flashlight(Sizes& sizes)
{
    const double radius = sizes.between(0.012, 0.0145, 0.018);
    const double length = sizes.between(0.095, 0.115, 0.140);
    const double lamp = radius + sizes.between(0.005, 0.008, 0.012);
    constexpr double kRound = 0.002;
    const double r = radius - kRound;
    const double l = lamp - kRound;
    const Profile profile = {{0.0, kRound},
                             {r, kRound},
                             {r, length},
                             {l, length + 0.016},
                             {l, length + 0.036},
                             {l - 0.003, length + 0.036},
                             {l - 0.006, length + 0.030},
                             {0.0, length + 0.030}};
    const Solid button =
        moved(roundedBox({0.0045, 0.0035, 0.009}, 0.002), {radius, 0.0, 0.62 * length});
    return {along({1, 0, 0}, blend(lathe(profile, kRound), button, 0.001))};
}

struct Family
{
    const char* name;
    Recipe (*make)(Sizes&);
};

constexpr std::array<Family, 19> kFamilies = {{{"mug", mug},
                                               {"bottle", bottle},
                                               {"bowl", bowl},
                                               {"can", can},
                                               {"box", box},
                                               {"plate", plate},
                                               {"glass", glass},
                                               {"jug", jug},
                                               {"screwdriver", screwdriver},
                                               {"hammer", hammer},
                                               {"banana", banana},
                                               {"brush", brush},
                                               {"soap_dispenser", soapDispenser},
                                               {"ball", playBall},
                                               {"spoon", spoon},
                                               {"wine_glass", wineGlass},
                                               {"pan", pan},
                                               {"apple", apple},
                                               {"flashlight", flashlight}}};

/// Puts the mesh on z = 0 with the middle of its bounds over the origin.
void settle(TriangleMesh& mesh)
{
    const Eigen::AlignedBox3d extent = bounds(mesh);
    const Eigen::Vector3d middle = extent.center();
    transformMesh(
        mesh, Eigen::Affine3d(Eigen::Translation3d(-middle.x(), -middle.y(), -extent.min().z())));
}
}  // namespace

const std::vector<std::string>& objectFamilies()
{
    static const std::vector<std::string> names = []
    {
        std::vector<std::string> result;
        for (const Family& family : kFamilies)
        {
            result.emplace_back(family.name);
        }
        return result;
    }();
    return names;
}

TriangleMesh makeObject(const std::string& family,
                        std::optional<std::uint64_t> seed,
                        double coarseness)
{
    if (!(coarseness >= 1.0))
    {
        throw std::invalid_argument("coarseness of objects is " + std::to_string(coarseness) +
                                    ": use 1 (as fine as usual) or more");
    }
    const auto found =
        std::ranges::find_if(kFamilies, [&](const Family& f) { return f.name == family; });
    if (found == kFamilies.end())
    {
        std::string known;
        for (const std::string& name : objectFamilies())
        {
            known += (known.empty() ? "" : ", ") + name;
        }
        throw std::invalid_argument("object family '" + family + "' is unknown: use one of " +
                                    known);
    }
    Sizes sizes(seed);
    Recipe recipe = found->make(sizes);
    recipe.options.chordError *= coarseness * coarseness;
    recipe.options.shortestEdge *= coarseness;
    recipe.options.longestEdge *= coarseness;
    // Wide enough for every object; empty space costs next to nothing.
    const Eigen::AlignedBox3d space(Eigen::Vector3d(-0.32, -0.2, -0.1),
                                    Eigen::Vector3d(0.32, 0.2, 0.32));
    TriangleMesh mesh = polygonize(recipe.solid, space, recipe.options);
    settle(mesh);
    return mesh;
}
}  // namespace bullet_ccd::shapes
