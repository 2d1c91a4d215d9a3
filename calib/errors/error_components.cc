// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/error_components.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "calib/problem/ranges.h"

namespace octant::calib {
namespace {

CellSums sums_of_kind(const ErrorSample& sample, ErrorSample::Kind kind) {
  std::vector<std::uint32_t> rows;
  for (std::size_t i = 0; i < sample.rows.size(); ++i)
    if (sample.rows[i].kind == kind) rows.push_back(static_cast<std::uint32_t>(i));
  return CellSums(std::move(rows));
}

constexpr std::size_t kShifts = 3;  ///< partitions of a component
constexpr double kLadder = 3.0;     ///< from one extent to the next

/// Numbers keys from 0 in the order in which they come. @param keys  mixed
std::vector<std::int32_t> numbered(const std::vector<std::uint64_t>& keys, std::int32_t& count) {
  std::size_t size = 16;
  while (size < 2 * keys.size()) size *= 2;
  std::vector<std::pair<std::uint64_t, std::int32_t>> table(size, {0, -1});
  std::vector<std::int32_t> number(keys.size(), -1);
  count = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    std::size_t at = keys[i] & (size - 1);
    while (table[at].second >= 0 && table[at].first != keys[i]) at = (at + 1) & (size - 1);
    if (table[at].second < 0) table[at] = {keys[i], count++};
    number[i] = table[at].second;
  }
  return number;
}

/// The components that the errors of one kind of observation may have, from short to long extents, each with
/// its partitions: several of them, shifted against each other, together make a kernel that falls linearly
/// with distance.
class ComponentList {
 public:
  /// @param sums  takes the partitions
  ComponentList(const ErrorSample& sample, bool bearings, CellSums& sums) : bearings_(bearings), sums_(sums) {
    for (const std::uint32_t row : sums.rows()) rows_.push_back(&sample.rows[row]);
  }

  std::vector<ErrorComponent> build() {
    const bool pairs = !bearings_ && several_receivers();
    add(ErrorGroup::kPair, ErrorAxis::kConstant, 0.0);
    if (pairs) add(ErrorGroup::kBeacon, ErrorAxis::kConstant, 0.0);
    if (pairs) add(ErrorGroup::kReceiver, ErrorAxis::kConstant, 0.0);
    const double step_s = usual_step_s(), span_s = longest_run_s();
    for (double extent = kLadder * step_s; step_s > 0 && extent < span_s; extent *= kLadder) {
      add(ErrorGroup::kPair, ErrorAxis::kTime, extent);
      if (pairs) add(ErrorGroup::kBeacon, ErrorAxis::kTime, extent);
    }
    const double size_m = path_size_m();
    if (!(size_m > 0)) return std::move(components_);
    for (const double part : {1.0 / 24, 1.0 / 8, 1.0 / 3}) {
      add(ErrorGroup::kPair, ErrorAxis::kPlace, part * size_m);
      if (pairs) add(ErrorGroup::kBeacon, ErrorAxis::kPlace, part * size_m);
    }
    for (const int sectors : {24, 8}) {
      add(ErrorGroup::kPair, ErrorAxis::kDirection, 2 * M_PI / sectors);
      add(ErrorGroup::kReceiver, ErrorAxis::kDirection, 2 * M_PI / sectors);
      add(pairs ? ErrorGroup::kBeacon : ErrorGroup::kPair, ErrorAxis::kAspect, 2 * M_PI / sectors);
    }
    add(ErrorGroup::kPair, ErrorAxis::kRange, longest_range_m() / 8);
    return std::move(components_);
  }

 private:
  static std::uint64_t key_of(const ErrorSample::Row& row, ErrorGroup group) {
    const auto beacon = static_cast<std::uint64_t>(group == ErrorGroup::kReceiver ? 0 : row.beacon + 1);
    const auto receiver = static_cast<std::uint64_t>(group == ErrorGroup::kBeacon ? 0 : row.receiver + 1);
    return beacon << 32U | receiver;
  }

  static std::uint64_t mixed(std::uint64_t key, std::int64_t more) {
    return mixed_bits(key + 0x9e3779b97f4a7c15ULL * (static_cast<std::uint64_t>(more) + 0x1234567ULL));
  }

  static std::int64_t cell(double value, double extent, double shift) {
    return static_cast<std::int64_t>(std::floor(value / extent + shift));
  }

  static std::int64_t sector(double angle_rad, double extent_rad, double shift) {
    const auto sectors = static_cast<std::int64_t>(std::lround(2 * M_PI / extent_rad));
    return ((cell(angle_rad + M_PI, extent_rad, shift) % sectors) + sectors) % sectors;
  }

  static std::uint64_t key_of(const ErrorSample::Row& row, std::uint64_t group, ErrorAxis axis, double extent,
                              double shift) {
    switch (axis) {
      case ErrorAxis::kConstant: return mixed(group, 0);
      case ErrorAxis::kTime:
        return mixed(mixed(group, static_cast<std::int64_t>(row.run)), cell(row.time_s, extent, shift));
      case ErrorAxis::kPlace:
        return mixed(
            mixed(mixed(group, cell(row.p_map_m.x(), extent, shift)), cell(row.p_map_m.y(), extent, shift)),
            cell(row.p_map_m.z(), extent, shift));
      case ErrorAxis::kDirection: return mixed(group, sector(row.direction_rad, extent, shift));
      case ErrorAxis::kAspect: return mixed(group, sector(row.aspect_rad, extent, shift));
      case ErrorAxis::kRange: return mixed(group, cell(row.range_m, extent, shift));
    }
    return group;
  }

