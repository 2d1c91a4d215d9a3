// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>

#include "calib/calibrate.h"
#include "models/trajectory/linearise.h"

namespace octant::test {

/// The textbook way: one dense Jacobian of all observations by all unknowns, by central differences of the
/// residuals, and the orthogonal projector onto its columns. For problems of some thousand rows.
class DenseAdjustment {
 public:
  struct Row {
    enum Kind { kTof, kAmplitude, kBearing, kPose, kOdometry, kPrior } kind = kTof;
    std::size_t trajectory = 0, index = 0;  ///< into the trajectory's list of its kind
    BeaconId beacon;
  };

  DenseAdjustment(const calib::Problem& problem, const calib::Solution& solution)
      : site_(problem.site),
        state_(solution.state),
        mean_(prior_state(problem.site)),
        trajectories_(solution.trajectories) {
    list_parameters();
    const Eigen::VectorXd at_rest = residuals(&rows);
    residual = at_rest;
    std::vector<Eigen::VectorXd> columns;
    for (const auto& p : parameters_) {
      columns.push_back(derivative([&](double step) { *p.value += step; }, p.step));
      if (p.beacon_coordinate) beacon_coordinates_.push_back(static_cast<Eigen::Index>(columns.size()) - 1);
    }
    for (Trajectory& t : trajectories_)
      for (Node& node : t.nodes) {
        if (!node.placed) continue;
        const int dof = pose_dof(t.motion);
        for (int i = 0; i < dof; ++i) {
          const Pose keep = node.T_map_vehicle;
          columns.push_back(derivative(
              [&](double step) {
                node.T_map_vehicle =
                    step == 0 ? keep : retract(keep, step * Eigen::VectorXd::Unit(dof, i), t.motion);
              },
              1e-5, true));
        }
        if (t.has_cycle_offset)
          columns.push_back(derivative([&](double step) { node.cycle_offset_s += step; }, 1e-8));
      }
    Eigen::MatrixXd J(at_rest.size(), static_cast<Eigen::Index>(columns.size()));
    scale_.resize(J.cols());
    for (Eigen::Index i = 0; i < J.cols(); ++i) {
      scale_[i] = std::max(columns[static_cast<std::size_t>(i)].norm(), 1e-12);
      J.col(i) = columns[static_cast<std::size_t>(i)] / scale_[i];
    }
    qr_.setThreshold(1e-8);
    qr_.compute(J);
    Q_ = qr_.householderQ() * Eigen::MatrixXd::Identity(J.rows(), qr_.rank());
  }

  std::vector<Row> rows;
  Eigen::VectorXd residual;

  [[nodiscard]] Eigen::Index rank() const { return qr_.rank(); }
  [[nodiscard]] double leverage(std::size_t row) const {
    return Q_.row(static_cast<Eigen::Index>(row)).squaredNorm();
  }
  /// I - H
  [[nodiscard]] Eigen::MatrixXd residual_projector() const {
    return Eigen::MatrixXd::Identity(Q_.rows(), Q_.rows()) - Q_ * Q_.transpose();
  }
  [[nodiscard]] Eigen::VectorXd residuals_of(const Eigen::VectorXd& error) const {
    return error - Q_ * (Q_.transpose() * error);
  }
  /// Largest shift of a free beacon coordinate by errors of the observations (in sigmas), of a problem of
  /// full rank.
  [[nodiscard]] double beacon_shift_m(const Eigen::VectorXd& error) const {
    const Eigen::VectorXd x = qr_.solve(error);
    double largest = 0.0;
    for (const Eigen::Index i : beacon_coordinates_) largest = std::max(largest, std::abs(x[i] / scale_[i]));
    return largest;
  }
  [[nodiscard]] double sigma_s(const Row& row) const {
    return trajectories_[row.trajectory].arrivals[row.index].sigma_s;
  }
  [[nodiscard]] std::size_t arrival(const Row& row) const {
    return trajectories_[row.trajectory].arrivals[row.index].arrival;
  }

 private:
  struct Parameter {
    double* value;
    double step;
    double mean, sigma;
    bool beacon_coordinate = false;
  };

