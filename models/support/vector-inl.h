// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Vectors of up to eight doubles, as many as the machine's registers contain, with operators so that kernels
// read like algebra. For sources that Highway compiles once for each instruction set (foreach_target.h). Only
// modules that link Highway may include it; models itself does not.
//
// A product that is added or subtracted is fused: a * b + c rounds once. With two products, the left one of a
// sum and the right one of a difference are fused. V(a * b) rounds by itself.
#if defined(OCTANT_MODELS_SUPPORT_VECTOR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTANT_MODELS_SUPPORT_VECTOR_INL_H_
#undef OCTANT_MODELS_SUPPORT_VECTOR_INL_H_
#else
#define OCTANT_MODELS_SUPPORT_VECTOR_INL_H_
#endif

#include <cmath>
#include <cstddef>

#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace octant {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;

/// Number of lanes of a vector: 1 to 8.
HWY_INLINE std::size_t lanes_at_once() { return hn::Lanes(Doubles()); }

/// One boolean for each lane.
struct Mask {
  hn::Mask<Doubles> raw;
};

struct Product;

/// One number for each lane; a scalar converts to equal lanes.
struct Vector {
  hn::Vec<Doubles> raw;
  Vector() = default;
  HWY_INLINE Vector(hn::Vec<Doubles> v) : raw(v) {}
  HWY_INLINE Vector(double same) : raw(hn::Set(Doubles(), same)) {}
  HWY_INLINE Vector(Product p);
};

/// A product that has not been rounded yet, so that an addition can be fused with it.
struct Product {
  Vector a, b;
};
HWY_INLINE Vector::Vector(Product p) : raw(hn::Mul(p.a.raw, p.b.raw)) {}

HWY_INLINE Product operator*(Vector a, Vector b) { return {a, b}; }
HWY_INLINE Vector operator/(Vector a, Vector b) { return hn::Div(a.raw, b.raw); }
HWY_INLINE Vector operator-(Vector a) { return hn::Neg(a.raw); }
HWY_INLINE Vector operator+(Vector a, Vector b) { return hn::Add(a.raw, b.raw); }
HWY_INLINE Vector operator-(Vector a, Vector b) { return hn::Sub(a.raw, b.raw); }
HWY_INLINE Vector operator+(Product p, Vector c) { return hn::MulAdd(p.a.raw, p.b.raw, c.raw); }
HWY_INLINE Vector operator+(Vector c, Product p) { return p + c; }
HWY_INLINE Vector operator-(Vector c, Product p) { return hn::NegMulAdd(p.a.raw, p.b.raw, c.raw); }
HWY_INLINE Vector operator-(Product p, Vector c) { return hn::Sub(Vector(p).raw, c.raw); }
HWY_INLINE Vector operator+(Product p, Product q) { return p + Vector(q); }
HWY_INLINE Vector operator-(Product p, Product q) { return Vector(p) - q; }
template <class Term>
HWY_INLINE void operator+=(Vector& sum, Term term) {
  sum = sum + term;
}
template <class Term>
HWY_INLINE void operator-=(Vector& sum, Term term) {
  sum = sum - term;
}

HWY_INLINE Mask operator==(Vector a, Vector b) { return {hn::Eq(a.raw, b.raw)}; }
HWY_INLINE Mask operator<(Vector a, Vector b) { return {hn::Lt(a.raw, b.raw)}; }
HWY_INLINE Mask operator>(Vector a, Vector b) { return {hn::Gt(a.raw, b.raw)}; }
HWY_INLINE Mask operator<=(Vector a, Vector b) { return {hn::Le(a.raw, b.raw)}; }
HWY_INLINE Mask operator>=(Vector a, Vector b) { return {hn::Ge(a.raw, b.raw)}; }
HWY_INLINE Mask operator&(Mask a, Mask b) { return {hn::And(a.raw, b.raw)}; }
HWY_INLINE Mask operator|(Mask a, Mask b) { return {hn::Or(a.raw, b.raw)}; }
HWY_INLINE Mask operator!(Mask a) { return {hn::Not(a.raw)}; }
HWY_INLINE Mask but_not(Mask a, Mask b) { return {hn::AndNot(b.raw, a.raw)}; }
HWY_INLINE bool all(Mask m) { return hn::AllTrue(Doubles(), m.raw); }
HWY_INLINE bool none(Mask m) { return hn::AllFalse(Doubles(), m.raw); }
HWY_INLINE Vector select(Mask m, Vector yes, Vector no) { return hn::IfThenElse(m.raw, yes.raw, no.raw); }
HWY_INLINE Vector only(Mask m, Vector v) { return hn::IfThenElseZero(m.raw, v.raw); }

