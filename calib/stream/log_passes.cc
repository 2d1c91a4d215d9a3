// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/log_passes.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include "calib/adjust/reject.h"
#include "calib/adjust/tile_sum.h"
#include "calib/problem/flips.h"
#include "calib/problem/gates.h"
#include "calib/problem/log_tape.h"
#include "calib/problem/ranges.h"
#include "calib/problem/thin.h"
#include "calib/stream/long_log.h"
#include "calib/verdict/validity.h"

namespace octant::calib {
namespace {

/// An arrival in work: its row, its observation, its place in a tile and what comes and goes.
constexpr std::size_t kBytesInWork = 240;
/// More than these at once are no faster.
constexpr std::size_t kMostInChunk = std::size_t{1} << 18;

constexpr std::size_t kBesideChunks = std::size_t{200} << 20;

/// Systems of chunks, added up in their order, whoever is first.
class OrderedSum {
 public:
  OrderedSum(std::size_t first, int size) : next_(first) {
    sum_.H.setZero(size, size);
    sum_.gradient.setZero(size);
  }
  void add(std::size_t chunk, const ReducedSystem& system) {
    const std::lock_guard lock(mutex_);
    if (chunk != next_) {
      waiting_.emplace(chunk, system);
      return;
    }
    take(system);
    for (auto at = waiting_.find(next_); at != waiting_.end(); at = waiting_.find(next_)) {
      take(at->second);
      waiting_.erase(at);
    }
  }
  ReducedSystem sum() && { return std::move(sum_); }

