#include "benchmarks/support/report.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
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
