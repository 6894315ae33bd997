#include "benchmarks/support/data_folder.h"

#include <cstdlib>

namespace bullet_ccd::benchmarks
{
std::filesystem::path defaultDataFolder()
{
    const char* folder = std::getenv("BULLET_CCD_TEST_DATA");
    return folder != nullptr ? folder : BULLET_CCD_BENCHMARK_DATA;
}
}  // namespace bullet_ccd::benchmarks
