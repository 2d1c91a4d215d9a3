// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to chain_reduction.cc: the normal equations of one segment.

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

#include <Eigen/Core>

#include "calib/chain/chain_kernel.h"
#include "calib/lanes/stop_block.h"

namespace octant::calib::chain {

inline constexpr std::size_t kDoublesPerWindow =
    16384;  ///< numbers of the border: half of a second-level cache

/// Memory on whole vectors.
class AlignedDoubles {
 public:
  void assign_zero(std::size_t count) {
    if (count > size_) {
      data_.reset(new (std::align_val_t(kVectorBytes)) double[count]);
      size_ = count;
    }
    std::fill(data_.get(), data_.get() + count, 0.0);
  }
  [[nodiscard]] double* data() const { return data_.get(); }

 private:
  static constexpr std::size_t kVectorBytes = 64;
  struct AlignedDelete {
    void operator()(double* data) const { ::operator delete[](data, std::align_val_t(kVectorBytes)); }
  };
  std::unique_ptr<double[], AlignedDelete> data_;  // NOLINT(modernize-avoid-c-arrays)
  std::size_t size_ = 0;
};

/// States [first, last) of a segment, counted from its first, between two ends that stay.
struct Stretch {
  bool has_left = false, has_right = false;  ///< the state before `first`, that at `last`
  std::size_t first = 0, last = 0;
  [[nodiscard]] std::size_t begin() const { return first - (has_left ? 1 : 0); }
};

/// Reduced system of a segment: its border consists of the parameters in it, the left end, and the gradient.
struct ReducedStretch {
  double cost = 0.0;         ///< cost of its rows at the present states
  std::vector<int> columns;  ///< columns of the system, ascending
  std::size_t width = 0;
  AlignedDoubles H;  ///< width x width, lower triangle; the gradient's own: less twice what states gain
  std::vector<double> D, G;  ///< blocks of the right end
  [[nodiscard]] std::size_t left() const { return columns.size(); }
  [[nodiscard]] std::size_t gradient(std::size_t block) const { return columns.size() + block; }
};

/// The derivatives of one row that are not by a state.
struct RowBorder {
  int count = 0;
  std::array<int, 20> at;  ///< positions in the segment, ascending
  std::array<double, 20> value;
};

/// Blocks of some states of a segment, which are eliminated together, and of the border.
struct WindowMemory {
  AlignedDoubles D, U, G;
  std::vector<char> is_plain;
};

/// Normal equations of a segment: rows are added state by state, and a state is eliminated when its window is
/// full.
template <int N>
class StretchWindow {
 public:
  static constexpr std::size_t n = N;

  StretchWindow(WindowMemory& memory, const Stretch& stretch, ReducedStretch& out)
      : memory_(memory),
        out_(out),
        gradient_(out.gradient(stretch.has_left ? n : 0)),
        width_((gradient_ + kBorderPad) / kBorderPad * kBorderPad),
        slots_(std::min(std::clamp<std::size_t>(kDoublesPerWindow / (n * width_), 4, 64),
                        stretch.last - stretch.first)) {
    out.width = width_;
    out.H.assign_zero(width_ * width_);
    memory_.D.assign_zero((slots_ + 1) * n * n);
    memory_.U.assign_zero(slots_ * n * n);
    memory_.G.assign_zero((slots_ + 1) * n * width_);
    memory_.is_plain.assign(slots_ + 1, 1);
  }

  /// The rows that follow belong to the left end, which is part of the border.
  void begin_left() { is_left_ = true; }
  /// They belong to the next state.
  void begin_state() {
    is_left_ = false;
    if (used_ == slots_) {
      eliminate_slots(0.0);
      pass_on();
    }
    slot_ = used_++;
  }
  /// No more states.
  /// @param floor_of_last  as `eliminate`
  void finish(bool has_right, double floor_of_last) {
    eliminate_slots(floor_of_last);
    if (!has_right) return;
    out_.D.assign(D(used_), D(used_) + n * n);
    out_.G.assign(G(used_), G(used_) + n * width_);
  }

  /// @param a, b  derivatives by the state and, where there is one, by the next
  void add_row(double residual, double w, const double* a, const double* b, const RowBorder& border) {
    const auto count = static_cast<std::size_t>(border.count);
    double* const gradient = H(gradient_);
    for (std::size_t i = 0; i < count; ++i) {
      const double wi = w * border.value[i];
      double* const row = H(static_cast<std::size_t>(border.at[i]));
      for (std::size_t j = 0; j <= i; ++j) row[border.at[j]] += wi * border.value[j];
      gradient[border.at[i]] += wi * residual;
    }
    if (!is_left_ && b != nullptr) {
      add_states(w, residual, a, b, border);
      return;
    }
    if (is_left_) {
      for (std::size_t i = 0; i < n; ++i) {
        double* const row = H(out_.left() + i);
        const double wa = w * a[i];
        for (std::size_t j = 0; j < count; ++j) row[border.at[j]] += wa * border.value[j];
        for (std::size_t j = 0; j <= i; ++j) row[out_.left() + j] += wa * a[j];
        gradient[out_.left() + i] += wa * residual;
      }
    } else {
      add_state(slot_, w, residual, a, border);
    }
    if (b == nullptr) return;
    add_state(0, w, residual, b, border);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) G(0)[i * width_ + out_.left() + j] += w * b[i] * a[j];
  }

