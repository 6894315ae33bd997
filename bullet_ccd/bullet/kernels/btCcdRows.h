/// The rows of Bullet's solver in double precision, in registers of four numbers. In single
/// precision Bullet has such rows itself.
#ifndef BT_CCD_ROWS_H
#define BT_CCD_ROWS_H

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

/// Guarantee: the same bits as Bullet's scalar rows.
struct btCcdRows
{
    btSingleConstraintRowSolver m_generic = nullptr;  ///< with an upper limit, too
    btSingleConstraintRowSolver m_lowerLimit = nullptr;

    /// Nulls below SimdLevel::Avx2, and where Bullet is of single precision.
    static btCcdRows quick();
};

/// As long as it lives, a solver that is asked in this mode takes the quick rows where it would
/// take Bullet's scalar ones.
class btCcdQuickRows
{
public:
    btCcdQuickRows(btConstraintSolver& solver, int mode);
    ~btCcdQuickRows();
    btCcdQuickRows(const btCcdQuickRows&) = delete;
    btCcdQuickRows& operator=(const btCcdQuickRows&) = delete;

private:
    btSequentialImpulseConstraintSolver* m_solver = nullptr;  // null: nothing was changed
    btCcdRows m_rows;                                         // those of before
    int m_mode = 0;
};

#endif  // BT_CCD_ROWS_H
