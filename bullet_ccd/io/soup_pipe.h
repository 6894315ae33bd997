/// How the mesh reader, a process of its own, hands what it read to the library.
#pragma once

#include "bullet_ccd/io/polygon_soup.h"

#include <string>

namespace bullet_ccd
{
/// What came through: a soup, or the reader's complaint, or neither if it ended before its time.
struct ReaderAnswer
{
    bool isComplete = false;
    std::string complaint;  ///< empty if there is a soup
    PolygonSoup soup;       ///< may name vertices that do not exist: triangulate() checks
};

/// Both return false if the other side does not listen any more.
bool sendSoup(int pipe, const PolygonSoup& soup);
bool sendComplaint(int pipe, const std::string& complaint);

/// Reads up to the end of an answer, or of the pipe. Trusts nothing: allocates what has come only.
[[nodiscard]] ReaderAnswer receiveAnswer(int pipe);
}  // namespace bullet_ccd
