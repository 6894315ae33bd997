#include "bullet_ccd/deformable/big_integer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>

namespace bullet_ccd
{
namespace
{
__extension__ using Wide = unsigned __int128;

int compareLimbs(const Limbs& a, const Limbs& b)
{
    if (a.size() != b.size())
    {
        return a.size() < b.size() ? -1 : 1;
    }
    for (std::size_t i = a.size(); i-- > 0;)
    {
        if (a[i] != b[i])
        {
            return a[i] < b[i] ? -1 : 1;
        }
    }
    return 0;
}

/// Adds the shorter to the longer.
Limbs added(const Limbs& longer, const Limbs& shorter)
{
    Limbs sum = longer;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < sum.size() && (i < shorter.size() || carry != 0); ++i)
    {
        const Wide digit = Wide{sum[i]} + (i < shorter.size() ? shorter[i] : 0U) + carry;
        sum[i] = static_cast<std::uint64_t>(digit);
        carry = static_cast<std::uint64_t>(digit >> 64U);
    }
    if (carry != 0)
    {
        sum.resize(sum.size() + 1);
        sum[sum.size() - 1] = carry;
    }
    return sum;
}

/// Larger minus smaller; may have zeros at its end.
Limbs subtracted(const Limbs& larger, const Limbs& smaller)
{
    Limbs difference = larger;
    std::uint64_t borrow = 0;
    for (std::size_t i = 0; i < difference.size() && (i < smaller.size() || borrow != 0); ++i)
    {
        const Wide take = Wide{i < smaller.size() ? smaller[i] : 0U} + borrow;
        borrow = difference[i] < take ? 1 : 0;
        difference[i] -= static_cast<std::uint64_t>(take);
    }
    return difference;
}

/// The sign that a sequence of values changes, how often; zeros do not count.
int signChanges(const std::vector<Polynomial>& sequence, const Dyadic& x)
{
    int changes = 0;
    int last = 0;
    for (const Polynomial& p : sequence)
    {
        const int sign = scaledValue(p, x).sign();
        if (sign != 0)
        {
            changes += last != 0 && sign != last ? 1 : 0;
            last = sign;
        }
    }
    return changes;
}

void trimPolynomial(Polynomial& p)
{
    while (!p.empty() && p.back().sign() == 0)
    {
        p.pop_back();
    }
}

/// A positive multiple of the remainder of a by b.
Polynomial remainder(Polynomial a, const Polynomial& b)
{
    const BigInteger& lead = b.back();
    const BigInteger size = lead.sign() < 0 ? -lead : lead;
    while (a.size() >= b.size())
    {
        const BigInteger factor = lead.sign() < 0 ? -a.back() : a.back();
        const std::size_t offset = a.size() - b.size();
        for (std::size_t i = 0; i < a.size(); ++i)
        {
            a[i] = a[i] * size;
            if (i >= offset)
            {
                a[i] = a[i] - factor * b[i - offset];
            }
        }
        trimPolynomial(a);
    }
    return a;
}
}  // namespace

BigInteger::BigInteger(std::int64_t value) : m_isNegative(value < 0)
{
    if (value != 0)
    {
        m_limbs.resize(1);
        const auto size = static_cast<std::uint64_t>(value);
        m_limbs[0] = m_isNegative ? ~size + 1 : size;
    }
}

void BigInteger::trim()
{
    while (!m_limbs.empty() && m_limbs.back() == 0)
    {
        m_limbs.pop_back();
    }
}

BigInteger BigInteger::operator-() const
{
    BigInteger result = *this;
    result.m_isNegative = !m_isNegative;
    return result;
}

BigInteger BigInteger::shifted(std::int32_t bits) const
{
    if (m_limbs.empty())
    {
        return {};
    }
    BigInteger result;
    result.m_isNegative = m_isNegative;
    const auto whole = static_cast<std::size_t>(bits / 64);
    const auto rest = static_cast<unsigned>(bits % 64);
    result.m_limbs.resize(whole + m_limbs.size() + 1);
    for (std::size_t i = 0; i < m_limbs.size(); ++i)
    {
        const Wide wide = Wide{m_limbs[i]} << rest;
        result.m_limbs[whole + i] |= static_cast<std::uint64_t>(wide);
        result.m_limbs[whole + i + 1] = static_cast<std::uint64_t>(wide >> 64U);
    }
    result.trim();
    return result;
}

std::int64_t BigInteger::bits() const
{
    return m_limbs.empty()
               ? 0
               : 64 * static_cast<std::int64_t>(m_limbs.size()) - std::countl_zero(m_limbs.back());
}

