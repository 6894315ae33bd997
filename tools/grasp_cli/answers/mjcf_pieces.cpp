#include "tools/grasp_cli/answers/mjcf_pieces.h"

#include <algorithm>
#include <tbb/parallel_for.h>

namespace bullet_ccd::tools
{
namespace
{
constexpr std::size_t kLinkShare = 4;  // pieces of the object for one of a link
}  // namespace

grasp::MjcfPieces piecesOf(const grasp::HandModel& hand,
                           const grasp::GraspObject& object,
                           const ConvexPiecesOptions& options)
{
    grasp::MjcfPieces pieces;
    pieces.links.resize(hand.linkTrees.size());
    const ConvexPiecesOptions ofLinks{.accuracy = options.accuracy,
                                      .most = std::max(std::size_t{1}, options.most / kLinkShare)};
    tbb::parallel_for(std::size_t{0},
                      pieces.links.size() + 1,
                      [&](std::size_t i)
                      {
                          if (i == pieces.links.size())
                          {
                              pieces.object = convexPieces(object.tree.mesh(), options);
                          }
                          else if (hand.linkTrees[i] != nullptr)
                          {
                              pieces.links[i] = convexPieces(hand.linkTrees[i]->mesh(), ofLinks);
                          }
                      });
    return pieces;
}
}  // namespace bullet_ccd::tools
