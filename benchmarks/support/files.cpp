#include "benchmarks/support/files.h"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
std::filesystem::path defaultDataFolder()
{
    const char* folder = std::getenv("BULLET_CCD_TEST_DATA");
    return folder != nullptr ? folder : BULLET_CCD_BENCHMARK_DATA;
}

void writeReport(const std::string& path, nlohmann::json report)
{
    report["compiler"] = BULLET_CCD_COMPILER;
    report["flags"] = BULLET_CCD_FLAGS;
    std::ofstream out(path);
    out << report.dump(1) << '\n';
    if (!out.flush())
    {
        throw std::runtime_error(path + ": cannot be written: name another file");
    }
}
}  // namespace bullet_ccd::benchmarks
