// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/wiring.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace octant::calib {
namespace {

using Order = std::vector<std::size_t>;

constexpr std::size_t kAllOrders = 5;     ///< receivers up to which all orders are examined
constexpr std::size_t kAllExchanges = 8;  ///< receivers up to which all exchanges of two are examined

/// Collects different orders with their descriptions.
class WiringList {
 public:
  WiringList(const Site& site, VehicleId vehicle) : site_(site), vehicle_(site.vehicles[vehicle.index()]) {}

  [[nodiscard]] std::size_t size() const { return vehicle_.receiver_count; }
  [[nodiscard]] const std::string& name(std::size_t i) const { return receiver(i).name; }
  [[nodiscard]] const SiteReceiver& receiver(std::size_t i) const {
    return site_.receivers[vehicle_.first_receiver + i];
  }

  void add(Order order, const std::string& words) {
    const bool as_stated = std::ranges::is_sorted(order);
    const bool known = std::ranges::any_of(list_, [&](const Wiring& w) { return w.order == order; });
    if (!as_stated && !known) list_.push_back({std::move(order), words});
  }
  void exchange(std::size_t i, std::size_t j) {
    Order order = as_stated();
    std::swap(order[i], order[j]);
    add(std::move(order),
        fmt::format("receivers {} and {} of {} are exchanged", name(i), name(j), vehicle_.name));
  }
  void mirror() {
    if (const auto order = mirrored())
      add(*order, fmt::format("the receivers of {} are mirrored, left called right ({})", vehicle_.name,
                              pairs(*order)));
  }
  /// Orders that rotate the receivers along their azimuths by some positions, also in reverse.
  void turns() {
    const Order ring = by_azimuth();
    for (const bool reversed : {false, true})
      for (std::size_t shift = 0; shift < size(); ++shift) {
        Order order(size());
        for (std::size_t i = 0; i < size(); ++i)
          order[ring[i]] = ring[(reversed ? 2 * size() - i + shift : i + shift) % size()];
        const std::string how =
            reversed ? "mirrored"
                     : fmt::format("turned by {} of {} places", std::min(shift, size() - shift), size());
        const std::string words = fmt::format("the receivers of {} are {}, each is wired as another ({})",
                                              vehicle_.name, how, pairs(order));
        add(std::move(order), words);
      }
  }
  void all_orders() {
    Order order = as_stated();
    while (std::next_permutation(order.begin(), order.end()))
      add(order,
          fmt::format("the receivers of {} are wired in another order ({})", vehicle_.name, pairs(order)));
  }
  std::vector<Wiring> release() { return std::move(list_); }

 private:
  [[nodiscard]] Order as_stated() const {
    Order order(size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    return order;
  }

  [[nodiscard]] Eigen::Vector3d centre() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < size(); ++i) sum += receiver(i).position_m;
    return sum / static_cast<double>(size());
  }

  /// Order that maps each receiver to the one nearest to its mirrored position; no value if two would map to
  /// the same one.
  [[nodiscard]] std::optional<Order> mirrored() const {
    const Eigen::Vector3d middle = centre();
    Order order(size());
    std::vector<bool> taken(size(), false);
    for (std::size_t i = 0; i < size(); ++i) {
      Eigen::Vector3d image = receiver(i).position_m;
      image.y() = 2 * middle.y() - image.y();
      const auto off = [&](std::size_t j) { return (receiver(j).position_m - image).norm(); };
      for (std::size_t j = 1; j < size(); ++j)
        if (off(j) < off(order[i])) order[i] = j;
      if (taken[order[i]]) return {};
      taken[order[i]] = true;
    }
    return order;
  }

  [[nodiscard]] Order by_azimuth() const {
    const Eigen::Vector3d middle = centre();
    const auto azimuth = [&](std::size_t i) {
      const Eigen::Vector3d d = receiver(i).position_m - middle;
      return std::atan2(d.y(), d.x());
    };
    Order ring = as_stated();
    std::ranges::stable_sort(ring, [&](std::size_t a, std::size_t b) { return azimuth(a) < azimuth(b); });
    return ring;
  }

  [[nodiscard]] std::string pairs(const Order& order) const {
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < order.size(); ++i)
      if (order[i] != i) parts.push_back(fmt::format("{} is at the place of {}", name(i), name(order[i])));
    return fmt::format("{}", fmt::join(parts, ", "));
  }

  const Site& site_;
  const SiteVehicle& vehicle_;
  std::vector<Wiring> list_;
};

}  // namespace

bool Wiring::is_exchange() const {
  std::size_t elsewhere = 0;
  for (std::size_t i = 0; i < order.size(); ++i) elsewhere += order[i] != i;
  return elsewhere == 2 && order.size() > 2;
}

std::vector<Wiring> wirings(const Site& site, VehicleId vehicle, const std::vector<bool>& doubtful) {
  WiringList list(site, vehicle);
  if (list.size() < 2) return {};
  list.mirror();  // for two receivers this is their exchange
  const std::size_t first = site.vehicles[vehicle.index()].first_receiver;
  const auto may_be = [&](std::size_t i) {
    return list.size() <= kAllExchanges || doubtful.empty() || doubtful[first + i];
  };
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t j = i + 1; j < list.size(); ++j)
      if (may_be(i) && may_be(j)) list.exchange(i, j);
  list.turns();
  if (list.size() <= kAllOrders) list.all_orders();
  return list.release();
}

std::vector<bool> doubtful_receivers(const Site& site, const std::vector<Trajectory>& trajectories) {
  std::vector<double> used(site.receivers.size(), 0.0), all = used, share = used;
  for (const Trajectory& t : trajectories)
    for (const ArrivalObservation& a : t.arrivals) {
      all[a.receiver.index()] += 1;
      used[a.receiver.index()] += a.rejection == Rejection::kUsed;
    }
  for (std::size_t r = 0; r < share.size(); ++r) share[r] = all[r] > 0 ? used[r] / all[r] : 1.0;
  std::vector<double> sorted = share;
  std::ranges::sort(sorted);
  constexpr std::size_t kMost = 6;
  std::vector<bool> doubtful;
  doubtful.reserve(share.size());
  for (const double s : share) doubtful.push_back(sorted.size() <= kMost || s <= sorted[kMost - 1]);
  return doubtful;
}

Site rewired(const Site& site, VehicleId vehicle, const Wiring& wiring) {
  Site other = site;
  const std::size_t first = site.vehicles[vehicle.index()].first_receiver;
  for (std::size_t i = 0; i < wiring.order.size(); ++i) {
    SiteReceiver& receiver = other.receivers[first + i];
    const SiteReceiver& at = site.receivers[first + wiring.order[i]];
    receiver.position_m = at.position_m;
    receiver.sigma_m = at.sigma_m;
    receiver.axis = at.axis;
  }
  return other;
}

}  // namespace octant::calib
