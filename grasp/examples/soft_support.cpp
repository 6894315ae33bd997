#include "grasp/examples/soft_support.h"

#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>

namespace bullet_ccd::grasp::examples
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace
{
using Corners = std::array<Vector3d, 3>;

bool segmentCrosses(const Vector3d& p, const Vector3d& q, const Corners& t)
{
    const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
    const double before = normal.dot(p - t[0]);
    const double after = normal.dot(q - t[0]);
    if (!(before * after < 0.0))
    {
        return false;
    }
    const Vector3d x = p + before / (before - after) * (q - p);
    return normal.dot((t[1] - t[0]).cross(x - t[0])) >= 0.0 &&
           normal.dot((t[2] - t[1]).cross(x - t[1])) >= 0.0 &&
           normal.dot((t[0] - t[2]).cross(x - t[2])) >= 0.0;
}
}  // namespace

btVector3 vec(double x, double y, double z)
{
    return {btScalar(x), btScalar(y), btScalar(z)};
}

btSoftBody* makeVolume(btSoftBodyWorldInfo& info,
                       double cell,
                       int size,
                       const std::function<double(const Vector3d&)>& distance)
{
    std::map<std::array<int, 3>, int> nodes;
    std::vector<std::array<int, 4>> tetras;
    std::map<int, int> cubes;  // that a node is a corner of
    const int half = size / 2;
    const auto placeOf = [&](const std::array<int, 3>& i)
    { return Vector3d(cell * Vector3d(i[0] - half, i[1] - half, i[2])); };
    for (int i = 0; i < size * size * size; ++i)
    {
        const std::array<int, 3> at{i % size, i / size % size, i / (size * size)};
        if (distance(placeOf(at) + Vector3d::Constant(0.5 * cell)) > 0.0)
        {
            continue;
        }
        std::array<int, 8> corner{};
        for (int k = 0; k < 8; ++k)
        {
            const std::array<int, 3> c{at[0] + (k & 1), at[1] + (k >> 1 & 1), at[2] + (k >> 2)};
            corner[std::size_t(k)] = nodes.try_emplace(c, int(nodes.size())).first->second;
            ++cubes[corner[std::size_t(k)]];
        }
        // Cubes alternate, so that the diagonals of neighbours are the same.
        const int flip = (at[0] + at[1] + at[2]) % 2 == 0 ? 0 : 1;
        for (const std::array<int, 4>& t : {std::array{0, 1, 2, 4},
                                            std::array{3, 1, 2, 7},
                                            std::array{5, 1, 4, 7},
                                            std::array{6, 2, 4, 7},
                                            std::array{1, 2, 4, 7}})
        {
            tetras.push_back({corner[std::size_t(t[0] ^ flip)],
                              corner[std::size_t(t[1] ^ flip)],
                              corner[std::size_t(t[2] ^ flip)],
                              corner[std::size_t(t[3] ^ flip)]});
        }
    }
    std::vector<btVector3> places(nodes.size());
    for (const auto& [at, index] : nodes)
    {
        Vector3d x = placeOf(at);
        for (int i = 0; i < 4 && cubes.at(index) < 8; ++i)
        {
            // Along the gradient, but not by so much that a tetrahedron turns over.
            Vector3d gradient;
            for (int k = 0; k < 3; ++k)
            {
                const Vector3d step = 1e-4 * Vector3d::Unit(k);
                gradient[k] = (distance(x + step) - distance(x - step)) / 2e-4;
            }
            const double way = std::clamp(-0.5 * distance(x), -0.1 * cell, 0.1 * cell);
            x += way * gradient.stableNormalized();
        }
        x.z() = std::max(x.z(), 0.0) + 1e-3;
        places[std::size_t(index)] = btCcdToBullet(x);
    }
    const std::vector<btScalar> masses(places.size(), btScalar(1));
    auto* body = new btSoftBody(&info, int(places.size()), places.data(), masses.data());
    for (const std::array<int, 4>& t : tetras)
    {
        body->appendTetra(t[0], t[1], t[2], t[3]);
        for (std::size_t a = 0; a < 4; ++a)
        {
            for (std::size_t b = 0; b < a; ++b)
            {
                body->appendLink(t[a], t[b], nullptr, true);
            }
        }
    }
    btSoftBodyHelpers::generateBoundaryFaces(body);
    body->initializeDmInverse();
    body->m_tetraScratches.resize(body->m_tetras.size());
    body->m_tetraScratchesTn.resize(body->m_tetras.size());
    return body;
}

