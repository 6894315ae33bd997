/// Says when to try what helps in some places only.
#pragma once

#include <cstdint>

namespace bullet_ccd
{
/// Something is worth trying while it helped in a fourth of the latest tries; where it did not, now
/// and then, because what is near changes.
class WorthTrying
{
public:
    [[nodiscard]] bool now()
    {
        ++m_asked;
        return m_tries < kTries || 4 * m_helps > m_tries || m_asked % kTries == 0;
    }
    void note(bool helped)
    {
        ++m_tries;
        m_helps += helped ? 1 : 0;
        if (m_tries > 8 * kTries)
        {
            m_tries /= 2;
            m_helps /= 2;
        }
    }

private:
    static constexpr std::int64_t kTries = 16;
    std::int64_t m_asked = 0;
    std::int64_t m_tries = 0;
    std::int64_t m_helps = 0;
};
}  // namespace bullet_ccd