  void add(ErrorGroup group, ErrorAxis axis, double extent) {
    ErrorComponent& c = components_.emplace_back();
    c.part = {bearings_, group, axis, extent, 0.0};
    c.bearings = bearings_;
    const std::size_t shifts = axis == ErrorAxis::kConstant ? 1 : kShifts;
    for (std::size_t k = 0; k < shifts; ++k) {
      const double shift = static_cast<double>(k) / static_cast<double>(shifts);
      std::vector<std::uint64_t> keys;
      for (const ErrorSample::Row* row : rows_)
        keys.push_back(key_of(*row, key_of(*row, group), axis, extent, shift));
      std::int32_t count = 0;
      std::vector<std::int32_t> cells = numbered(keys, count);
      c.partitions.push_back(sums_.add(std::move(cells), count));
    }
  }

  [[nodiscard]] bool several_receivers() const {
    return std::ranges::any_of(
        rows_, [this](const ErrorSample::Row* row) { return row->receiver != rows_.front()->receiver; });
  }
  /// Median time between neighbours of a pair; 0 without neighbours.
  [[nodiscard]] double usual_step_s() const {
    const auto pair = [](const ErrorSample::Row* row) {
      return std::tuple(row->run, row->beacon, row->receiver);
    };
    std::vector<const ErrorSample::Row*> order = rows_;
    std::ranges::sort(order, {}, [&](const ErrorSample::Row* row) {
      return std::tuple_cat(pair(row), std::tuple(row->time_s));
    });
    std::vector<double> steps;
    for (std::size_t k = 1; k < order.size(); ++k)
      if (pair(order[k - 1]) == pair(order[k]) && order[k]->time_s > order[k - 1]->time_s)
        steps.push_back(order[k]->time_s - order[k - 1]->time_s);
    return median(std::move(steps));
  }
  [[nodiscard]] double longest_run_s() const {
    std::map<std::size_t, std::pair<double, double>> spans;  // of each run
    double longest = 0.0;
    for (const ErrorSample::Row* row : rows_) {
      auto& [from, to] = spans.try_emplace(row->run, row->time_s, row->time_s).first->second;
      from = std::min(from, row->time_s);
      to = std::max(to, row->time_s);
      longest = std::max(longest, to - from);
    }
    return longest;
  }
  [[nodiscard]] double path_size_m() const {
    Eigen::AlignedBox2d box;
    for (const ErrorSample::Row* row : rows_) box.extend(row->p_map_m.head<2>());
    return box.sizes().maxCoeff();
  }
  [[nodiscard]] double longest_range_m() const {
    double longest = 1e-6;
    for (const ErrorSample::Row* row : rows_) longest = std::max(longest, row->range_m);
    return longest;
  }

  bool bearings_;
  CellSums& sums_;
  std::vector<const ErrorSample::Row*> rows_;
  std::vector<ErrorComponent> components_;
};

}  // namespace

ErrorComponents::ErrorComponents(const ErrorSample& sample)
    : sums_{sums_of_kind(sample, ErrorSample::Kind::kArrival),
            sums_of_kind(sample, ErrorSample::Kind::kBearing)} {
  for (const bool bearings : {false, true})
    if (count(bearings) > 0) all_.push_back({{}, {}, bearings});
  whites_ = size();
  for (const bool bearings : {false, true}) {
    if (count(bearings) < kFewestObservations) continue;
    for (ErrorComponent& c : ComponentList(sample, bearings, sums_[bearings]).build())
      all_.push_back(std::move(c));
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
  some.reserve(kept.size());
  for (const Eigen::Index m : kept) some.push_back(std::move(all_[static_cast<std::size_t>(m)]));
  all_ = std::move(some);
}

template <class Next, class Put>
void ErrorComponents::draw_cells(const ErrorComponent& c, std::size_t draw, Next&& next, Put&& put) const {
  const std::vector<std::uint32_t>& rows = rows_of(c.bearings);
  if (c.is_white()) {
    for (const std::uint32_t row : rows) put(row, next());
    return;
  }
  const std::size_t partition = c.partitions[draw % c.partitions.size()];
  std::vector<decltype(next())> values(static_cast<std::size_t>(sums_[c.bearings].count(partition)));
  for (auto& value : values) value = next();
  const std::vector<std::int32_t>& cell = sums_[c.bearings].cells(partition);
  for (std::size_t i = 0; i < rows.size(); ++i) put(rows[i], values[static_cast<std::size_t>(cell[i])]);
}

void ErrorComponents::add_normal(Eigen::Index m, double sigma, std::size_t draw, DrawBits& random,
                                 std::vector<DrawLine>& errors) const {
  const auto normal = [&random] {
    DrawLine value;
    random.normal(value);
    return value;
  };
  draw_cells((*this)[m], draw, normal,
             [&errors, scale = static_cast<float>(sigma)](std::uint32_t row, const DrawLine& value) {
               for (std::size_t k = 0; k < kDrawsAbreast; ++k) errors[row].of[k] += scale * value.of[k];
             });
}

void ErrorComponents::set_signs(Eigen::Index m, std::size_t draw, std::size_t column, DrawBits& random,
                                std::vector<DrawLine>& errors) const {
  draw_cells((*this)[m], draw, [&random] { return (random.bits() >> 63U) != 0 ? 1.0F : -1.0F; },
             [&errors, column](std::uint32_t row, float sign) { errors[row].of[column] = sign; });
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
