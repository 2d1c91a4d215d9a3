// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_components.h"

#include <numeric>
#include <utility>

namespace octant::calib {
namespace {

CellSums sums_of_kind(const ErrorSample& sample, ErrorSample::Kind kind) {
  std::vector<std::uint32_t> rows;
  for (std::size_t i = 0; i < sample.rows.size(); ++i)
    if (sample.rows[i].kind == kind) rows.push_back(static_cast<std::uint32_t>(i));
  return CellSums(std::move(rows));
}

}  // namespace

ErrorComponents::ErrorComponents(const ErrorSample& sample)
    : sums_{sums_of_kind(sample, ErrorSample::Kind::kArrival),
            sums_of_kind(sample, ErrorSample::Kind::kBearing)} {
  for (const bool bearings : {false, true})
    if (count(bearings) > 0) all_.push_back({{}, {}, bearings});
  whites_ = size();
  for (const ErrorCells& c : error_cells(sample)) {
    if (count(c.part.bearings) < kFewestObservations) continue;
    all_.push_back({c.part, {}, c.part.bearings});
    for (std::size_t k = 0; k < c.partitions.size(); ++k)
      all_.back().partitions.push_back(sums_[c.part.bearings].add(c.partitions[k], c.counts[k]));
  }
  for (CellSums& s : sums_) s.arrange();
}

std::size_t ErrorComponents::cells_of(Eigen::Index m) const {
  const ErrorComponent& c = (*this)[m];
  return c.is_white() ? count(c.bearings)
                      : static_cast<std::size_t>(sums_[c.bearings].count(c.partitions.front()));
}

void ErrorComponents::keep(const std::vector<Eigen::Index>& kept) {
  std::vector<ErrorComponent> some;
  for (const Eigen::Index m : kept) some.push_back(std::move(all_[static_cast<std::size_t>(m)]));
  all_ = std::move(some);
}

void ErrorComponents::add_normal(Eigen::Index m, double sigma, std::size_t draw, DrawBits& random,
                                 std::vector<DrawLine>& errors) const {
  const ErrorComponent& c = (*this)[m];
  const auto scale = static_cast<float>(sigma);
  const auto add = [scale](const DrawLine& from, DrawLine& to) {
    for (std::size_t k = 0; k < kDrawsAbreast; ++k) to.of[k] += scale * from.of[k];
  };
  const std::vector<std::uint32_t>& rows = rows_of(c.bearings);
  if (c.is_white()) {
    DrawLine value;
    for (const std::uint32_t row : rows) {
      random.normal(value);
      add(value, errors[row]);
    }
    return;
  }
  const std::size_t partition = c.partitions[draw % c.partitions.size()];
  std::vector<DrawLine> values(static_cast<std::size_t>(sums_[c.bearings].count(partition)));
  for (DrawLine& line : values) random.normal(line);
  const std::vector<std::int32_t>& cell = sums_[c.bearings].cells(partition);
  for (std::size_t i = 0; i < rows.size(); ++i)
    add(values[static_cast<std::size_t>(cell[i])], errors[rows[i]]);
}

void ErrorComponents::set_signs(Eigen::Index m, std::size_t draw, std::size_t column, DrawBits& random,
                                std::vector<DrawLine>& errors) const {
  const ErrorComponent& c = (*this)[m];
  const auto sign = [&random] { return (random.bits() >> 63U) != 0 ? 1.0F : -1.0F; };
  const std::vector<std::uint32_t>& rows = rows_of(c.bearings);
  if (c.is_white()) {
    for (const std::uint32_t row : rows) errors[row].of[column] = sign();
    return;
  }
  const std::size_t partition = c.partitions[draw % c.partitions.size()];
  std::vector<float> value(static_cast<std::size_t>(sums_[c.bearings].count(partition)));
  for (float& v : value) v = sign();
  const std::vector<std::int32_t>& cell = sums_[c.bearings].cells(partition);
  for (std::size_t i = 0; i < rows.size(); ++i)
    errors[rows[i]].of[column] = value[static_cast<std::size_t>(cell[i])];
}

Eigen::MatrixXd ErrorComponents::sums_of(const std::vector<DrawLine>& r, Scratch& scratch) const {
  Eigen::MatrixXd q = Eigen::MatrixXd::Zero(size(), static_cast<Eigen::Index>(kDrawsAbreast));
  for (const bool bearings : {false, true}) {
    if (count(bearings) == 0) continue;
    const Eigen::MatrixXd squares = sums_[bearings].squares(r, scratch[bearings]);
    for (Eigen::Index m = 0; m < size(); ++m) {
      const ErrorComponent& c = (*this)[m];
      if (c.bearings != bearings) continue;
      if (c.is_white()) q.row(m) = squares.bottomRows<1>();
      for (const std::size_t k : c.partitions)
        q.row(m) += squares.row(static_cast<Eigen::Index>(k)) / static_cast<double>(c.partitions.size());
    }
  }
  return q;
}

Eigen::MatrixXd ErrorComponents::squares_of_influence(Eigen::Index m, const ErrorDraws& draws) const {
  const ErrorComponent& c = (*this)[m];
  const std::vector<std::uint32_t>& rows = rows_of(c.bearings);
  if (c.is_white()) {
    std::vector<std::int32_t> each(rows.size());
    std::iota(each.begin(), each.end(), 0);
    return draws.squares_of_cells(rows, each, static_cast<std::int32_t>(rows.size()));
  }
  Eigen::MatrixXd squares;
  for (const std::size_t k : c.partitions) {
    const Eigen::MatrixXd one =
        draws.squares_of_cells(rows, sums_[c.bearings].cells(k), sums_[c.bearings].count(k));
    squares = squares.size() == 0 ? one : Eigen::MatrixXd(squares + one);
  }
  return squares / static_cast<double>(c.partitions.size());
}

}  // namespace octant::calib