 private:
  void take(const ReducedSystem& system) {
    sum_.cost += system.cost;
    sum_.H += system.H;
    sum_.gradient += system.gradient;
    ++next_;
  }
  std::mutex mutex_;
  std::size_t next_;
  ReducedSystem sum_;
  std::map<std::size_t, ReducedSystem> waiting_;
};

}  // namespace

StreamPlan stream_plan(std::size_t memory_bytes, int threads) {
  // Something is left for what remains of the readings, and for the epochs that are looked at one by one.
  memory_bytes -= std::min(memory_bytes / 2, kBesideChunks);
  StreamPlan plan;
  plan.chunk_arrivals = std::clamp<std::size_t>(memory_bytes / 8 / kBytesInWork, 1, kMostInChunk);
  plan.workers =
      static_cast<int>(std::clamp<std::size_t>(memory_bytes / 2 / (plan.chunk_arrivals * kBytesInWork), 1,
                                               static_cast<std::size_t>(std::max(threads, 1))));
  return plan;
}

/// What a worker has at hand.
struct LogPasses::Work {
  const LogChunk* chunk = nullptr;
  MeasurementLog log;
  std::vector<Trajectory> trajectories;
  ReducedSystem system;
};

/// What remains of a chunk, trajectory by trajectory.
struct LogPasses::Stops {
  std::vector<std::array<double, 3>> pose;  ///< x, y, heading; NaN: no place
  std::vector<float> start_heading_rad;
  std::vector<Rejection> marks;  ///< of the arrivals
};

LogPasses::LogPasses(const Problem& frame, const ArrivalSource& source, const LogIndex& index,
                     const SolveOptions& options, int workers, Course& course)
    : frame_(frame),
      source_(source),
      index_(index),
      options_(options),
      course_(course),
      model_(trajectory_model(frame.site)),
      stops_(index.chunks().size()) {
  const std::size_t chunks = index.chunks().size();
  const auto count = static_cast<std::size_t>(options.ranks != nullptr ? options.ranks->count() : 1);
  const auto rank = static_cast<std::size_t>(options.ranks != nullptr ? options.ranks->index() : 0);
  first_ = rank * chunks / count;
  last_ = (rank + 1) * chunks / count;
  for (int i = 0; i < workers; ++i) workers_.push_back(std::make_unique<Work>());
}

LogPasses::~LogPasses() = default;

/// work(chunk, Work&) -> Result<void>, with the chunk loaded. The caller's thread is one of those that work.
template <class Do>
Result<void> LogPasses::for_each_chunk_of_mine(Do&& work) {
  std::atomic<std::size_t> next{first_};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::optional<Error> error;
  std::exception_ptr failure;
  const auto loop = [&](Work& w, bool reports) {
    try {
      for (std::size_t k = next.fetch_add(1); k < last_ && !stop; k = next.fetch_add(1)) {
        Result<void> done = load(k, w);
        if (done) work(k, w);
        if (done && reports && !course_.go_on())
          done = fail({.code = Errc::kInterrupted, .found = "interrupted"});
        if (done) continue;
        stop = true;
        const std::lock_guard lock(mutex);
        if (!error) error = done.error();
      }
    } catch (...) {
      stop = true;
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < workers_.size() && first_ + i < last_; ++i)
    others.emplace_back([&, i] { loop(*workers_[i], false); });
  loop(*workers_[0], true);
  for (std::thread& thread : others) thread.join();
  if (failure) std::rethrow_exception(failure);
  if (error) return fail(*error);
  if (!course_.go_on()) return fail({.code = Errc::kInterrupted, .found = "interrupted"});
  return {};
}

Result<void> LogPasses::load(std::size_t chunk, Work& w) const {
  const LogChunk& c = index_.chunks()[chunk];
  if (w.chunk == nullptr || w.chunk->run != c.run) {
    std::vector<Arrival> room = std::move(w.log.arrivals);
    w.log = without_lists(source_.log(c.run));
    w.log.arrivals = std::move(room);
  }
  w.chunk = &c;
  if (auto ok = index_.read(source_, c.run, c.first_block, c.last_block, w.log.arrivals); !ok) return ok;
  w.trajectories.clear();
  for (std::size_t v = 0; v < c.arrivals.size(); ++v) {
    if (c.arrivals[v] == 0) continue;
    w.trajectories.push_back(make_trajectory(w.log, c.run, VehicleId(v), model_));
    if (w.trajectories.back().arrivals.size() == c.arrivals[v] &&
        w.trajectories.back().nodes.size() == c.epochs[v])
      continue;
    return fail({.file = w.log.path + "/tof.csv",
                 .found = "the file has changed while it was read",
                 .expected = "the same rows each time, as a log of this size is read several times",
                 .advice = "calibrate with a copy, or when the recording is over"});
  }
  return {};
}

void LogPasses::restore(const Stops& stops, double sigma_s, Work& w) const {
  std::size_t node = 0, arrival = 0;
  for (Trajectory& t : w.trajectories) {
    for (Node& n : t.nodes) {
      const auto& [x_m, y_m, heading_rad] = stops.pose[node++];
      n.placed = !std::isnan(heading_rad);
      if (n.placed) n.T_map_vehicle = Pose::planar(x_m, y_m, heading_rad);
    }
    for (ArrivalObservation& a : t.arrivals) {
      a.rejection = stops.marks[arrival++];
      a.sigma_s = sigma_s;
    }
  }
}

void LogPasses::keep(const Work& w, Stops& stops) const {
  stops.pose.clear();
  stops.marks.clear();
  for (const Trajectory& t : w.trajectories) {
    for (const Node& n : t.nodes)
      stops.pose.push_back({n.T_map_vehicle.translation_m.x(), n.T_map_vehicle.translation_m.y(),
                            n.placed ? n.T_map_vehicle.heading_rad() : NAN});
    for (const ArrivalObservation& a : t.arrivals) stops.marks.push_back(a.rejection);
  }
}

/// Over the ranks.
void LogPasses::add_up(std::vector<double>& numbers) const {
  if (options_.ranks != nullptr) options_.ranks->sum(numbers);
}

/// Lists of all chunks of all ranks, one behind the other in the order of the chunks.
std::vector<double> LogPasses::in_order(std::vector<std::vector<double>> of_chunks) const {
  std::vector<double> mine;
  for (std::vector<double>& list : of_chunks) {
    mine.insert(mine.end(), list.begin(), list.end());
    list = {};
  }
  if (options_.ranks == nullptr) return mine;
  std::vector<double> sizes(static_cast<std::size_t>(options_.ranks->count()), 0.0);
  const auto rank = static_cast<std::size_t>(options_.ranks->index());
  sizes[rank] = static_cast<double>(mine.size());
  add_up(sizes);
  const auto sum_until = [&](std::size_t i) {
    return static_cast<std::size_t>(
        std::accumulate(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(i), 0.0));
  };
  std::vector<double> all(sum_until(sizes.size()), 0.0);
  std::copy(mine.begin(), mine.end(), all.begin() + static_cast<std::ptrdiff_t>(sum_until(rank)));
  add_up(all);
  return all;
}

namespace {

/// Adds up what the chunks gave.
class PassSummer {
 public:
  PassSummer(std::size_t first, std::size_t chunks, int parameters)
      : systems_(first, parameters), numbers_(chunks) {}

  /// Settles the trajectories of a chunk with plain squares.
  void take(std::size_t chunk, std::vector<Trajectory>& trajectories, const ParameterLayout& layout,
            const SharedState& state, double limit, LogPasses::Marks marks, ReducedSystem& system) {
    Numbers& n = numbers_[chunk];
    std::size_t changed = 0;
    if (marks == LogPasses::Marks::kFirst) changed = mark_rejected(trajectories, state, limit);
    auto tiles = std::make_unique<TileSum>(trajectories, layout, Workers{});
    n.cost_before = n.cost = tiles->settle(state, {});
    if (marks == LogPasses::Marks::kSettled) {
      tiles->commit();
      tiles->share_states();
      changed = mark_rejected(trajectories, state, limit);
      if (changed > 0) {
        tiles = std::make_unique<TileSum>(trajectories, layout, Workers{});
        n.cost = tiles->settle(state, {});
      }
    }
    tiles->reduce(state, {}, system);
    tiles->share_states();
    n.changed = static_cast<double>(changed);
    for (const Trajectory& t : trajectories) n.counts.add(count_observations(t, state, 1, false));
    systems_.add(chunk, system);
  }

  /// All numbers one behind the other, to be added up over the ranks.
  [[nodiscard]] std::vector<double> numbers() && {
    ReducedSystem system = std::move(systems_).sum();
    Numbers sum;
    for (const Numbers& n : numbers_) {
      sum.cost += n.cost;
      sum.cost_before += n.cost_before;
      sum.changed += n.changed;
      sum.counts.add(n.counts);
    }
    std::vector<double> all = {sum.cost,
                               sum.cost_before,
                               sum.changed,
                               static_cast<double>(sum.counts.used),
                               static_cast<double>(sum.counts.rejected),
                               sum.counts.observations,
                               static_cast<double>(sum.counts.states)};
    all.insert(all.end(), system.gradient.data(), system.gradient.data() + system.gradient.size());
    all.insert(all.end(), system.H.data(), system.H.data() + system.H.size());
    return all;
  }
  [[nodiscard]] static PassSum sum_of(const std::vector<double>& all, Eigen::Index n) {
    PassSum sum;
    sum.system.cost = all[0];
    sum.cost_before = all[1];
    sum.changed = static_cast<std::size_t>(all[2]);
    sum.counts.used = static_cast<std::size_t>(all[3]);
    sum.counts.rejected = static_cast<std::size_t>(all[4]);
    sum.counts.observations = all[5];
    sum.counts.states = static_cast<std::size_t>(all[6]);
    sum.system.gradient = Eigen::Map<const Eigen::VectorXd>(all.data() + 7, n);
    sum.system.H = Eigen::Map<const Eigen::MatrixXd>(all.data() + 7 + n, n, n);
    return sum;
  }

 private:
  struct Numbers {
    double cost = 0.0, cost_before = 0.0, changed = 0.0;
    ObservationCounts counts;
  };
  OrderedSum systems_;
  std::vector<Numbers> numbers_;
};

}  // namespace

Result<LogPasses::Placed> LogPasses::place(const Estimate& estimate, double suspect_sigmas, bool mark) {
  constexpr std::size_t kResiduals = 200000,
                        kRanges = 50000;  // as agreeing_sigma() and typical_range_m() look at
  const std::size_t every_residual = index_.arrivals() / kResiduals + 1,
                    every_range = index_.arrivals() / kRanges + 1;
  const SharedState state = estimate.state(), prior = prior_state(frame_.site);
  std::vector<std::vector<double>> residuals(stops_.size()), ranges(stops_.size());
  PassSummer summer(first_, stops_.size(), estimate.layout.size());
  const auto done = for_each_chunk_of_mine([&](std::size_t k, Work& w) {
    apply_gates(frame_.site, w.trajectories, 1);
    place_all_stops(frame_, estimate.layout, state, estimate.beacon_usable, suspect_sigmas, {},
                    w.trajectories);
    stops_[k].start_heading_rad.clear();
    for (const Trajectory& t : w.trajectories) {
      for (const Node& n : t.nodes)
        stops_[k].start_heading_rad.push_back(n.placed ? static_cast<float>(n.T_map_vehicle.heading_rad())
                                                       : NAN);
      const std::size_t before = w.chunk->arrivals_before[t.vehicle.index()];
      for (std::size_t i = 0; i < t.arrivals.size(); ++i) {
        const ArrivalObservation& a = t.arrivals[i];
        if ((before + i) % every_range == 0) ranges[k].push_back(prior_range_m(t, a, prior));
        if ((before + i) % every_residual == 0 && a.rejection == Rejection::kUsed && t.nodes[a.node].placed)
          residuals[k].push_back(std::abs(arrival_residual(t, a, state)));
      }
    }
    if (mark)
      summer.take(k, w.trajectories, estimate.layout, state, options_.rejection_sigmas, Marks::kFirst,
                  w.system);
    keep(w, stops_[k]);
  });
  if (!done) return fail(done.error());
  Placed placed;
  placed.residuals = in_order(std::move(residuals));
  placed.ranges_m = in_order(std::move(ranges));
  if (!mark) return placed;
  std::vector<double> numbers = std::move(summer).numbers();
  add_up(numbers);
  placed.sum = PassSummer::sum_of(numbers, estimate.layout.size());
  return placed;
}

Result<PassSum> LogPasses::pass(const Estimate& estimate, Marks marks) {
  const SharedState state = estimate.state();
  const double sigma_s = frame_.site.noise.tof_sigma_s * estimate.noise_factor;
  PassSummer summer(first_, stops_.size(), estimate.layout.size());
  const auto done = for_each_chunk_of_mine([&](std::size_t k, Work& w) {
    restore(stops_[k], sigma_s, w);
    summer.take(k, w.trajectories, estimate.layout, state, options_.rejection_sigmas, marks, w.system);
    keep(w, stops_[k]);
  });
  if (!done) return fail(done.error());
  std::vector<double> numbers = std::move(summer).numbers();
  add_up(numbers);
  return PassSummer::sum_of(numbers, estimate.layout.size());
}

/// What a chunk tells goes onto a tape, all chunks' tapes behind each other, and from there into the
/// findings.
class LogPasses::Teller {
 public:
  Teller(const LogPasses& log, const Estimate& estimate)
      : log_(log),
        site_(log.frame_.site),
        state_(estimate.state()),
        sigma_s_(site_.noise.tof_sigma_s * estimate.noise_factor) {
    std::vector<std::size_t> epochs;
    for (const LogChunk& chunk : log.index_.chunks())
      whole_.epochs += std::accumulate(chunk.epochs.begin(), chunk.epochs.end(), std::size_t{0});
    whole_.every = looked_at_every(whole_.epochs);
    whole_.of_beacon.assign(site_.beacons.size(), {});
  }

  void write(const LogPasses::Work& w, const LogPasses::Stops& stops, std::size_t chunk,
             std::vector<double>& numbers) const {
    TapeWriter tape(numbers);
    tape.put_count(chunk);
    std::vector<std::array<std::size_t, kRejections>> of_beacon(site_.beacons.size());
    std::vector<Eigen::Vector2d> places;
    double coldest = INFINITY, hottest = -INFINITY;
    std::size_t node = 0;
    for (const Trajectory& t : w.trajectories) {
      write_counts(t, tape);
      write_series(t, tape);
      std::vector<std::int64_t> flipped;
      for (const Node& n : t.nodes) {
        if (n.placed) places.emplace_back(n.T_map_vehicle.translation_m.head<2>());
        if (is_flipped(n, static_cast<double>(stops.start_heading_rad[node++]))) flipped.push_back(n.epoch);
      }
      tape.put_count(flipped.size());
      for (const std::int64_t epoch : flipped) tape.put_integer(epoch);
      write_some_epochs(w, t, tape);
      for (const ArrivalObservation& a : t.arrivals) {
        ++of_beacon[a.beacon.index()][static_cast<std::size_t>(a.rejection)];
        const double degC = temperature_of(w.log.arrivals[a.arrival], w.log, site_);
        coldest = std::min(coldest, degC);
        hottest = std::max(hottest, degC);
      }
    }
    for (const auto& counts : of_beacon)
      for (const std::size_t count : counts) tape.put_count(count);
    places = convex_hull(std::move(places));
    tape.put_count(places.size());
    for (const Eigen::Vector2d& p : places) tape.put(p.x()), tape.put(p.y());
    tape.put(coldest);
    tape.put(hottest);
  }

  void read(const std::vector<double>& numbers) {
    told_.arrivals.resize(log_.source_.runs());
    for (TapeReader tape(numbers); !tape.ended();) {
      const LogChunk& chunk = log_.index_.chunks()[tape.count()];
      for (std::size_t v = 0; v < chunk.arrivals.size(); ++v)
        if (chunk.arrivals[v] > 0) read_trajectory(chunk.run, v, tape);
      for (auto& counts : whole_.of_beacon)
        for (std::size_t& count : counts) count += tape.count();
      for (std::size_t n = tape.count(); n > 0; --n) {
        const double x_m = tape.get();
        whole_.area_m.emplace_back(x_m, tape.get());
      }
      whole_.coldest_degC = std::min(whole_.coldest_degC, tape.get());
      whole_.hottest_degC = std::max(whole_.hottest_degC, tape.get());
    }
  }

  [[nodiscard]] LogPasses::Told told(const Estimate& estimate) && {
    Findings& f = told_.findings;
    f.statistics = statistics_of(log_.frame_, estimate.layout, counts_, estimate.last.cost);
    std::vector<std::vector<PairSeries>> series;
    for (auto& [key, of] : of_trajectory_) {
      series.push_back(std::move(of.series));
      if (!has_heading(log_.frame_.site, VehicleId(key.second), false)) of.flipped.clear();
      for (std::string& words : flips_in_words(log_.frame_.runs[key.first], of.flipped))
        f.flips.push_back(std::move(words));
      told_.trajectories.push_back(trajectory_of(key.first, key.second, of));
    }
    f.whiteness = whiteness_of(series);
    whole_.area_m = convex_hull(std::move(whole_.area_m));
    f.whole = std::move(whole_);
    return std::move(told_);
  }

 private:
  /// Of a run and a vehicle.
  struct OfTrajectory {
    std::vector<PairSeries> series;
    std::vector<std::int64_t> flipped;
    std::vector<Arrival> arrivals;  ///< of the epochs at hand
    std::vector<Rejection> marks;
    std::vector<std::array<double, 3>> pose;
  };

  void write_counts(const Trajectory& t, TapeWriter& tape) const {
    const ObservationCounts counts = count_observations(t, state_);
    for (const std::size_t count : {counts.used, counts.rejected, counts.states}) tape.put_count(count);
    tape.put(counts.observations);
    tape.put(counts.squares_s2);
  }

  void write_series(const Trajectory& t, TapeWriter& tape) const {
    const std::vector<PairSeries> series = pair_series(t, state_);
    tape.put_count(static_cast<std::size_t>(
        std::count_if(series.begin(), series.end(), [](const PairSeries& s) { return s.count > 0; })));
    for (std::size_t i = 0; i < series.size(); ++i) {
      if (series[i].count == 0) continue;
      tape.put_count(i);
      tape.put_count(series[i].count);
      for (const double number :
           {series[i].sum, series[i].squares, series[i].products, series[i].first, series[i].last})
        tape.put(number);
    }
  }

  void write_some_epochs(const LogPasses::Work& w, const Trajectory& t, TapeWriter& tape) const {
    const std::size_t before = w.chunk->epochs_before[t.vehicle.index()], every = whole_.every;
    const std::size_t first = (every - before % every) % every;
    tape.put_count(first < t.nodes.size() ? (t.nodes.size() - first + every - 1) / every : 0);
    for (std::size_t k = first; k < t.nodes.size(); k += every) {
      const Segment& s = t.segments[k];
      const Node& n = t.nodes[k];
      tape.put(n.T_map_vehicle.translation_m.x());
      tape.put(n.T_map_vehicle.translation_m.y());
      tape.put(n.placed ? n.T_map_vehicle.heading_rad() : NAN);
      tape.put_count(s.last_arrival - s.first_arrival);
      for (std::size_t i = s.first_arrival; i < s.last_arrival; ++i) {
        const Arrival& a = w.log.arrivals[t.arrivals[i].arrival];
        for (const double number : {a.time_s, a.tof_s, a.amplitude_v, a.temperature_degC}) tape.put(number);
        tape.put_count(a.beacon.index());
        tape.put_count(a.receiver.index());
        tape.put_integer(a.epoch);
        tape.put_integer(a.line);
        tape.put_count(static_cast<std::size_t>(t.arrivals[i].rejection));
      }
    }
  }

  void read_trajectory(std::size_t run, std::size_t vehicle, TapeReader& tape) {
    OfTrajectory& of = of_trajectory_[{run, vehicle}];
    ObservationCounts counts;
    counts.used = tape.count();
    counts.rejected = tape.count();
    counts.states = tape.count();
    counts.observations = tape.get();
    counts.squares_s2 = tape.get();
    counts_.add(counts);
    of.series.resize(state_.beacon_p_map_m.size() * state_.receiver_p_vehicle_m.size());
    for (std::size_t n = tape.count(); n > 0; --n) {
      PairSeries& pair = of.series[tape.count()];
      PairSeries s;
      s.count = tape.count();
      for (double* number : {&s.sum, &s.squares, &s.products, &s.first, &s.last}) *number = tape.get();
      pair.append(s);
    }
    for (std::size_t n = tape.count(); n > 0; --n) of.flipped.push_back(tape.integer());
    for (std::size_t n = tape.count(); n > 0; --n) read_epoch(vehicle, of, tape);
  }

  static void read_epoch(std::size_t vehicle, OfTrajectory& of, TapeReader& tape) {
    std::array<double, 3> pose{};
    for (double& number : pose) number = tape.get();
    of.pose.push_back(pose);
    for (std::size_t n = tape.count(); n > 0; --n) {
      Arrival a;
      for (double* number : {&a.time_s, &a.tof_s, &a.amplitude_v, &a.temperature_degC}) *number = tape.get();
      a.beacon = BeaconId(tape.count());
      a.receiver = ReceiverId(tape.count());
      a.vehicle = VehicleId(vehicle);
      a.epoch = tape.integer();
      a.line = static_cast<int>(tape.integer());
      of.arrivals.push_back(a);
      of.marks.push_back(static_cast<Rejection>(tape.count()));
    }
  }

  /// The epochs at hand as a trajectory, as the whole would be one.
  Trajectory trajectory_of(std::size_t run, std::size_t vehicle, OfTrajectory& of) {
    MeasurementLog log = without_lists(log_.source_.log(run));
    std::vector<Arrival>& all = told_.arrivals[run];
    const std::size_t before = all.size();
    log.arrivals = std::move(of.arrivals);
    Trajectory t = make_trajectory(log, run, VehicleId(vehicle), log_.model_);
    for (std::size_t k = 0; k < t.nodes.size(); ++k) {
      const auto& [x_m, y_m, heading_rad] = of.pose[k];
      t.nodes[k].placed = !std::isnan(heading_rad);
      if (t.nodes[k].placed) t.nodes[k].T_map_vehicle = Pose::planar(x_m, y_m, heading_rad);
    }
    for (std::size_t i = 0; i < t.arrivals.size(); ++i) {
      t.arrivals[i].rejection = of.marks[i];
      t.arrivals[i].sigma_s = sigma_s_;
      t.arrivals[i].arrival += static_cast<std::uint32_t>(before);
    }
    all.insert(all.end(), log.arrivals.begin(), log.arrivals.end());
    return t;
  }

  const LogPasses& log_;
  const Site& site_;
  SharedState state_;
  double sigma_s_;
  WholeLog whole_;
  ObservationCounts counts_;
  std::map<std::pair<std::size_t, std::size_t>, OfTrajectory> of_trajectory_;
  LogPasses::Told told_;
};

Result<LogPasses::Told> LogPasses::tell(const Estimate& estimate) {
  Teller teller(*this, estimate);
  std::vector<std::vector<double>> tapes(stops_.size());
  const double sigma_s = frame_.site.noise.tof_sigma_s * estimate.noise_factor;
  const auto done = for_each_chunk_of_mine([&](std::size_t k, Work& w) {
    restore(stops_[k], sigma_s, w);
    teller.write(w, stops_[k], k, tapes[k]);
  });
  if (!done) return fail(done.error());
  teller.read(in_order(std::move(tapes)));
  return std::move(teller).told(estimate);
}

}  // namespace octant::calib
