#include "tools/grasp_cli/answers/mjcf_pieces.h"

#include <algorithm>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

namespace bullet_ccd::tools
{
namespace
{
constexpr std::size_t kLinkShare = 4;  // pieces of the object for one of a link

std::vector<ConvexPieces> handPieces(const grasp::HandModel& hand,
                                     const ConvexPiecesOptions& options)
{
    std::vector<ConvexPieces> links(hand.linkTrees.size());
    const ConvexPiecesOptions ofLinks{.accuracy = options.accuracy,
                                      .most = std::max(std::size_t{1}, options.most / kLinkShare)};
    tbb::parallel_for(std::size_t{0},
                      links.size(),
                      [&](std::size_t i)
                      {
                          if (hand.linkTrees[i] != nullptr)
                          {
                              links[i] = convexPieces(hand.linkTrees[i]->mesh(), ofLinks);
                          }
                      });
    return links;
}

/// What is kept, or else made, outside of the lock: it may run other tasks that want it.
template <typename Made, typename Make>
Made kept(std::map<std::filesystem::path, Made>& all,
          std::mutex& mutex,
          const std::filesystem::path& key,
          const Make& make)
{
    {
        const std::scoped_lock lock(mutex);
        if (const auto found = all.find(key); found != all.end())
        {
            return found->second;
        }
    }
    const Made made = make();
    const std::scoped_lock lock(mutex);
    return all.try_emplace(key, made).first->second;
}
}  // namespace

grasp::MjcfPieces piecesOf(const grasp::HandModel& hand,
                           const grasp::GraspObject& object,
                           const ConvexPiecesOptions& options)
{
    grasp::MjcfPieces pieces;
    tbb::parallel_invoke([&] { pieces.object = convexPieces(object.tree.mesh(), options); },
                         [&] { pieces.links = handPieces(hand, options); });
    return pieces;
}

grasp::MjcfPieces PieceStore::of(const LoadedHand& hand, const LoadedObject& object)
{
    return {.links =
                kept(m_hands, m_mutex, hand.file, [&] { return handPieces(hand.hand, m_options); }),
            .object = kept(m_objects,
                           m_mutex,
                           object.file,
                           [&] { return convexPieces(object.object.tree.mesh(), m_options); })};
}
}  // namespace bullet_ccd::tools
