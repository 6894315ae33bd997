#include "bullet_ccd/bullet/kernels/btCcdRows.h"

#if defined(BT_USE_DOUBLE_PRECISION) && defined(__x86_64__)
#include "bullet_ccd/math/simd_level.h"

#include <immintrin.h>

namespace
{
// The fourth number of a vector means nothing, and is in no sum.
using Four = double __attribute__((vector_size(32)));

__attribute__((target("avx"))) inline Four load(const btVector3& v)
{
    return _mm256_loadu_pd(v.m_floats);
}

__attribute__((target("avx"))) inline void store(btVector3& v, Four numbers)
{
    _mm256_storeu_pd(v.m_floats, numbers);
}

/// How fast a body moves along a row: the sum of two products, added up in Bullet's order.
__attribute__((target("avx"))) inline double speedAlong(const btSolverBody& body,
                                                        Four normal,
                                                        const btVector3& turning)
{
    const Four moved = normal * load(body.m_deltaLinearVelocity);
    const Four turned = load(turning) * load(body.m_deltaAngularVelocity);
    const Four evens = _mm256_unpacklo_pd(moved, turned);
    const Four odds = _mm256_unpackhi_pd(moved, turned);
    const __m128d sums = _mm256_castpd256_pd128(evens) + _mm256_castpd256_pd128(odds) +
                         _mm256_extractf128_pd(evens, 1);
    return sums[0] + sums[1];
}

__attribute__((target("avx"))) inline void push(btSolverBody& body,
                                                Four normal,
                                                const btVector3& turning,
                                                double impulse)
{
    if (body.m_originalBody == nullptr)
    {
        return;
    }
    store(body.m_deltaLinearVelocity,
          load(body.m_deltaLinearVelocity) +
              normal * load(body.m_invMass) * impulse * load(body.m_linearFactor));
    store(
        body.m_deltaAngularVelocity,
        load(body.m_deltaAngularVelocity) + load(turning) * (impulse * load(body.m_angularFactor)));
}

template <bool kHasUpperLimit>
__attribute__((target("avx"))) double resolve(btSolverBody& a,
                                              btSolverBody& b,
                                              const btSolverConstraint& row)
{
    const Four normalA = load(row.m_contactNormal1);
    const Four normalB = load(row.m_contactNormal2);
    const double before = row.m_appliedImpulse;
    double impulse = row.m_rhs - before * row.m_cfm;
    impulse -= speedAlong(a, normalA, row.m_relpos1CrossNormal) * row.m_jacDiagABInv;
    impulse -= speedAlong(b, normalB, row.m_relpos2CrossNormal) * row.m_jacDiagABInv;
    const double sum = before + impulse;
    if (sum < row.m_lowerLimit)
    {
        impulse = row.m_lowerLimit - before;
        row.m_appliedImpulse = row.m_lowerLimit;
    }
    else if (kHasUpperLimit && sum > row.m_upperLimit)
    {
        impulse = row.m_upperLimit - before;
        row.m_appliedImpulse = row.m_upperLimit;
    }
    else
    {
        row.m_appliedImpulse = sum;
    }
    push(a, normalA, row.m_angularComponentA, impulse);
    push(b, normalB, row.m_angularComponentB, impulse);
    return impulse * (1.0 / row.m_jacDiagABInv);
}
}  // namespace

btCcdRows btCcdRows::quick()
{
    static const btCcdRows chosen = bullet_ccd::simdLevel() >= bullet_ccd::SimdLevel::Avx2
                                        ? btCcdRows{resolve<true>, resolve<false>}
                                        : btCcdRows{};
    return chosen;
}
#else
btCcdRows btCcdRows::quick()
{
    return {};
}
#endif

namespace
{
/// Where a mode is new to it, a solver chooses its rows anew.
struct Modes : btSequentialImpulseConstraintSolver
{
    static int& known(btSequentialImpulseConstraintSolver& solver)
    {
        return solver.*(&Modes::m_cachedSolverMode);
    }
};
}  // namespace

btCcdQuickRows::btCcdQuickRows(btConstraintSolver& solver, int mode)
{
    const btCcdRows quick = btCcdRows::quick();
    m_solver = quick.m_generic != nullptr
                   ? dynamic_cast<btSequentialImpulseConstraintSolver*>(&solver)
                   : nullptr;
    if (m_solver == nullptr)
    {
        return;
    }
    m_rows = {m_solver->getActiveConstraintRowSolverGeneric(),
              m_solver->getActiveConstraintRowSolverLowerLimit()};
    if (m_rows.m_generic != m_solver->getScalarConstraintRowSolverGeneric() ||
        m_rows.m_lowerLimit != m_solver->getScalarConstraintRowSolverLowerLimit())
    {
        m_solver = nullptr;  // rows of somebody else
        return;
    }
    m_mode = Modes::known(*m_solver);
    Modes::known(*m_solver) = mode;
    m_solver->setConstraintRowSolverGeneric(quick.m_generic);
    m_solver->setConstraintRowSolverLowerLimit(quick.m_lowerLimit);
}

btCcdQuickRows::~btCcdQuickRows()
{
    if (m_solver != nullptr)
    {
        Modes::known(*m_solver) = m_mode;
        m_solver->setConstraintRowSolverGeneric(m_rows.m_generic);
        m_solver->setConstraintRowSolverLowerLimit(m_rows.m_lowerLimit);
    }
}
