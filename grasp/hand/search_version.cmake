# Writes the hash of the contents of _search_sources into the header _search_version, if it is another one.
set(_search_hashes "")
foreach(_source ${_search_sources})
    file(SHA256 "${_source}" _search_hash)
    string(APPEND _search_hashes "${_search_hash}\n")
endforeach()
string(SHA256 _search_hash "${_search_hashes}")
file(CONFIGURE OUTPUT "${_search_version}" @ONLY CONTENT
"/// Names the state of the search of hands by the content of its sources.
#pragma once

namespace bullet_ccd::grasp
{
inline constexpr const char* kSearchVersion = \"@_search_hash@\";
}
")