  /// An odometry step, which adds its normal equations by
  ///   add_to(block of this state, its gradient, block of both, block of the next, its gradient)
  template <class Step>
  void add_step(const Step& step) {
    if (!is_left_) {
      Block A(D(slot_)), C(U(slot_)), B(D(slot_ + 1));
      GradientColumn a{G(slot_) + gradient_, width_}, b{G(slot_ + 1) + gradient_, width_};
      step.add_to(A, a, C, B, b);
      return;
    }
    Eigen::Matrix<double, N, N> A = Eigen::Matrix<double, N, N>::Zero(), C = A;
    Eigen::Matrix<double, N, 1> a = Eigen::Matrix<double, N, 1>::Zero();
    Block B(D(0));
    GradientColumn b{G(0) + gradient_, width_};
    step.add_to(A, a, C, B, b);
    for (Eigen::Index i = 0; i < N; ++i) {
      const auto r = static_cast<std::size_t>(i);
      double *const row = H(out_.left() + r) + out_.left(), *const next = G(0) + r * width_ + out_.left();
      for (Eigen::Index j = 0; j < N; ++j) {
        if (j <= i) row[j] += A(i, j);
        next[j] += C(j, i);
      }
      H(gradient_)[out_.left() + r] += a[i];
    }
  }

 private:
  using Block = Eigen::Map<Eigen::Matrix<double, N, N, Eigen::RowMajor>>;
  /// A column of the border.
  struct GradientColumn {
    double* first;
    std::size_t stride;
    double& operator[](std::size_t i) { return first[i * stride]; }
  };

  [[nodiscard]] double* D(std::size_t slot) const { return memory_.D.data() + slot * n * n; }
  [[nodiscard]] double* U(std::size_t slot) const { return memory_.U.data() + slot * n * n; }
  [[nodiscard]] double* G(std::size_t slot) const { return memory_.G.data() + slot * n * width_; }
  [[nodiscard]] double* H(std::size_t row) const { return out_.H.data() + row * width_; }

  void eliminate_slots(double floor_of_last) {
    memory_.is_plain[0] = 0;  // it has what came from the states before
    eliminate({N, used_, width_, D(0), U(0), G(0), H(0), memory_.is_plain.data(), gradient_}, floor_of_last,
              kUnobservedFloor);
  }
  /// The state behind the window becomes its first.
  void pass_on() {
    std::memcpy(D(0), D(used_), n * n * sizeof(double));
    std::memcpy(G(0), G(used_), n * width_ * sizeof(double));
    std::fill(D(1), D(slots_ + 1), 0.0);
    std::fill(U(0), U(slots_), 0.0);
    std::fill(G(1), G(slots_ + 1), 0.0);
    std::ranges::fill(memory_.is_plain, 1);
    used_ = 0;
  }

  /// Two states of the window.
  void add_states(double w, double residual, const double* a, const double* b, const RowBorder& border) {
    double *const D_a = D(slot_), *const D_b = D(slot_ + 1), *const U_ab = U(slot_);
    double *const G_a = G(slot_), *const G_b = G(slot_ + 1);
    if (border.count > 0) memory_.is_plain[slot_] = memory_.is_plain[slot_ + 1] = 0;
    double wa[N], wb[N];
    for (std::size_t i = 0; i < n; ++i) {
      wa[i] = w * a[i];
      wb[i] = w * b[i];
      for (std::size_t j = 0; j < n; ++j) {
        D_a[i * n + j] += wa[i] * a[j];
        U_ab[i * n + j] += wa[i] * b[j];
        D_b[i * n + j] += wb[i] * b[j];
      }
      G_a[i * width_ + gradient_] += wa[i] * residual;
      G_b[i * width_ + gradient_] += wb[i] * residual;
    }
    for (std::size_t j = 0; j < static_cast<std::size_t>(border.count); ++j) {
      const double value = border.value[j];
      double *const to_a = G_a + border.at[j], *const to_b = G_b + border.at[j];
      for (std::size_t i = 0; i < n; ++i) {
        to_a[i * width_] += wa[i] * value;
        to_b[i * width_] += wb[i] * value;
      }
    }
  }
  void add_state(std::size_t slot, double w, double residual, const double* a, const RowBorder& border) {
    if (border.count > 0) memory_.is_plain[slot] = 0;
    double* const block = D(slot);
    for (std::size_t i = 0; i < n; ++i) {
      const double wa = w * a[i];
      for (std::size_t j = 0; j < n; ++j) block[i * n + j] += wa * a[j];
      double* const row = G(slot) + i * width_;
      for (std::size_t j = 0; j < static_cast<std::size_t>(border.count); ++j)
        row[border.at[j]] += wa * border.value[j];
      row[gradient_] += wa * residual;
    }
  }

  WindowMemory& memory_;
  ReducedStretch& out_;
  std::size_t gradient_, width_, slots_;
  std::size_t used_ = 0, slot_ = 0;
  bool is_left_ = false;
};

}  // namespace octant::calib::chain
