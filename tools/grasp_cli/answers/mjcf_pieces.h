/// A hand and an object in the pieces that MuJoCo collides.
#pragma once

#include "grasp/formats/mjcf_grasp_file.h"
#include "tools/grasp_cli/inputs/catalogue.h"

#include <filesystem>
#include <map>
#include <mutex>
#include <vector>

namespace bullet_ccd::tools
{
/// Cuts the object and every link that has geometry, on all cores. Hands have many links and
/// contacts of each are few, so a link gets a quarter of the pieces of the object, at the most.
[[nodiscard]] grasp::MjcfPieces piecesOf(const grasp::HandModel& hand,
                                         const grasp::GraspObject& object,
                                         const ConvexPiecesOptions& options);

/// Keeps the pieces of hands and objects, by their files. For many threads.
class PieceStore
{
public:
    explicit PieceStore(const ConvexPiecesOptions& options) : m_options(options) {}
    /// As piecesOf().
    [[nodiscard]] grasp::MjcfPieces of(const LoadedHand& hand, const LoadedObject& object);

private:
    ConvexPiecesOptions m_options;
    std::mutex m_mutex;
    std::map<std::filesystem::path, std::vector<ConvexPieces>> m_hands;
    std::map<std::filesystem::path, ConvexPieces> m_objects;
};
}  // namespace bullet_ccd::tools
