/// Whole numbers of any size and polynomials over them: the few operations that exact decisions
/// need. Internal to the room.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bullet_ccd
{
/// The digits of a number to the base 2^64, the lowest first. Few need no memory of their own.
class Limbs
{
public:
    Limbs() = default;
    explicit Limbs(std::size_t size) { resize(size); }

    [[nodiscard]] std::size_t size() const { return m_size; }
    [[nodiscard]] bool empty() const { return m_size == 0; }
    [[nodiscard]] std::uint64_t operator[](std::size_t i) const { return data()[i]; }
    [[nodiscard]] std::uint64_t& operator[](std::size_t i) { return data()[i]; }
    [[nodiscard]] std::uint64_t back() const { return data()[m_size - 1]; }
    void pop_back() { --m_size; }
    /// New digits are 0.
    void resize(std::size_t size)
    {
        if (size > kInside && m_outside.size() < size)
        {
            const bool wasInside = m_outside.empty();
            m_outside.resize(size);
            if (wasInside)
            {
                std::copy_n(m_inside.begin(), m_size, m_outside.begin());
            }
        }
        if (size > m_size)
        {
            std::fill(data() + m_size, data() + size, 0);
        }
        m_size = size;
    }

private:
    static constexpr std::size_t kInside = 8;

    [[nodiscard]] const std::uint64_t* data() const
    {
        return m_outside.empty() ? m_inside.data() : m_outside.data();
    }
    [[nodiscard]] std::uint64_t* data()
    {
        return m_outside.empty() ? m_inside.data() : m_outside.data();
    }

    std::size_t m_size = 0;
    std::array<std::uint64_t, kInside> m_inside{};
    std::vector<std::uint64_t> m_outside;  ///< in place of those inside, if it is not empty
};

/// A whole number of any size.
class BigInteger
{
public:
    BigInteger() = default;
    explicit BigInteger(std::int64_t value);

    /// -1, 0 or 1.
    [[nodiscard]] int sign() const { return m_limbs.empty() ? 0 : m_isNegative ? -1 : 1; }
    [[nodiscard]] BigInteger operator-() const;
    /// Times 2^bits.
    [[nodiscard]] BigInteger shifted(std::int32_t bits) const;
    /// The value times 2^-exponent, at most 2^-51 off relatively; may overflow to infinity.
    [[nodiscard]] double toDouble(std::int64_t exponent) const;
    /// Bits of the absolute value, 0 for 0.
    [[nodiscard]] std::int64_t bits() const;

    friend BigInteger operator+(const BigInteger& a, const BigInteger& b);
    friend BigInteger operator-(const BigInteger& a, const BigInteger& b);
    friend BigInteger operator*(const BigInteger& a, const BigInteger& b);
    /// Sign of |a| - |b|.
    friend int compareSizes(const BigInteger& a, const BigInteger& b);

private:
    /// a + b, where b has another sign than its own if it is said so.
    static BigInteger sum(const BigInteger& a, const BigInteger& b, bool isBNegative);
    void trim();

    Limbs m_limbs;  ///< the last one is not 0
    bool m_isNegative = false;
};

/// Coefficients, the constant one first; the last one is not 0. Empty for the zero polynomial.
using Polynomial = std::vector<BigInteger>;

[[nodiscard]] Polynomial operator+(const Polynomial& a, const Polynomial& b);
[[nodiscard]] Polynomial operator-(const Polynomial& a, const Polynomial& b);
[[nodiscard]] Polynomial operator*(const Polynomial& a, const Polynomial& b);
[[nodiscard]] Polynomial derivative(const Polynomial& a);

/// numerator / 2^shift.
struct Dyadic
{
    BigInteger numerator;
    std::int32_t shift = 0;
};

/// The value at x times 2^(x.shift * degree), which has its sign.
[[nodiscard]] BigInteger scaledValue(const Polynomial& p, const Dyadic& x);

/// Number of distinct roots x of p in (low, high) with q(x) > 0, minus the number of those with
/// q(x) < 0 (Tarski's query by Sturm's sequence). With q = 1 it counts the roots.
/// @pre low < high, p is not zero, and neither bound is a root of p
[[nodiscard]] int tarskiQuery(const Polynomial& p,
                              const Polynomial& q,
                              const Dyadic& low,
                              const Dyadic& high);
}  // namespace bullet_ccd
