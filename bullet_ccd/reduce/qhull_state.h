/// Qhull with an owner: what it computes lives as long as this.
#pragma once

#include <cstdio>

extern "C"
{
#include <libqhull_r/libqhull_r.h>
#include <libqhull_r/mem_r.h>
#include <libqhull_r/qset_r.h>
}

namespace bullet_ccd
{
/// The state of one run of Qhull; its destructor returns all memory. What Qhull reports is dropped.
class QhullState
{
public:
    QhullState() : m_log(std::fopen("/dev/null", "w")) { qh_zero(&m_state, m_log); }
    QhullState(const QhullState&) = delete;
    QhullState& operator=(const QhullState&) = delete;
    ~QhullState()
    {
        int longBlocks = 0;
        int longBytes = 0;
        qh_freeqhull(&m_state, !qh_ALL);
        qh_memfreeshort(&m_state, &longBlocks, &longBytes);
        if (m_log != nullptr)
        {
            std::fclose(m_log);
        }
    }

    /// The convex hull of `count` points with `dimension` coordinates each, one point after the
    /// other, which must outlive this. Returns whether Qhull found one.
    /// @param options of the program qhull, with its name in front
    [[nodiscard]] bool build(char* options, double* coordinates, int dimension, int count)
    {
        return qh_new_qhull(
                   &m_state, dimension, count, coordinates, False, options, nullptr, m_log) == 0;
    }

    [[nodiscard]] qhT& state() { return m_state; }
    [[nodiscard]] const qhT& state() const { return m_state; }

private:
    qhT m_state;
    std::FILE* m_log;
};
}  // namespace bullet_ccd