HWY_INLINE Vector sqrt(Vector v) { return hn::Sqrt(v.raw); }
HWY_INLINE Vector abs(Vector v) { return hn::Abs(v.raw); }
HWY_INLINE Vector round(Vector v) { return hn::Round(v.raw); }
HWY_INLINE Vector min(Vector a, Vector b) { return hn::Min(a.raw, b.raw); }
HWY_INLINE Vector max(Vector a, Vector b) { return hn::Max(a.raw, b.raw); }
HWY_INLINE Vector sin(Vector v) { return hn::Sin(Doubles(), v.raw); }
HWY_INLINE Vector cos(Vector v) { return hn::Cos(Doubles(), v.raw); }
HWY_INLINE Vector exp(Vector v) { return hn::Exp(Doubles(), v.raw); }
HWY_INLINE Vector log1p(Vector v) { return hn::Log1p(Doubles(), v.raw); }
HWY_INLINE double sum_of_lanes(Vector v) { return hn::GetLane(hn::SumOfLanes(Doubles(), v.raw)); }

// Blocks with one matrix in each lane: SmallCholesky<N, Vector>.
#include "models/support/small_cholesky.inc"

/// Adds the lanes of each of four vectors to its sum.
HWY_INLINE void add_lanes(Vector a, Vector b, Vector c, Vector e, double* sums) {
#if HWY_MAX_BYTES >= 32
  const hn::CappedTag<double, 4> d4;
#if HWY_MAX_BYTES >= 64
  const auto narrow = [d4](Vector v) { return hn::Add(hn::LowerHalf(d4, v.raw), hn::UpperHalf(d4, v.raw)); };
#else
  const auto narrow = [](Vector v) { return v.raw; };
#endif
  const auto a4 = narrow(a), b4 = narrow(b), c4 = narrow(c), e4 = narrow(e);
  const auto ab = hn::Add(hn::InterleaveLower(d4, a4, b4), hn::InterleaveUpper(d4, a4, b4));
  const auto ce = hn::Add(hn::InterleaveLower(d4, c4, e4), hn::InterleaveUpper(d4, c4, e4));
  const auto all = hn::Add(hn::ConcatLowerLower(d4, ce, ab), hn::ConcatUpperUpper(d4, ce, ab));
  hn::StoreU(hn::Add(hn::LoadU(d4, sums), all), d4, sums);
#else
  const Vector all[4] = {a, b, c, e};
  for (int i = 0; i < 4; ++i) sums[i] += sum_of_lanes(all[i]);
#endif
}

/// Load from and store to memory with the alignment of a vector, or of a double only.
HWY_INLINE Vector load(const double* from) { return hn::Load(Doubles(), from); }
HWY_INLINE void store(Vector v, double* to) { hn::Store(v.raw, Doubles(), to); }
HWY_INLINE Vector load_unaligned(const double* from) { return hn::LoadU(Doubles(), from); }
HWY_INLINE void store_unaligned(Vector v, double* to) { hn::StoreU(v.raw, Doubles(), to); }

}  // namespace HWY_NAMESPACE
}  // namespace octant
HWY_AFTER_NAMESPACE();

#endif
