// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/sparse_factor.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <vector>

#include <Eigen/CholmodSupport>

namespace octant::calib {

/// Eigen's hold on CHOLMOD, with a view into the supernodes of the factor.
class SparseFactor::Parts : public Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> {
 public:
  explicit Parts(const Eigen::SparseMatrix<double>& matrix) {
    cholmod().print = 0;
    cholmod().quick_return_if_not_posdef = 1;
    analyzePattern(matrix);
    if (m_cholmodFactor == nullptr) throw std::bad_alloc();
    factorize(matrix);
    if (info() != Eigen::Success) return;
    const auto n = static_cast<std::size_t>(matrix.rows());
    place.resize(n);
    for (std::size_t i = 0; i < n; ++i)
      place[static_cast<std::size_t>(static_cast<const int*>(m_cholmodFactor->Perm)[i])] =
          static_cast<int>(i);
    supernode.resize(n);
    for (std::size_t k = 0; k < supernodes(); ++k)
      std::fill(supernode.begin() + first(k), supernode.begin() + first(k + 1), static_cast<int>(k));
    inverse.assign(n == 0 ? 0 : m_cholmodFactor->xsize, 0.0);
  }

  std::vector<int> place;       ///< position of each row in the elimination order
  std::vector<int> supernode;   ///< supernode of each column in that order
  std::vector<double> inverse;  ///< stored as L

  [[nodiscard]] std::size_t supernodes() const { return m_cholmodFactor->nsuper; }
  [[nodiscard]] int first(std::size_t k) const { return static_cast<const int*>(m_cholmodFactor->super)[k]; }
  [[nodiscard]] int columns(std::size_t k) const { return first(k + 1) - first(k); }
  [[nodiscard]] const int* rows(std::size_t k) const {
    return static_cast<const int*>(m_cholmodFactor->s) + first_row(k);
  }
  [[nodiscard]] int row_count(std::size_t k) const { return first_row(k + 1) - first_row(k); }
  [[nodiscard]] std::size_t values_at(std::size_t k) const {
    return static_cast<std::size_t>(static_cast<const int*>(m_cholmodFactor->px)[k]);
  }
  [[nodiscard]] const double* values(std::size_t k) const {
    return static_cast<const double*>(m_cholmodFactor->x) + values_at(k);
  }

 private:
  [[nodiscard]] int first_row(std::size_t k) const { return static_cast<const int*>(m_cholmodFactor->pi)[k]; }
};

std::unique_ptr<SparseFactor> SparseFactor::of(const Eigen::SparseMatrix<double>& matrix) {
  auto parts = std::make_unique<Parts>(matrix);
  if (parts->info() != Eigen::Success) return nullptr;
  return std::unique_ptr<SparseFactor>(new SparseFactor(std::move(parts)));
}

SparseFactor::SparseFactor(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) { invert(); }

SparseFactor::~SparseFactor() = default;

/// Z_PP, lower triangle, for the rows below a supernode's diagonal block. They are ascending, and the rows
/// after each of them are among those of its own supernode.
Eigen::MatrixXd SparseFactor::gather(const std::vector<int>& P) const {
  const auto p = static_cast<Eigen::Index>(P.size());
  Eigen::MatrixXd Z(p, p);
  std::vector<int> at(P.size());
  for (std::size_t t = 0; t < P.size();) {
    const auto k = static_cast<std::size_t>(parts_->supernode[static_cast<std::size_t>(P[t])]);
    const int* rows = parts_->rows(k);
    int r = 0;
    for (std::size_t u = t; u < P.size(); ++u) {
      while (rows[r] < P[u]) ++r;
      at[u] = r;
    }
    for (; t < P.size() && P[t] < parts_->first(k + 1); ++t) {
      const double* column =
          parts_->inverse.data() + parts_->values_at(k) +
          static_cast<std::size_t>(P[t] - parts_->first(k)) * static_cast<std::size_t>(parts_->row_count(k));
      for (std::size_t u = t; u < P.size(); ++u)
        Z(static_cast<Eigen::Index>(u), static_cast<Eigen::Index>(t)) = column[at[u]];
    }
  }
  return Z;
}

void SparseFactor::invert() {
  for (std::size_t k = parts_->supernodes(); k-- > 0;) {
    const Eigen::Index columns = parts_->columns(k), rows = parts_->row_count(k), below = rows - columns;
    const Eigen::Map<const Eigen::MatrixXd> L(parts_->values(k), rows, columns);
    Eigen::Map<Eigen::MatrixXd> Z(parts_->inverse.data() + parts_->values_at(k), rows, columns);
    const auto L11 = L.topRows(columns).triangularView<Eigen::Lower>();
    const Eigen::MatrixXd root = L11.solve(Eigen::MatrixXd::Identity(columns, columns));
    Z.topRows(columns).noalias() = root.transpose() * root;
    if (below == 0) continue;
    const Eigen::MatrixXd Y = L.bottomRows(below) * root;
    const std::vector<int> P(parts_->rows(k) + columns, parts_->rows(k) + rows);
    Z.bottomRows(below).noalias() = -(gather(P).selfadjointView<Eigen::Lower>() * Y);
    Z.topRows(columns).noalias() -= Y.transpose() * Z.bottomRows(below);
  }
}

double SparseFactor::condition() const {
  double least = INFINITY, most = 0.0;
  for (std::size_t k = 0; k < parts_->supernodes(); ++k)
    for (int c = 0; c < parts_->columns(k); ++c) {
      const double pivot =
          parts_->values(k)[static_cast<std::size_t>(c) * static_cast<std::size_t>(parts_->row_count(k) + 1)];
      least = std::min(least, pivot * pivot);
      most = std::max(most, pivot * pivot);
    }
  return most > 0 ? least / most : 0.0;
}

Eigen::MatrixXd SparseFactor::solve(const Eigen::MatrixXd& rhs) const { return parts_->solve(rhs); }

std::optional<double> SparseFactor::inverse(Eigen::Index i, Eigen::Index j) const {
  const int a = parts_->place[static_cast<std::size_t>(i)], b = parts_->place[static_cast<std::size_t>(j)];
  const int column = std::min(a, b), row = std::max(a, b);
  const auto k = static_cast<std::size_t>(parts_->supernode[static_cast<std::size_t>(column)]);
  const int *begin = parts_->rows(k), *end = begin + parts_->row_count(k),
            *at = std::lower_bound(begin, end, row);
  if (at == end || *at != row) return {};
  return parts_->inverse[parts_->values_at(k) +
                         static_cast<std::size_t>(column - parts_->first(k)) *
                             static_cast<std::size_t>(parts_->row_count(k)) +
                         static_cast<std::size_t>(at - begin)];
}

}  // namespace octant::calib
