#include "tests/support/test_data.h"

#include <cstdlib>

namespace bullet_ccd::tests
{
std::optional<std::filesystem::path> testData(const std::string& relative)
{
    const char* folder = std::getenv("BULLET_CCD_TEST_DATA");
    const std::filesystem::path path =
        std::filesystem::path(folder != nullptr ? folder : BULLET_CCD_DEFAULT_TEST_DATA) / relative;
    if (!std::filesystem::exists(path))
    {
        return std::nullopt;
    }
    return path;
}

bool longTests()
{
    return std::getenv("BULLET_CCD_LONG_TESTS") != nullptr;
}
}  // namespace bullet_ccd::tests
