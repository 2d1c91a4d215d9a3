// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/draw_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "calib/errors/draw_kernel.cc"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octant::calib {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kMostCoordinates = 8;  ///< largest number of unknowns of a state

using F32 = hn::CappedTag<float, kDrawsAbreast>;
using F64 = hn::CappedTag<double, kDrawsAbreast / 2>;
using HalfF32 = hn::Rebind<float, F64>;

/// to += by * from
HWY_INLINE void add(double by, const StateLine& from, StateLine& to) {
  const F64 d;
  const auto b = hn::Set(d, by);
  for (std::size_t k = 0; k < kDrawsAbreast; k += hn::Lanes(d))
    hn::Store(hn::MulAdd(b, hn::Load(d, from.of + k), hn::Load(d, to.of + k)), d, to.of + k);
}

HWY_INLINE void gather(const StateTaps& J, const std::vector<DrawLine>& e, StateLine* x) {
  const F64 d;
  const HalfF32 f;
  for (std::size_t i = 0; i < e.size(); ++i)
    for (std::uint32_t t = J.first[i]; t < J.first[i + 1]; ++t) {
      const auto by = hn::Set(d, static_cast<double>(J.taps[t].by));
      double* const to = x[J.taps[t].state].of;
      for (std::size_t k = 0; k < kDrawsAbreast; k += hn::Lanes(d))
        hn::Store(hn::MulAdd(by, hn::PromoteTo(d, hn::Load(f, e[i].of + k)), hn::Load(d, to + k)), d, to + k);
    }
}

HWY_INLINE void spread(const StateTaps& J, const StateLine* x, std::vector<DrawLine>& e) {
  const F64 d;
  const HalfF32 f;
  for (std::size_t i = 0; i < e.size(); ++i)
    for (std::uint32_t t = J.first[i]; t < J.first[i + 1]; ++t) {
      const auto by = hn::Set(f, J.taps[t].by);
      const double* const from = x[J.taps[t].state].of;
      for (std::size_t k = 0; k < kDrawsAbreast; k += hn::Lanes(d))
        hn::Store(hn::NegMulAdd(by, hn::DemoteTo(f, hn::Load(d, from + k)), hn::Load(f, e[i].of + k)), f,
                  e[i].of + k);
    }
}

/// Forward elimination and back-substitution.
void solve_chains(const StateChains& chains, StateLine* x) {
  const double* const blocks = chains.blocks.data();
  const auto couple = [&](const StateChains::Link& link, bool onward) {
    StateLine *const here = x + link.first, *const next = here + link.size;
    const double* by = blocks + link.onward;
    for (int i = 0; i < link.next_size; ++i)
      for (int j = 0; j < link.size; ++j, ++by)
        onward ? add(-*by, here[j], next[i]) : add(-*by, next[i], here[j]);
  };
  for (const StateChains::Link& link : chains.links) couple(link, true);
  for (std::size_t k = chains.links.size(); k-- > 0;) {
    const StateChains::Link& link = chains.links[k];
    StateLine solved[kMostCoordinates];
    for (int j = 0; j < link.size; ++j)
      for (int i = 0; i < link.size; ++i)
        add(blocks[link.inverse + static_cast<std::size_t>(j * link.size + i)],
            x[link.first + static_cast<std::uint32_t>(j)], solved[i]);
    for (int i = 0; i < link.size; ++i) x[link.first + static_cast<std::uint32_t>(i)] = solved[i];
    couple(link, false);
  }
}

void subtract_states_of(const StateTaps& J, const StateChains& chains, std::vector<DrawLine>& e,
                        std::vector<StateLine>& x) {
  x.assign(chains.coordinates, {});
  gather(J, e, x.data());
  solve_chains(chains, x.data());
  spread(J, x.data(), e);
}

/// Rows that share a pass over the shared unknowns: the number that keeps eight sums in registers.
constexpr std::size_t kVectors = kDrawsAbreast / hn::MaxLanes(F32());
constexpr std::size_t kRowsAbreast = kVectors < 8 ? 8 / kVectors : 1;
using Float = hn::Vec<F32>;

template <std::size_t kRows>
HWY_INLINE void project_rows(const float* F, std::size_t rank, const DrawLine* e, DrawLine* t) {
  const F32 d;
  const std::size_t lanes = hn::Lanes(d);
  Float in[kRows * kVectors];
  for (std::size_t r = 0; r < kRows; ++r)
    for (std::size_t v = 0; v < kVectors; ++v) in[r * kVectors + v] = hn::Load(d, e[r].of + v * lanes);
  for (std::size_t k = 0; k < rank; ++k)
    for (std::size_t v = 0; v < kVectors; ++v) {
      auto sum = hn::Load(d, t[k].of + v * lanes);
      for (std::size_t r = 0; r < kRows; ++r)
        sum = hn::MulAdd(hn::Set(d, F[r * rank + k]), in[r * kVectors + v], sum);
      hn::Store(sum, d, t[k].of + v * lanes);
    }
}

