/// Scenes and methods of the chart of whole steps of a Bullet world.
#pragma once

#include "benchmarks/support/chart.h"

#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// Names of the scenes: volleys of bodies of 1 cm (rods: 6 cm) at a plate half a millimetre thick
/// or at a sheet of two triangles, 5 m/s and 2 m/s (spinning rods).
[[nodiscard]] const std::vector<std::string>& stepScenes();

/// Frames of 1/60 s by stock Bullet in several numbers of substeps, by its own continuous collision
/// detection, by our action and by our world. A query is a body, its time that of a frame of its
/// world.
///
/// The lowest point of a body must come down to the surface and no farther: the error is how deep
/// it was seen below it at the ends of steps and at impacts, or else how far it stayed from the
/// margins, within which meshes may rest [m]. Missed are bodies that went through, late those that
/// sank in by half: a ball of half the inner radius about the centre met the surface; false those
/// that were stopped more than 1.1 mm before.
/// @param volleys worlds of 25 bodies, each with other orientations and phases
[[nodiscard]] ChartScene makeStepScene(const std::string& name, int volleys);
}  // namespace bullet_ccd::benchmarks
