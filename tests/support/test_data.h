/// Where tests find the real data that is not part of the project, and how much they do.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

namespace bullet_ccd::tests
{
/// `relative` under $BULLET_CCD_TEST_DATA (default: shared/data beside the checkout), if it exists.
[[nodiscard]] std::optional<std::filesystem::path> testData(const std::string& relative);

/// True if the environment has BULLET_CCD_LONG_TESTS, as tools/check --all sets it. What would take
/// seconds more than it finds is left to that run.
[[nodiscard]] bool longTests();
}  // namespace bullet_ccd::tests

/// Defines `name` as the path of test data, or skips the test and says why.
#define BULLET_CCD_TEST_DATA_OR_SKIP(name, relative)                                         \
    const auto name##Found = ::bullet_ccd::tests::testData(relative);                        \
    if (!name##Found)                                                                        \
    {                                                                                        \
        GTEST_SKIP() << "test data '" << (relative)                                          \
                     << "' is absent; set BULLET_CCD_TEST_DATA to the folder that holds it"; \
    }                                                                                        \
    const std::filesystem::path& name = *name##Found
