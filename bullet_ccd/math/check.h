/// Checks at the two borders of the library.
///
/// require() guards what comes from outside (files, options, user meshes): it throws with a message
/// that says what is wrong, where, and what to do. BULLET_CCD_ASSERT guards what the library itself
/// promises; it is active in debug builds and wherever BULLET_CCD_ASSERTIONS is defined.
#pragma once

#include <concepts>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace bullet_ccd
{
/// Throws std::invalid_argument(message) unless `condition` holds.
inline void require(bool condition, const std::string& message)
{
    if (!condition)
    {
        throw std::invalid_argument(message);
    }
}

/// Same, for a literal: no string is built where the condition holds.
inline void require(bool condition, const char* message)
{
    if (!condition)
    {
        throw std::invalid_argument(message);
    }
}

/// Same, for a function that makes the message where the condition does not hold: for what queries
/// ask often.
template <std::invocable Message>
void require(bool condition, const Message& message)
{
    if (!condition)
    {
        throw std::invalid_argument(message());
    }
}
}  // namespace bullet_ccd

#if defined(BULLET_CCD_ASSERTIONS) || !defined(NDEBUG)
#define BULLET_CCD_ASSERT(condition)                                                               \
    do                                                                                             \
    {                                                                                              \
        if (!(condition))                                                                          \
        {                                                                                          \
            std::fprintf(stderr, "%s:%d: assertion failed: %s\n", __FILE__, __LINE__, #condition); \
            std::abort();                                                                          \
        }                                                                                          \
    } while (false)
#else
#define BULLET_CCD_ASSERT(condition) static_cast<void>(0)
#endif
