// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_draws.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <boost/math/distributions/normal.hpp>

namespace octant::calib {
namespace {

constexpr std::size_t kQuantiles = 4096;

/// Medians of equal parts of the normal distribution, to unit variance.
std::array<float, kQuantiles> normal_quantiles() {
  constexpr std::size_t kHalf = kQuantiles / 2;
  std::array<double, kHalf> upper{};
  double squares = 0.0;
  for (std::size_t i = 0; i < kHalf; ++i) {
    const double beyond = 0.5 - (static_cast<double>(i) + 0.5) / kQuantiles;
    upper[i] = boost::math::quantile(boost::math::complement(boost::math::normal(), beyond));
    squares += upper[i] * upper[i] / kHalf;
  }
  std::array<float, kQuantiles> out{};
  for (std::size_t i = 0; i < kHalf; ++i) {
    out[kHalf + i] = static_cast<float>(upper[i] / std::sqrt(squares));
    out[kHalf - 1 - i] = -out[kHalf + i];
  }
  return out;
}

}  // namespace

std::uint64_t mixed_bits(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

std::uint64_t DrawBits::bits() { return mixed_bits(state_ += 0x9e3779b97f4a7c15ULL); }

void DrawBits::normal(DrawLine& line) {
  static const std::array<float, kQuantiles> kNormal = normal_quantiles();
  for (std::size_t k = 0; k < kDrawsAbreast; k += 4) {
    std::uint64_t b = bits();
    for (std::size_t i = 0; i < 4; ++i, b >>= 12U) line.of[k + i] = kNormal[b % kQuantiles];
  }
}

// ------------------------------------------------------------------------------------------------ the sums

std::size_t CellSums::add(std::vector<std::int32_t> cell, std::int32_t count) {
  Partition& p = partitions_.emplace_back();
  p.cell = std::move(cell);
  p.count = count;
  return partitions_.size() - 1;
}

bool CellSums::joins(const Partition& finer, Partition& coarser) const {
  std::vector<std::int32_t>& of = coarser.of_finer;
  of.assign(static_cast<std::size_t>(finer.count), -1);
  for (std::size_t i = 0; i < finer.cell.size(); ++i) {
    std::int32_t& to = of[static_cast<std::size_t>(finer.cell[i])];
    if (to < 0) to = coarser.cell[i];
    if (to != coarser.cell[i]) return false;
  }
  return true;
}

void CellSums::arrange() {
  order_.resize(partitions_.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::ranges::stable_sort(
      order_, [&](std::size_t a, std::size_t b) { return partitions_[a].count > partitions_[b].count; });
  for (std::size_t k = 1; k < order_.size(); ++k) {
    Partition& coarser = partitions_[order_[k]];
    for (std::size_t j = k; j-- > 0 && coarser.finer < 0;)  // the coarsest that it joins
      if (joins(partitions_[order_[j]], coarser)) coarser.finer = static_cast<int>(order_[j]);
  }
}

Eigen::MatrixXd CellSums::squares(const std::vector<DrawLine>& draws, Scratch& scratch) const {
  using ByDraw = Eigen::Matrix<double, Eigen::Dynamic, static_cast<int>(kDrawsAbreast), Eigen::RowMajor>;
  ByDraw out = ByDraw::Zero(static_cast<Eigen::Index>(partitions_.size() + 1), kDrawsAbreast);
  scratch.values.resize(rows_.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) scratch.values[i] = draws[rows_[i]];
  scratch.sums.resize(partitions_.size());
  for (const std::size_t m : order_) {
    const Partition& p = partitions_[m];
    std::vector<DrawLine>& sums = scratch.sums[m];
    sums.assign(static_cast<std::size_t>(p.count), {});
    if (p.finer < 0)
      add_to_cells(p.cell, scratch.values.data(), sums.data());
    else
      add_to_cells(p.of_finer, scratch.sums[static_cast<std::size_t>(p.finer)].data(), sums.data());
    add_squares(sums.data(), sums.size(), &out(static_cast<Eigen::Index>(m), 0));
  }
  add_squares(scratch.values.data(), scratch.values.size(), &out(out.rows() - 1, 0));
  return out;
}

// --------------------------------------------------------------------------------------------- the residuals

ErrorDraws::ErrorDraws(const ErrorSample& sample)
    : sample_(sample), F_(sample.F.data(), sample.F.data() + sample.F.size()) {}

void ErrorDraws::adjust(std::vector<DrawLine>& errors, const std::vector<DrawLine>& of_priors,
                        Scratch& scratch) const {
  const auto rank = static_cast<std::size_t>(sample_.F.cols());
  if (of_priors.empty())
    scratch.shared.assign(rank, {});
  else
    scratch.shared = of_priors;
  add_projection(F_.data(), errors.size(), rank, errors.data(), scratch.shared.data());
  subtract_states(sample_.J, sample_.chains, errors, scratch.states);
  subtract_product(F_.data(), errors.size(), rank, scratch.shared.data(), errors.data());
}

std::vector<DrawLine> ErrorDraws::of_priors(std::uint64_t stream) const {
  DrawBits random(stream);
  const Eigen::MatrixXd& K = sample_.prior_root;
  std::vector<DrawLine> normal(static_cast<std::size_t>(K.cols())), out(normal.size());
  for (DrawLine& line : normal) random.normal(line);
  for (Eigen::Index j = 0; j < K.cols(); ++j)
    for (Eigen::Index i = 0; i < K.rows(); ++i)
      for (std::size_t k = 0; k < kDrawsAbreast; ++k)
        out[static_cast<std::size_t>(i)].of[k] +=
            static_cast<float>(K(i, j)) * normal[static_cast<std::size_t>(j)].of[k];
  return out;
}

void ErrorDraws::influence_times(const Eigen::MatrixXd& T, std::vector<DrawLine>& product) const {
  std::vector<DrawLine> t(static_cast<std::size_t>(T.rows()));
  for (Eigen::Index i = 0; i < T.rows(); ++i)
    for (Eigen::Index k = 0; k < T.cols(); ++k)
      t[static_cast<std::size_t>(i)].of[k] = -static_cast<float>(T(i, k));
  product.assign(static_cast<std::size_t>(sample_.F.rows()), {});
  subtract_product(F_.data(), product.size(), t.size(), t.data(), product.data());
}

Eigen::MatrixXd ErrorDraws::squares_of_cells(const std::vector<std::uint32_t>& rows,
                                             const std::vector<std::int32_t>& cell,
                                             std::int32_t count) const {
  const auto rank = static_cast<std::size_t>(sample_.F.cols());
  std::vector<float> sums(static_cast<std::size_t>(count) * rank, 0.0F);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    float* const to = sums.data() + static_cast<std::size_t>(cell[i]) * rank;
    const float* const from = F_.data() + rows[i] * rank;
    for (std::size_t k = 0; k < rank; ++k) to[k] += from[k];
  }
  return product_of_rows(sums, sums, rank);
}

Eigen::MatrixXd product_of_rows(const std::vector<float>& A, const std::vector<float>& B, std::size_t rank) {
  const auto n = static_cast<Eigen::Index>(rank);
  Eigen::MatrixXd out(n, n);
  if (rank == 0) return out;
  const std::size_t rows = A.size() / rank;
  std::vector<DrawLine> some(rows), product;
  for (std::size_t first = 0; first < rank; first += kDrawsAbreast) {
    const std::size_t width = std::min(kDrawsAbreast, rank - first);
    for (std::size_t i = 0; i < rows; ++i) std::copy_n(B.data() + i * rank + first, width, some[i].of);
    product.assign(rank, {});
    add_projection(A.data(), rows, rank, some.data(), product.data());
    for (std::size_t i = 0; i < rank; ++i)
      for (std::size_t k = 0; k < width; ++k)
        out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(first + k)) = product[i].of[k];
  }
  return out;
}

}  // namespace octant::calib