void project(const float* F, std::size_t rows, std::size_t rank, const DrawLine* e, DrawLine* t) {
  std::size_t i = 0;
  for (; i + kRowsAbreast <= rows; i += kRowsAbreast)
    project_rows<kRowsAbreast>(F + i * rank, rank, e + i, t);
  for (; i < rows; ++i) project_rows<1>(F + i * rank, rank, e + i, t);
}

template <std::size_t kRows>
HWY_INLINE void subtract_rows(const float* F, std::size_t rank, const DrawLine* t, DrawLine* e) {
  const F32 d;
  const std::size_t lanes = hn::Lanes(d);
  Float out[kRows * kVectors];
  for (std::size_t r = 0; r < kRows; ++r)
    for (std::size_t v = 0; v < kVectors; ++v) out[r * kVectors + v] = hn::Load(d, e[r].of + v * lanes);
  for (std::size_t k = 0; k < rank; ++k)
    for (std::size_t v = 0; v < kVectors; ++v) {
      const auto line = hn::Load(d, t[k].of + v * lanes);
      for (std::size_t r = 0; r < kRows; ++r)
        out[r * kVectors + v] = hn::NegMulAdd(hn::Set(d, F[r * rank + k]), line, out[r * kVectors + v]);
    }
  for (std::size_t r = 0; r < kRows; ++r)
    for (std::size_t v = 0; v < kVectors; ++v) hn::Store(out[r * kVectors + v], d, e[r].of + v * lanes);
}

void subtract_all(const float* F, std::size_t rows, std::size_t rank, const DrawLine* t, DrawLine* e) {
  std::size_t i = 0;
  for (; i + kRowsAbreast <= rows; i += kRowsAbreast)
    subtract_rows<kRowsAbreast>(F + i * rank, rank, t, e + i);
  for (; i < rows; ++i) subtract_rows<1>(F + i * rank, rank, t, e + i);
}

void add_cells(const std::vector<std::int32_t>& cell, const DrawLine* values, DrawLine* sums) {
  const F32 d;
  for (std::size_t i = 0; i < cell.size(); ++i) {
    float* const to = sums[cell[i]].of;
    for (std::size_t k = 0; k < kDrawsAbreast; k += hn::Lanes(d))
      hn::Store(hn::Add(hn::Load(d, to + k), hn::Load(d, values[i].of + k)), d, to + k);
  }
}

void square(const DrawLine* values, std::size_t count, double* squares) {
  const F64 d;
  const HalfF32 f;
  for (std::size_t k = 0; k < kDrawsAbreast; k += hn::Lanes(d)) {
    auto sum = hn::LoadU(d, squares + k);
    for (std::size_t i = 0; i < count; ++i) {
      const auto v = hn::PromoteTo(d, hn::Load(f, values[i].of + k));
      sum = hn::MulAdd(v, v, sum);
    }
    hn::StoreU(sum, d, squares + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace octant::calib
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octant::calib {

HWY_EXPORT(subtract_states_of);
HWY_EXPORT(project);
HWY_EXPORT(subtract_all);
HWY_EXPORT(add_cells);
HWY_EXPORT(square);

void subtract_states(const StateTaps& J, const StateChains& chains, std::vector<DrawLine>& e,
                     std::vector<StateLine>& x) {
  HWY_DYNAMIC_DISPATCH(subtract_states_of)(J, chains, e, x);
}
void add_projection(const float* F, std::size_t rows, std::size_t rank, const DrawLine* e, DrawLine* t) {
  HWY_DYNAMIC_DISPATCH(project)(F, rows, rank, e, t);
}
void subtract_product(const float* F, std::size_t rows, std::size_t rank, const DrawLine* t, DrawLine* e) {
  HWY_DYNAMIC_DISPATCH(subtract_all)(F, rows, rank, t, e);
}
void add_to_cells(const std::vector<std::int32_t>& cell, const DrawLine* values, DrawLine* sums) {
  HWY_DYNAMIC_DISPATCH(add_cells)(cell, values, sums);
}
void add_squares(const DrawLine* values, std::size_t count, double* squares) {
  HWY_DYNAMIC_DISPATCH(square)(values, count, squares);
}

}  // namespace octant::calib
#endif