double BigInteger::toDouble(std::int64_t exponent) const
{
    double value = 0.0;
    const std::size_t count = m_limbs.size();
    const std::size_t used = std::min<std::size_t>(count, 2);
    for (std::size_t i = 0; i < used; ++i)
    {
        value = value * 18446744073709551616.0 + static_cast<double>(m_limbs[count - 1 - i]);
    }
    const std::int64_t power = 64 * static_cast<std::int64_t>(count - used) - exponent;
    value = std::ldexp(value, static_cast<int>(std::clamp<std::int64_t>(power, -5000, 5000)));
    return m_isNegative ? -value : value;
}

BigInteger BigInteger::sum(const BigInteger& a, const BigInteger& b, bool isBNegative)
{
    BigInteger result;
    if (a.m_isNegative == isBNegative)
    {
        result.m_limbs = a.m_limbs.size() >= b.m_limbs.size() ? added(a.m_limbs, b.m_limbs)
                                                              : added(b.m_limbs, a.m_limbs);
        result.m_isNegative = isBNegative;
        return result;
    }
    const bool isALarger = compareLimbs(a.m_limbs, b.m_limbs) >= 0;
    result.m_limbs =
        isALarger ? subtracted(a.m_limbs, b.m_limbs) : subtracted(b.m_limbs, a.m_limbs);
    result.m_isNegative = isALarger ? a.m_isNegative : isBNegative;
    result.trim();
    return result;
}

BigInteger operator+(const BigInteger& a, const BigInteger& b)
{
    return BigInteger::sum(a, b, b.m_isNegative);
}

BigInteger operator-(const BigInteger& a, const BigInteger& b)
{
    return BigInteger::sum(a, b, !b.m_isNegative);
}

BigInteger operator*(const BigInteger& a, const BigInteger& b)
{
    BigInteger result;
    if (a.m_limbs.empty() || b.m_limbs.empty())
    {
        return result;
    }
    result.m_isNegative = a.m_isNegative != b.m_isNegative;
    result.m_limbs.resize(a.m_limbs.size() + b.m_limbs.size());
    for (std::size_t i = 0; i < a.m_limbs.size(); ++i)
    {
        std::uint64_t carry = 0;
        for (std::size_t j = 0; j < b.m_limbs.size(); ++j)
        {
            const Wide digit = Wide{a.m_limbs[i]} * b.m_limbs[j] + result.m_limbs[i + j] + carry;
            result.m_limbs[i + j] = static_cast<std::uint64_t>(digit);
            carry = static_cast<std::uint64_t>(digit >> 64U);
        }
        result.m_limbs[i + b.m_limbs.size()] = carry;
    }
    result.trim();
    return result;
}

int compareSizes(const BigInteger& a, const BigInteger& b)
{
    return compareLimbs(a.m_limbs, b.m_limbs);
}

Polynomial operator+(const Polynomial& a, const Polynomial& b)
{
    Polynomial sum = a.size() >= b.size() ? a : b;
    const Polynomial& other = a.size() >= b.size() ? b : a;
    for (std::size_t i = 0; i < other.size(); ++i)
    {
        sum[i] = sum[i] + other[i];
    }
    trimPolynomial(sum);
    return sum;
}

Polynomial operator-(const Polynomial& a, const Polynomial& b)
{
    Polynomial difference = a;
    difference.resize(std::max(a.size(), b.size()));
    for (std::size_t i = 0; i < b.size(); ++i)
    {
        difference[i] = difference[i] - b[i];
    }
    trimPolynomial(difference);
    return difference;
}

Polynomial operator*(const Polynomial& a, const Polynomial& b)
{
    if (a.empty() || b.empty())
    {
        return {};
    }
    Polynomial product(a.size() + b.size() - 1);
    for (std::size_t i = 0; i < a.size(); ++i)
    {
        for (std::size_t j = 0; j < b.size(); ++j)
        {
            product[i + j] = product[i + j] + a[i] * b[j];
        }
    }
    return product;
}

Polynomial derivative(const Polynomial& a)
{
    Polynomial result;
    for (std::size_t i = 1; i < a.size(); ++i)
    {
        result.push_back(a[i] * BigInteger(static_cast<std::int64_t>(i)));
    }
    return result;
}

BigInteger scaledValue(const Polynomial& p, const Dyadic& x)
{
    BigInteger value;
    std::int32_t shift = 0;
    for (std::size_t i = p.size(); i-- > 0;)
    {
        value = value * x.numerator + p[i].shifted(shift);
        shift += x.shift;
    }
    return value;
}

int tarskiQuery(const Polynomial& p, const Polynomial& q, const Dyadic& low, const Dyadic& high)
{
    // Only the values at roots of p count, so that what has fewer digits will do.
    std::vector<Polynomial> sequence{p, remainder(derivative(p) * q, p)};
    while (!sequence.back().empty())
    {
        Polynomial next = remainder(sequence[sequence.size() - 2], sequence.back());
        for (BigInteger& c : next)
        {
            c = -c;
        }
        sequence.push_back(std::move(next));
    }
    return signChanges(sequence, low) - signChanges(sequence, high);
}
}  // namespace bullet_ccd
