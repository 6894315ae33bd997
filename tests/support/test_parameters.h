/// Parameters of tests: all strategies, and names.
#pragma once

#include "benchmarks/reference/queries/soak_queries.h"

#include <gtest/gtest.h>

#include <string>

namespace bullet_ccd::tests
{
inline const auto kAllStrategies =
    testing::Values(ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A);

/// A name as a part of the name of a test, which has no dashes.
inline std::string withoutDashes(std::string name)
{
    std::erase(name, '-');
    return name;
}

inline std::string codeOf(ToiStrategy strategy)
{
    return withoutDashes(reference::nameOf(strategy));
}

/// The name of a test of one strategy.
inline std::string nameOfStrategy(const testing::TestParamInfo<ToiStrategy>& tested)
{
    return codeOf(tested.param);
}
}  // namespace bullet_ccd::tests
