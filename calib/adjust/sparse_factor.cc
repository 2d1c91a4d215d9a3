// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/sparse_factor.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <vector>

#include <cholmod.h>

namespace octant::calib {

struct SparseFactor::Parts {
  Parts() {
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.print = 0;
    common.quick_return_if_not_posdef = 1;
  }
  ~Parts() {
    cholmod_free_factor(&L, &common);
    cholmod_finish(&common);
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  mutable cholmod_common common{};
  cholmod_factor* L = nullptr;
  std::vector<int> place;       ///< of each row in the elimination order
  std::vector<int> supernode;   ///< of each column in that order
  std::vector<double> inverse;  ///< laid out as L

  [[nodiscard]] std::size_t supernodes() const { return L->nsuper; }
  [[nodiscard]] int first(std::size_t k) const { return static_cast<const int*>(L->super)[k]; }
  [[nodiscard]] int columns(std::size_t k) const { return first(k + 1) - first(k); }
  [[nodiscard]] const int* rows(std::size_t k) const {
    return static_cast<const int*>(L->s) + static_cast<const int*>(L->pi)[k];
  }
  [[nodiscard]] int row_count(std::size_t k) const {
    return static_cast<const int*>(L->pi)[k + 1] - static_cast<const int*>(L->pi)[k];
  }
  [[nodiscard]] std::size_t values_at(std::size_t k) const {
    return static_cast<std::size_t>(static_cast<const int*>(L->px)[k]);
  }
  [[nodiscard]] const double* values(std::size_t k) const {
    return static_cast<const double*>(L->x) + values_at(k);
  }
};

std::unique_ptr<SparseFactor> SparseFactor::of(const Eigen::SparseMatrix<double>& matrix) {
  auto parts = std::make_unique<Parts>();
  const auto n = static_cast<std::size_t>(matrix.rows());
  // CHOLMOD reads the lower triangle of what it is shown and writes nothing.
  cholmod_sparse view{};
  view.nrow = view.ncol = n;
  view.nzmax = static_cast<std::size_t>(matrix.nonZeros());
  view.p = const_cast<int*>(matrix.outerIndexPtr());
  view.i = const_cast<int*>(matrix.innerIndexPtr());
  view.x = const_cast<double*>(matrix.valuePtr());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;
  parts->L = cholmod_analyze(&view, &parts->common);
  if (parts->L == nullptr) throw std::bad_alloc();
  cholmod_factorize(&view, parts->L, &parts->common);
  if (parts->common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  if (parts->common.status != CHOLMOD_OK || parts->L->minor < n || parts->L->is_super == 0) return nullptr;
  parts->place.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    parts->place[static_cast<std::size_t>(static_cast<const int*>(parts->L->Perm)[i])] = static_cast<int>(i);
  parts->supernode.resize(n);
  for (std::size_t k = 0; k < parts->supernodes(); ++k)
    std::fill(parts->supernode.begin() + parts->first(k), parts->supernode.begin() + parts->first(k + 1),
              static_cast<int>(k));
  return std::unique_ptr<SparseFactor>(new SparseFactor(std::move(parts)));
}

SparseFactor::SparseFactor(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) { invert(); }
SparseFactor::~SparseFactor() = default;

/// Z_PP, lower triangle, of the rows below a supernode's diagonal block. They are ascending, and those behind
/// one of them stand among the rows of its own supernode.
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
  const std::size_t count = parts_->supernodes();
  parts_->inverse.assign(count == 0 ? 0 : parts_->L->xsize, 0.0);
  for (std::size_t k = count; k-- > 0;) {
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

Eigen::MatrixXd SparseFactor::solve(const Eigen::MatrixXd& rhs) const {
  cholmod_dense view{};
  view.nrow = view.d = static_cast<std::size_t>(rhs.rows());
  view.ncol = static_cast<std::size_t>(rhs.cols());
  view.nzmax = static_cast<std::size_t>(rhs.size());
  view.x = const_cast<double*>(rhs.data());
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* x = cholmod_solve(CHOLMOD_A, parts_->L, &view, &parts_->common);
  if (x == nullptr) throw std::bad_alloc();
  Eigen::MatrixXd out =
      Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(x->x), rhs.rows(), rhs.cols());
  cholmod_free_dense(&x, &parts_->common);
  return out;
}

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