TriangleMesh meshOf(const btSoftBody& body)
{
    TriangleMesh mesh;
    for (int i = 0; i < body.m_nodes.size(); ++i)
    {
        mesh.vertices.push_back(btCcdToEigen(body.m_nodes[i].m_x));
    }
    for (int i = 0; i < body.m_faces.size(); ++i)
    {
        Triangle t{};
        for (std::size_t k = 0; k < 3; ++k)
        {
            t[k] = std::int32_t(body.m_faces[i].m_n[int(k)] - &body.m_nodes[0]);
        }
        mesh.triangles.push_back(t);
    }
    return mesh;
}

std::vector<BoxedFace> facesNear(const TriangleMesh& mesh,
                                 const Isometry3d& X,
                                 const Eigen::AlignedBox3d& box)
{
    std::vector<BoxedFace> faces;
    for (const Triangle& t : mesh.triangles)
    {
        BoxedFace face;
        for (std::size_t k = 0; k < 3; ++k)
        {
            face.m_corners[k] = X * mesh.vertices[std::size_t(t[k])];
            face.m_box.extend(face.m_corners[k]);
        }
        if (face.m_box.intersects(box))
        {
            faces.push_back(face);
        }
    }
    return faces;
}

int crossings(const std::vector<BoxedFace>& a, const std::vector<BoxedFace>& b)
{
    int count = 0;
    for (const BoxedFace& face : a)
    {
        for (const BoxedFace& other : b)
        {
            if (!face.m_box.intersects(other.m_box))
            {
                continue;
            }
            const bool areNeighbours = std::ranges::any_of(
                face.m_corners,
                [&](const Vector3d& x)
                { return std::ranges::find(other.m_corners, x) != other.m_corners.end(); });
            for (std::size_t k = 0; k < 3 && !areNeighbours; ++k)
            {
                count +=
                    segmentCrosses(face.m_corners[k], face.m_corners[(k + 1) % 3], other.m_corners)
                        ? 1
                        : 0;
            }
        }
    }
    return count;
}

Canvas drawScene(const Camera& camera, const std::vector<Drawn>& scene)
{
    Layer layer(camera.width, camera.height);
    for (const Drawn& drawn : scene)
    {
        Shape shape = makeShape(drawn.m_mesh, drawn.X_W);
        shape.color = drawn.m_color;
        shape.id = 1;
        drawShape(layer, camera, shape);
    }
    Canvas canvas(camera.width, camera.height);
    for (std::size_t i = 0; i < layer.id.size(); ++i)
    {
        canvas.pixels[i] = layer.id[i] != kNone ? layer.color[i] : Color(0.97F, 0.97F, 0.98F);
    }
    return canvas;
}

void writeStrip(const std::vector<Canvas>& pictures, const std::filesystem::path& file)
{
    const Canvas& first = pictures.front();
    Canvas strip(first.width / 2 * int(pictures.size()), first.height / 2);
    int left = 0;
    for (const Canvas& canvas : pictures)
    {
        shrinkInto(strip, left, canvas);
        left += canvas.width / 2;
    }
    writePng(strip, file);
}

int runScenes(const std::string& program,
              const std::vector<NamedScene>& scenes,
              int count,
              char** words)
{
    const auto listed = [&](const char* between)
    {
        std::string text;
        for (const NamedScene& scene : scenes)
        {
            text += (text.empty() ? "" : between) + scene.m_name;
        }
        return text;
    };
    if (count < 2 || words[1][0] == '-')
    {
        std::fprintf(stderr, "%s FOLDER [%s ...]\n", program.c_str(), listed("|").c_str());
        return count < 2 ? 2 : 0;
    }
    const std::vector<std::string> wanted(words + 2, words + count);
    for (const std::string& name : wanted)
    {
        if (std::ranges::find(scenes, name, &NamedScene::m_name) == scenes.end())
        {
            std::fprintf(stderr,
                         "%s: %s: no such scene: %s\n",
                         program.c_str(),
                         name.c_str(),
                         listed(", ").c_str());
            return 2;
        }
    }
    try
    {
        std::filesystem::create_directories(words[1]);
        bool isRight = true;
        for (const NamedScene& scene : scenes)
        {
            if (wanted.empty() || std::ranges::find(wanted, scene.m_name) != wanted.end())
            {
                isRight = scene.m_run(words[1]) && isRight;
            }
        }
        return isRight ? 0 : 1;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "%s: %s\n", program.c_str(), error.what());
        return 3;
    }
}
}  // namespace bullet_ccd::grasp::examples
