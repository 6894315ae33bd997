/// Checks ahead of assimp: files on which its readers would not end, allocate what no file can
/// hold, or recurse until the stack is full.
#pragma once

#include <string>

namespace bullet_ccd
{
/// @param extension lower case, with dot
/// @param content   of the whole file
/// @param name      starts the message
/// Throws std::runtime_error: "<name>: <what, value>: <remedy>".
void requirePlausible(const std::string& content,
                      const std::string& extension,
                      const std::string& name);

/// Refuses XML in which more than 200 elements are open at once; nothing real nests deeper.
void requireShallowXml(const std::string& content, const std::string& name);
}  // namespace bullet_ccd