  void add(double& value, double step, double mean, double sigma, bool coordinate = false) {
    if (sigma > 0) parameters_.push_back({&value, step, mean, sigma, coordinate});
  }

  void list_parameters() {
    const double delay_sigma = site_.timing.delay_sigma_s;
    for (std::size_t b = 0; b < site_.beacons.size(); ++b)
      for (int i = 0; i < 3; ++i) {
        const auto at = static_cast<std::size_t>(i);
        add(state_.beacon_p_map_m[b][i], 1e-5, site_.beacons[b].position_m[at].value_or(0.0),
            site_.beacons[b].position_m[at] ? site_.beacons[b].sigma_m[at].value_or(INFINITY) : INFINITY,
            true);
      }
    for (std::size_t b = 0; b < site_.beacons.size() && site_.timing.delay_per.beacon; ++b)
      add(state_.beacon_delay_s[b], 1e-8, mean_.beacon_delay_s[b], delay_sigma);
    for (std::size_t r = 0; r < site_.receivers.size() && site_.timing.delay_per.receiver; ++r)
      add(state_.receiver_delay_s[r], 1e-8, mean_.receiver_delay_s[r], delay_sigma);
    if (site_.timing.delay_per.site) add(state_.site_delay_s, 1e-8, mean_.site_delay_s, delay_sigma);
    add(state_.speed_offset_mps[0], 1e-4, 0.0, site_.speed_sigma_mps);
    for (std::size_t r = 0; r < site_.receivers.size(); ++r)
      for (int i = 0; i < 3; ++i)
        add(state_.receiver_p_vehicle_m[r][i], 1e-5, site_.receivers[r].position_m[i],
            site_.receivers[r].sigma_m[i]);
    if (!state_.attenuation) return;
    add(state_.attenuation->amplitude_1m_v, 1e-4, site_.attenuation->amplitude_1m_v.value,
        site_.attenuation->amplitude_1m_v.sigma);
    add(state_.attenuation->absorption_np_per_m, 1e-5, site_.attenuation->absorption_np_per_m.value,
        site_.attenuation->absorption_np_per_m.sigma);
    add(state_.attenuation->rise_time_s, 1e-7, site_.attenuation->rise_time_s.value,
        site_.attenuation->rise_time_s.sigma);
  }

  Eigen::VectorXd derivative(const std::function<void(double)>& move, double step, bool absolute = false) {
    move(step);
    const Eigen::VectorXd above = residuals(nullptr);
    move(absolute ? -step : -2 * step);
    const Eigen::VectorXd below = residuals(nullptr);
    move(absolute ? 0.0 : step);
    return (above - below) / (2 * step);
  }

  Eigen::VectorXd residuals(std::vector<Row>* list) const {
    std::vector<double> out;
    static constexpr Row::Kind kKind[] = {Row::kTof, Row::kAmplitude, Row::kBearing, Row::kPose,
                                          Row::kOdometry};
    for (std::size_t i = 0; i < trajectories_.size(); ++i)
      for (const Segment& segment : trajectories_[i].segments) {
        if (!trajectories_[i].nodes[segment.first_node].placed) continue;
        for_each_row(trajectories_[i], segment, state_, [&](const ObservationRow& row) {
          out.push_back(row.residual);
          if (list != nullptr)
            list->push_back(
                {kKind[static_cast<int>(row.kind)], i, row.index, row.has_shared ? row.beacon : BeaconId()});
        });
      }
    for (const Parameter& p : parameters_) {
      if (!std::isfinite(p.sigma)) continue;
      out.push_back((*p.value - p.mean) / p.sigma);
      if (list != nullptr) list->push_back({Row::kPrior, 0, 0, BeaconId()});
    }
    return Eigen::Map<Eigen::VectorXd>(out.data(), static_cast<Eigen::Index>(out.size()));
  }

  Site site_;
  SharedState state_, mean_;
  std::vector<Trajectory> trajectories_;
  std::vector<Parameter> parameters_;
  std::vector<Eigen::Index> beacon_coordinates_;
  Eigen::VectorXd scale_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
  Eigen::MatrixXd Q_;
};

}  // namespace octant::test
