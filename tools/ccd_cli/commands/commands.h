/// The verbs of the program `bullet-ccd`. Each adds itself to the command line and runs when it is
/// chosen; errors in the input come out as exceptions. Those that may take long leave their exit
/// code.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/toi/toi.h"

#include <CLI/CLI.hpp>
#include <string>

namespace bullet_ccd::tools
{
void addToiCommand(CLI::App& app, int& exitCode);
void addBatchCommand(CLI::App& app, int& exitCode);
void addArticulatedCommand(CLI::App& app, int& exitCode);
void addCertifyCommand(CLI::App& app, int& exitCode);
void addDeformableCommand(CLI::App& app, int& exitCode);
void addElementaryCommand(CLI::App& app, int& exitCode);
void addReduceCommand(CLI::App& app, int& exitCode);
void addAdviseCommand(CLI::App& app, int& exitCode);
void addManifestCommand(CLI::App& app, int& exitCode);

/// The meshes A and B.
void addMeshes(CLI::App& command, std::string& fileA, std::string& fileB);

/// Options that all verbs share: tolerance and minimum separation.
void addDistanceOptions(CLI::App& command, double& tolerance, double& minimumSeparation);

/// --decide and --exact, of the verbs for features that deform.
void addDepthOptions(CLI::App& command, ElementaryDepth& depth);

/// Options that the verbs for rigid bodies and robots share: tolerance, minimum separation,
/// accuracy, strategy, iteration limit.
void addToiOptions(CLI::App& command, ToiOptions& options);

/// Throws std::invalid_argument, with the smallest accuracy, if less than that was asked for on
/// this mesh.
void checkAccuracy(const ToiOptions& options, const TriangleMesh& mesh);
}  // namespace bullet_ccd::tools
