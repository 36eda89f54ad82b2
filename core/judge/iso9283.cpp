#include "core/judge/iso9283.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/error.hpp"
#include "core/judge/deviation.hpp"

namespace trammel {

namespace {

constexpr double kSame = 1e-6;  // mm, and rad: targets closer than this are one, as are commands
constexpr std::size_t kSeries = 10,
                      kShortSeries = 5;  // visits at the ends of a drift test that are averaged

using Key = std::tuple<long long, long long, long long, int, std::array<int, kChains>>;

int sign(double v) { return v > kSame ? 1 : v < -kSame ? -1 : 0; }

std::array<int, kChains> direction_of(const Conditions& c) {
  std::array<int, kChains> direction{};
  for (std::size_t i = 0; i < kChains; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    direction[i] = sign(c.cmd_mm[k] - c.from_mm[k]);
  }
  return direction;
}

Key key_of(const Reading& r) {
  const auto cell = [](double v) { return std::llround(v / kSame); };
  return {cell(r.target.x_mm), cell(r.target.y_mm), cell(r.target.phi_rad), r.conditions.epoch,
          direction_of(r.conditions)};
}

std::string count(int n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

/// A pose that was visited often enough, with what its visits show.
struct Judged {
  const PoseVisits* visits = nullptr;
  PoseAccuracy accuracy;
};

std::vector<Judged> often_enough(const std::vector<PoseVisits>& poses) {
  std::vector<Judged> judged;
  for (const PoseVisits& p : poses) {
    if (static_cast<int>(p.deviation.size()) >= kLeastVisits) {
      judged.push_back({&p, pose_accuracy(p.deviation)});
    }
  }
  return judged;
}

struct Reserve {
  int n = 0;
  std::string suffix;  // " (n = 10)"
  std::string words;
};

Reserve reserve_of(const std::vector<Judged>& judged, int n_poses) {
  Reserve reserve;
  reserve.n = judged.front().accuracy.n;
  for (const Judged& j : judged) reserve.n = std::min(reserve.n, j.accuracy.n);
  const auto add = [&reserve](const std::string& text) {
    reserve.words += (reserve.words.empty() ? "" : "; ") + text;
  };
  if (reserve.n < kVisitsOfTheStandard) {
    reserve.suffix = " (n = " + std::to_string(reserve.n) + ")";
    add("the standard asks for n >= 30 visits, n = " + std::to_string(reserve.n) + " here");
  }
  const int used = static_cast<int>(judged.size());
  if (used < kPosesOfTheStandard) {
    add("the standard asks for five poses, " + std::to_string(used) + " here");
  }
  if (used < n_poses) {
    add("of " + std::to_string(used) + " of " + std::to_string(n_poses) +
        " poses: the others have fewer than " + std::to_string(kLeastVisits) + " visits");
  }
  return reserve;
}

IsoSymbol refused(const std::string& name, bool is_angle, const std::string& reason) {
  return {.name = name, .is_angle = is_angle, .value = {}, .floor = {}, .reason = reason};
}

std::string too_few(const Iso9283& of, const std::string& what) {
  return what + " needs n >= 30 visits of a pose from one direction under one set-up (given from " +
         std::to_string(kLeastVisits) +
         " on, with n); the pose visited most has n = " + std::to_string(of.most_n);
}

/// The value of the largest size, with its sign.
template <class Value>
double largest(const std::vector<Judged>& judged, const Value& value) {
  double found = 0;
  for (const Judged& j : judged) {
    const double v = value(j.accuracy);
    if (std::abs(v) > std::abs(found)) found = v;
  }
  return found;
}

/// Drift of the visits in x and y.
std::string drift_of(const std::vector<Judged>& judged) {
  for (const Eigen::Index c : {0, 1}) {
    std::vector<std::vector<double>> series;
    for (const Judged& j : judged) {
      series.emplace_back();
      for (const Eigen::Vector3d& d : j.visits->deviation) series.back().push_back(d[c]);
    }
    const std::string words = drift_words(series, 0.005);  // 1 % over both
    if (!words.empty()) return (c == 0 ? "in x " : "in y ") + words;
  }
  return "";
}

void add_accuracy(Iso9283& out, const std::vector<Judged>& judged) {
  struct Row {
    const char* name;
    bool is_angle;
    bool repeatability;
    double (*value)(const PoseAccuracy&);
  };
  const Row rows[] = {
      {"AP_p", false, false, [](const PoseAccuracy& a) { return a.AP_p_mm; }},
      {"AP_x", false, false, [](const PoseAccuracy& a) { return a.mean[0]; }},
      {"AP_y", false, false, [](const PoseAccuracy& a) { return a.mean[1]; }},
      {"AP_c", true, false, [](const PoseAccuracy& a) { return a.mean[2]; }},
      {"RP_l", false, true, [](const PoseAccuracy& a) { return a.RP_l_mm; }},
      {"RP_c", true, true, [](const PoseAccuracy& a) { return a.RP_c_rad; }},
  };
  const std::string drift = drift_of(judged);
  for (const Row& row : rows) {
    if (judged.empty()) {
      const char* what = row.repeatability ? "RP" : "AP";
      out.symbols.push_back(refused(row.name, row.is_angle, too_few(out, what)));
      continue;
    }
    const Reserve reserve = reserve_of(judged, out.n_poses);
    std::string words = reserve.words;
    if (!drift.empty() && !row.is_angle) words += (words.empty() ? "" : "; ") + drift;
    out.symbols.push_back(
        {row.name + reserve.suffix, row.is_angle, largest(judged, row.value), {}, words});
  }
}

/// Judged poses of one target and epoch, from several directions.
std::vector<std::vector<Judged>> by_target(const std::vector<Judged>& judged) {
  std::map<std::tuple<long long, long long, long long, int>, std::vector<Judged>> groups;
  const auto cell = [](double v) { return std::llround(v / kSame); };
  for (const Judged& j : judged) {
    const Pose& t = j.visits->target;
    groups[{cell(t.x_mm), cell(t.y_mm), cell(t.phi_rad), j.visits->epoch}].push_back(j);
  }
  std::vector<std::vector<Judged>> several;
  for (auto& [key, group] : groups) {
    if (group.size() >= 2) several.push_back(std::move(group));
  }
  return several;
}

void add_multidirectional(Iso9283& out, const std::vector<Judged>& judged) {
  const auto targets = by_target(judged);
  if (targets.empty()) {
    const std::string why =
        judged.empty() ? too_few(out, "vAP")
                       : "vAP needs a pose reached from two directions or more, each with " +
                             std::to_string(kLeastVisits) + " visits or more; none was";
    out.symbols.push_back(refused("vAP_p", false, why));
    out.symbols.push_back(refused("vAP_c", true, why));
    return;
  }
  std::vector<Judged> used;
  double apart_mm = 0, apart_rad = 0;
  int directions = static_cast<int>(targets.front().size());
  for (const auto& group : targets) {
    directions = std::min(directions, static_cast<int>(group.size()));
    for (const Judged& h : group) {
      used.push_back(h);
      for (const Judged& k : group) {
        const Eigen::Vector3d d = h.accuracy.mean - k.accuracy.mean;
        apart_mm = std::max(apart_mm, d.head<2>().norm());
        apart_rad = std::max(apart_rad, std::abs(d[2]));
      }
    }
  }
  const Reserve reserve = reserve_of(used, static_cast<int>(used.size()));
  std::string words = reserve.words;
  words += (words.empty() ? "" : "; ") + std::string("largest of ") +
           count(static_cast<int>(targets.size()), "pose", "poses") + ", " +
           std::to_string(directions) + " directions or more";
  if (directions < 3) words += " where the standard asks for three paths at right angles";
  out.symbols.push_back({"vAP_p" + reserve.suffix, false, apart_mm, {}, words});
  out.symbols.push_back({"vAP_c" + reserve.suffix, true, apart_rad, {}, words});
}

struct Drift {
  double dAP_mm = 0, dRP_mm = 0, hours = 0;
  int poses = 0;
  std::size_t shortest = kSeries;
};

/// Adds what one pose shows when it has two series and times.
void add_pose_drift(const PoseVisits& visits, Drift& drift) {
  const std::size_t n = visits.deviation.size();
  const std::size_t length = n >= 2 * kSeries ? kSeries : kShortSeries;
  const auto timed = [](const std::optional<double>& t) { return t.has_value(); };
  if (n < 2 * length || !std::all_of(visits.time_s.begin(), visits.time_s.end(), timed)) return;
  const std::span<const Eigen::Vector3d> all(visits.deviation);
  const PoseAccuracy first = pose_accuracy(all.first(length));
  for (std::size_t at = length; at + length <= n; at += length) {
    const PoseAccuracy later = pose_accuracy(all.subspan(at, length));
    drift.dAP_mm = std::max(drift.dAP_mm, std::abs(later.AP_p_mm - first.AP_p_mm));
    drift.dRP_mm = std::max(drift.dRP_mm, std::abs(later.RP_l_mm - first.RP_l_mm));
  }
  drift.hours = std::max(drift.hours, (*visits.time_s.back() - *visits.time_s.front()) / 3600);
  drift.shortest = std::min(drift.shortest, length);
  ++drift.poses;
}

void add_drift(Iso9283& out, const std::vector<Judged>& judged) {
  Drift drift;
  for (const Judged& j : judged) add_pose_drift(*j.visits, drift);
  if (drift.poses == 0) {
    const std::string why =
        "drift needs a pose visited in two series of " + std::to_string(kShortSeries) +
        " visits or more with recorded times (the standard: over 8 h); the pose visited most has "
        "n = " +
        std::to_string(out.most_n);
    out.symbols.push_back(refused("dAP_p", false, why));
    out.symbols.push_back(refused("dRP_l", false, why));
    return;
  }
  char hours[40];
  std::snprintf(hours, sizeof hours, "%.2f h", drift.hours);
  std::string words = "over " + std::string(hours) + " in series of " +
                      std::to_string(drift.shortest) + " visits, largest of " +
                      count(drift.poses, "pose", "poses");
  if (drift.hours < kDriftHoursOfTheStandard) words += "; the standard watches 8 h";
  const std::string suffix = " (" + std::string(hours) + ")";
  out.symbols.push_back({"dAP_p" + suffix, false, drift.dAP_mm, {}, words});
  out.symbols.push_back({"dRP_l" + suffix, false, drift.dRP_mm, {}, words});
}

/// mean l + 3 S_l
double repeatability_mm(std::span<const double> l_mm) {
  const auto n = static_cast<double>(l_mm.size());
  double mean = 0, square = 0;
  for (const double l : l_mm) mean += l / n;
  for (const double l : l_mm) square += std::pow(l - mean, 2);
  return mean + 3 * std::sqrt(square / (n - 1));
}

}  // namespace

std::vector<PoseVisits> pose_visits(std::span<const Reading> readings) {
  std::vector<const Reading*> order;
  for (const Reading& r : readings) {
    if (r.measured) order.push_back(&r);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const Reading* a, const Reading* b) { return a->seq < b->seq; });
  std::vector<PoseVisits> poses;
  std::map<Key, std::size_t> place;
  for (const Reading* r : order) {
    const auto [at, is_new] = place.try_emplace(key_of(*r), poses.size());
    if (is_new) {
      poses.push_back({.target = r->target,
                       .direction = direction_of(r->conditions),
                       .epoch = r->conditions.epoch,
                       .deviation = {},
                       .time_s = {}});
    }
    poses[at->second].deviation.push_back(pose_difference(*r->measured, r->target));
    poses[at->second].time_s.push_back(r->conditions.time_s);
  }
  return poses;
}

PoseAccuracy pose_accuracy(std::span<const Eigen::Vector3d> deviation) {
  TRAMMEL_ASSERT(!deviation.empty());
  PoseAccuracy a;
  a.n = static_cast<int>(deviation.size());
  for (const auto& d : deviation) a.mean += d / a.n;
  a.AP_p_mm = a.mean.head<2>().norm();
  if (a.n < 2) return a;
  std::vector<double> l_mm;
  double phi_square = 0;
  for (const auto& d : deviation) {
    l_mm.push_back((d - a.mean).head<2>().norm());
    phi_square += std::pow(d[2] - a.mean[2], 2);
  }
  a.RP_l_mm = repeatability_mm(l_mm);
  a.RP_c_rad = 3 * std::sqrt(phi_square / (a.n - 1));
  return a;
}

double point_repeatability_mm(std::span<const Eigen::Vector3d> points_mm) {
  TRAMMEL_ASSERT(points_mm.size() >= 2);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points_mm) mean += p / static_cast<double>(points_mm.size());
  std::vector<double> l_mm;
  for (const auto& p : points_mm) l_mm.push_back((p - mean).norm());
  return repeatability_mm(l_mm);
}

