#include "bullet_ccd/io/soup_pipe.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <unistd.h>
#include <vector>

namespace bullet_ccd
{
namespace
{
constexpr char kSoupFollows = 's';
constexpr char kComplaintFollows = 'c';

bool sendBytes(int pipe, const void* bytes, std::size_t size)
{
    const char* const begin = static_cast<const char*>(bytes);
    for (std::size_t sent = 0; sent < size;)
    {
        const ssize_t count = ::write(pipe, begin + sent, size - sent);
        if (count < 0 && errno != EINTR)
        {
            return false;
        }
        sent += count > 0 ? static_cast<std::size_t>(count) : 0;
    }
    return true;
}

bool receiveBytes(int pipe, void* bytes, std::size_t size)
{
    char* const begin = static_cast<char*>(bytes);
    for (std::size_t received = 0; received < size;)
    {
        const ssize_t count = ::read(pipe, begin + received, size - received);
        if (count == 0 || (count < 0 && errno != EINTR))
        {
            return false;
        }
        received += count > 0 ? static_cast<std::size_t>(count) : 0;
    }
    return true;
}

/// The number of values, then the values.
template <class Array>
bool sendArray(int pipe, const Array& values)
{
    const std::uint64_t count = values.size();
    return sendBytes(pipe, &count, sizeof(count)) &&
           sendBytes(pipe, values.data(), count * sizeof(values[0]));
}

template <class Array>
bool receiveArray(int pipe, Array& values)
{
    // A wrong count must not allocate: the array grows as values come.
    constexpr std::uint64_t kValuesAtOnce = 1U << 20U;
    std::uint64_t left = 0;
    if (!receiveBytes(pipe, &left, sizeof(left)))
    {
        return false;
    }
    while (left > 0)
    {
        const std::size_t begin = values.size();
        const std::uint64_t count = std::min(left, kValuesAtOnce);
        values.resize(begin + count);
        if (!receiveBytes(pipe, &values[begin], count * sizeof(values[0])))
        {
            return false;
        }
        left -= count;
    }
    return true;
}

bool receiveSoup(int pipe, PolygonSoup& soup)
{
    return receiveArray(pipe, soup.vertices) && receiveArray(pipe, soup.corners) &&
           receiveArray(pipe, soup.polygonEnds) &&
           receiveBytes(pipe, &soup.droppedElements, sizeof(soup.droppedElements)) &&
           std::is_sorted(soup.polygonEnds.begin(), soup.polygonEnds.end()) &&
           (soup.polygonEnds.empty() || soup.polygonEnds.back() <= soup.corners.size());
}
}  // namespace

bool sendSoup(int pipe, const PolygonSoup& soup)
{
    return sendBytes(pipe, &kSoupFollows, 1) && sendArray(pipe, soup.vertices) &&
           sendArray(pipe, soup.corners) && sendArray(pipe, soup.polygonEnds) &&
           sendBytes(pipe, &soup.droppedElements, sizeof(soup.droppedElements));
}

bool sendComplaint(int pipe, const std::string& complaint)
{
    return sendBytes(pipe, &kComplaintFollows, 1) && sendArray(pipe, complaint);
}

ReaderAnswer receiveAnswer(int pipe)
{
    ReaderAnswer answer;
    char kind = 0;
    if (!receiveBytes(pipe, &kind, 1))
    {
        return answer;
    }
    if (kind == kSoupFollows)
    {
        answer.isComplete = receiveSoup(pipe, answer.soup);
    }
    else if (kind == kComplaintFollows)
    {
        answer.isComplete = receiveArray(pipe, answer.complaint) && !answer.complaint.empty();
    }
    return answer;
}
}  // namespace bullet_ccd
