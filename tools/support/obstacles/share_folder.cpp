#include "tools/support/obstacles/share_folder.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>
#include <vector>

namespace bullet_ccd::tools
{
namespace fs = std::filesystem;

fs::path shareFolder()
{
    if (const char* set = std::getenv("BULLET_CCD_SHARE"); set != nullptr && *set != '\0')
    {
        return set;
    }
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    std::vector<fs::path> places;
    if (!error)
    {
        places.push_back(program.parent_path().parent_path() / "share" / "bullet_ccd");
    }
    places.emplace_back(BULLET_CCD_INSTALLED_SHARE);
    const auto found =
        std::find_if(places.begin(), places.end(), [](const fs::path& p) { return fs::exists(p); });
    return found == places.end() ? fs::path() : *found;
}
}  // namespace bullet_ccd::tools