Iso9283 iso9283(std::span<const Reading> readings, const std::optional<TrackerSigma>& sigma) {
  const std::vector<PoseVisits> poses = pose_visits(readings);
  if (poses.empty()) {
    throw InputError({.what = "there is nothing to assess",
                      .got = std::to_string(readings.size()) + " readings, none with a pose",
                      .expected = "measured readings"});
  }
  Iso9283 out;
  out.n_poses = static_cast<int>(poses.size());
  out.least_n = static_cast<int>(poses.front().deviation.size());
  double visits = 0;
  for (const PoseVisits& p : poses) {
    const int n = static_cast<int>(p.deviation.size());
    out.least_n = std::min(out.least_n, n);
    out.most_n = std::max(out.most_n, n);
    visits += n;
    for (const auto& d : p.deviation) {
      out.mean_mm += d.head<2>().norm();
      out.mean_rad += std::abs(d[2]);
    }
  }
  out.mean_mm /= visits;
  out.mean_rad /= visits;
  const std::vector<Judged> judged = often_enough(poses);
  add_accuracy(out, judged);
  add_multidirectional(out, judged);
  add_drift(out, judged);
  if (sigma) {
    std::vector<IsoSymbol*> symbols;
    for (IsoSymbol& symbol : out.symbols) symbols.push_back(&symbol);
    add_floors(symbols, readings, *sigma,
               [](std::span<const Reading> perfect) { return iso9283(perfect).symbols; });
  }
  return out;
}

}  // namespace trammel
