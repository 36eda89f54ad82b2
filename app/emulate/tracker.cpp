#include "app/emulate/tracker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"

namespace trammel::emulate {

namespace {

constexpr double kUnstableMm = 0.2;  // an unstable reading is off by about this much
// Dates begin here and go on with the time of work, so that the same campaign gets the same bytes.
constexpr std::chrono::sys_days kFirstDay{std::chrono::year{2026} / 1 / 5};
constexpr double kFirstHour_s = 8 * kSecondsPerHour;
constexpr std::size_t kMaxTrackerLine = 400;

std::vector<std::string> names_of(std::string_view text) {
  std::vector<std::string> names(1);
  for (const char c : text) {
    if (c == ';') {
      names.emplace_back();
    } else {
      names.back() += c;
    }
  }
  return names;
}

/// Rx, Ry and Rz: degrees about fixed axes, R = Rz Ry Rx [K].
std::string report_of(std::string_view group, const Eigen::Isometry3d& T, std::string_view date) {
  const Eigen::Vector3d at = T.translation();
  const Eigen::Matrix3d R = T.linear();
  return fmt::format(
      "ACK-300 Object Offset Report Frame{}_1;X:{:.6f};Y:{:.6f};Z:{:.6f};Rx:{:.6f};Ry:{:.6f};"
      "Rz:{:.6f};{}",
      group, at[0], at[1], at[2], deg_from_rad(std::atan2(R(2, 1), R(2, 2))),
      deg_from_rad(std::asin(std::clamp(-R(2, 0), -1.0, 1.0))),
      deg_from_rad(std::atan2(R(1, 0), R(0, 0))), date);
}

Answer said(std::string text) { return {.bytes = std::move(text) + "\r\n"}; }

class TrackerConversation : public Conversation {
 public:
  TrackerConversation(EmulatedTracker& tracker, Faults& faults)
      : tracker_(tracker), faults_(faults) {}

  std::vector<Answer> receive(std::string_view bytes) override {
    std::vector<Answer> answers;
    for (const LineReader::Line& line : reader_.add(bytes)) {
      if (line.text.empty()) continue;
      Answer answer =
          line.too_long ? said("ERR-200 CommandRejected line too long") : tracker_.line(line.text);
      answers.push_back(over_bad_line(faults_, line.text, std::move(answer)));
    }
    return answers;
  }

 private:
  EmulatedTracker& tracker_;
  Faults& faults_;
  LineReader reader_{'\n', kMaxTrackerLine};
};

}  // namespace

/// A line begins with `name`; what follows is its argument.
struct EmulatedTracker::Command {
  std::string_view name;
  Answer (EmulatedTracker::*run)(std::string_view argument);
  bool while_measuring;
};

const std::vector<EmulatedTracker::Command>& EmulatedTracker::commands() {
  static const std::vector<Command> all = {
      {"?STAT", &EmulatedTracker::status, true},
      {"?LSTA", &EmulatedTracker::laser_status, true},
      {"!LST:", &EmulatedTracker::switch_laser, false},
      {"!HALT", &EmulatedTracker::halt, true},
      {"!MEAS_SINGLE_POINT:", &EmulatedTracker::measure_point, false},
      {"!CMDEXE:", &EmulatedTracker::measure_group, false},
      {"?POS ", &EmulatedTracker::position, false},
      {"?OFFSET:", &EmulatedTracker::offset, false},
  };
  return all;
}

EmulatedTracker::EmulatedTracker(simulate::VirtualRobot robot, TrackerSetup setup, Look look,
                                 Faults& faults, double speedup)
    : robot_(std::move(robot)),
      setup_(std::move(setup)),
      look_(std::move(look)),
      faults_(faults),
      speedup_(speedup),
      now_(wall_clock(speedup)),
      laser_on_s_(-setup_.warm_up_s) {}

Answer EmulatedTracker::line(std::string_view text) {
  for (const Command& command : commands()) {
    if (!text.starts_with(command.name)) continue;
    if (measuring() && !command.while_measuring) return said("ERR-201 Busy measuring");
    try {
      return (this->*command.run)(text.substr(command.name.size()));
    } catch (const Failed& failed) {
      return said(failed.answer);
    }
  }
  return said("ERR-200 CommandRejected not known to this emulator");
}

Answer EmulatedTracker::status(std::string_view) {
  if (faults_.strikes(FaultKind::beam_lost)) return said("ERR-338 Instrument not ready: no target");
  if (!laser_on_ || laser_left_s() > 0) return said("ERR-338 Instrument not ready: no laser");
  return said(measuring() ? "ACK-300 BUSY (Trammel emulator)" : "ACK-300 READY (Trammel emulator)");
}

double EmulatedTracker::laser_left_s() const {
  return std::max(laser_on_s_ + setup_.warm_up_s - now_(), 0.0);
}

Answer EmulatedTracker::laser_status(std::string_view) {
  if (!laser_on_) return said("ACK-300 LOFF");
  if (laser_left_s() > 0) return said(fmt::format("ACK-300 WARM, {:.2f} seconds", laser_left_s()));
  return said("ACK-300 LON");
}

Answer EmulatedTracker::switch_laser(std::string_view word) {
  if (word != "0" && word != "1") return said("ERR-200 CommandRejected !LST takes 0 or 1");
  if (word == "1" && !laser_on_) laser_on_s_ = now_();
  laser_on_ = word == "1";
  return said("ACK-300 OK");
}

Answer EmulatedTracker::halt(std::string_view) {
  if (const auto running = measuring_.lock()) *running = false;
  return said("ACK-300 OK");
}

Standing EmulatedTracker::look() const {
  try {
    return look_();
  } catch (const DeviceError& error) {
    throw Failed{fmt::format("ERR-338 Instrument not ready: {}", error.text().what)};
  }
}

/// The time of measuring is the instrument's own, so that no stage needs to be told of it.
Conditions EmulatedTracker::conditions(const Measurement& taken) const {
  const double measured_s = static_cast<double>(taken.number) * robot_.truth().motion.measure_s;
  return {.cmd_mm = taken.standing.l_mm,
          .from_mm = taken.standing.from_mm,
          .epoch = taken.standing.epoch,
          .time_s = taken.standing.time_s + measured_s,
          .temp_degc = {}};
}

std::string EmulatedTracker::date(const Measurement& taken) const {
  using namespace std::chrono;
  const auto whole = static_cast<long long>(kFirstHour_s + conditions(taken).time_s.value_or(0));
  const sys_seconds now = kFirstDay + seconds(whole);
  const sys_days day = floor<days>(now);
  const year_month_day date(day);
  const hh_mm_ss time(now - day);
  return fmt::format("{:02}/{:02}/{:04} {:02}:{:02}:{:02}", static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()), static_cast<int>(date.year()),
                     time.hours().count(), time.minutes().count(), time.seconds().count());
}

Pose EmulatedTracker::seen_platform(const Measurement& taken) const {
  const MachinePose seen = robot_.seen_pose(conditions(taken));
  if (!seen.ok()) throw Failed{"ERR-305 Measurement failed: the robot cannot stand there"};
  return seen.pose;
}

Eigen::Vector3d EmulatedTracker::place(const Nest& nest, const Measurement& taken) const {
  const auto [x, y, z] = std::array{nest.at_mm[0], nest.at_mm[1], nest.at_mm[2]};
  if (!nest.on_platform) {
    const Pose seen = robot_.seen(Pose{x, y, 0}, conditions(taken));
    return {seen.x_mm, seen.y_mm, z};
  }
  const Pose p = seen_platform(taken);
  const double c = std::cos(p.phi_rad), s = std::sin(p.phi_rad);
  return {p.x_mm + c * x - s * y, p.y_mm + s * x + c * y, z};
}

/// Begins a measurement: it takes its time, and fails for whatever happens meanwhile.
Answer EmulatedTracker::measure(const std::string& what, Result result) {
  if (!laser_on_ || laser_left_s() > 0) throw Failed{"ERR-338 Instrument not ready: no laser"};
  const Measurement taken{look(), ++n_measured_};
  const bool broken = faults_.strikes(FaultKind::beam_break, what);
  const auto going_on = std::make_shared<bool>(true);
  measuring_ = going_on;
  Answer answer;
  answer.after = std::chrono::duration<double>(robot_.truth().motion.measure_s / speedup_);
  answer.finish = [this, what, taken, broken, going_on, result = std::move(result)] {
    measuring_.reset();
    const auto failed = [&what](const char* why) {
      return fmt::format("ERR-305 Measurement of {} failed: {}\r\n", what, why);
    };
    if (!*going_on) return failed("halted");
    if (broken) return failed("beam broken");
    try {
      if (taken.standing.moving || look() != taken.standing) return failed("the target moves");
      return result(taken) + "\r\n";
    } catch (const Failed& refused) {
      return refused.answer + "\r\n";
    }
  };
  return answer;
}

/// coll;grp;pt, whatever the collection.
Answer EmulatedTracker::measure_point(std::string_view names) {
  const std::vector<std::string> words = names_of(names);
  if (words.size() != 3) throw Failed{"ERR-200 CommandRejected needs collection;group;point"};
  const auto nest = std::find_if(setup_.nests.begin(), setup_.nests.end(), [&](const Nest& n) {
    return n.group == words[1] && n.point == words[2];
  });
  if (nest == setup_.nests.end()) {
    throw Failed{fmt::format("ERR-306 No target {} in group {}", words[2], words[1])};
  }
  const bool unstable = faults_.strikes(FaultKind::unstable, names);
  return measure(words[2], [this, nest = *nest, unstable](const Measurement& taken) {
    const simulate::TrackerTruth& truth = robot_.truth().tracker;
    const std::uint64_t seed = robot_.truth().seed;
    const Pose flat = simulate::reading_noise(truth, seed, taken.number);
    Random random = Random::stream(seed, "height noise", taken.number);
    Eigen::Vector3d noise(flat.x_mm, flat.y_mm, truth.sigma_xy_mm * random.normal());
    if (unstable) {
      for (double& value : noise) value += kUnstableMm * random.normal();
    }
    const Eigen::Vector3d p = setup_.from_base * (place(nest, taken) + noise);
    return fmt::format("ACK-300 Single Point Measurement {} result {:.6f},{:.6f},{:.6f} {} {}",
                       nest.point, p[0], p[1], p[2], date(taken), unstable ? "False" : "True");
  });
}

/// The platform as a whole, where its group is on it. ?POS and ?OFFSET tell what was found.
Answer EmulatedTracker::measure_group(std::string_view name) {
  const std::string group(name);
  const bool on_platform = is_group(group, true);
  if (!on_platform && !is_group(group, false)) throw Failed{"ERR-306 No group " + group};
  const bool unstable = faults_.strikes(FaultKind::unstable, name);
  return measure(group, [this, group, on_platform, unstable](const Measurement& taken) {
    if (unstable) return fmt::format("ERR-340 Measurement of group {} failed: unstable", group);
    if (on_platform) {
      const simulate::TrackerTruth& truth = robot_.truth().tracker;
      const std::uint64_t seed = robot_.truth().seed;
      const Pose p = Pose::from(seen_platform(taken).vector() +
                                simulate::reading_noise(truth, seed, taken.number).vector());
      Random random = Random::stream(seed, "tilt noise", taken.number);
      const double z = truth.sigma_xy_mm * random.normal();
      const double rx = truth.sigma_phi_rad * random.normal();
      const double ry = truth.sigma_phi_rad * random.normal();
      seen_[group] = {fixed_frame({p.x_mm, p.y_mm, z}, {rx, ry, p.phi_rad}), date(taken)};
    }
    return "ACK-106 Successfully ran CMD " + group;
  });
}

bool EmulatedTracker::is_group(std::string_view group, bool on_platform) const {
  return std::any_of(setup_.nests.begin(), setup_.nests.end(), [&](const Nest& n) {
    return n.group == group && n.on_platform == on_platform;
  });
}

const EmulatedTracker::Seen& EmulatedTracker::seen(std::string_view group) const {
  if (!is_group(group, true)) throw Failed{fmt::format("ERR-306 No group {} to tell of", group)};
  const auto seen = seen_.find(group);
  if (seen == seen_.end()) throw Failed{fmt::format("ERR-340 Group {} is not measured", group)};
  return seen->second;
}

/// Of a group on the platform, in the frame that the tracker's points have.
Answer EmulatedTracker::position(std::string_view group) {
  const Seen& found = seen(group);
  return said(report_of(group, setup_.from_base * found.T_B_P, found.date));
}

/// target;reference: of a group on the platform, against one on the base.
Answer EmulatedTracker::offset(std::string_view names) {
  const std::vector<std::string> words = names_of(names);
  if (words.size() != 2) throw Failed{"ERR-200 CommandRejected needs target;reference"};
  if (!is_group(words[1], false)) throw Failed{"ERR-306 No group " + words[1] + " on the base"};
  const Seen& found = seen(words[0]);
  return said(report_of(words[0], found.T_B_P, found.date));
}

Server::Make tracker_conversations(EmulatedTracker& tracker, Faults& faults) {
  return [&tracker, &faults](const Peer&) -> std::unique_ptr<Conversation> {
    return std::make_unique<TrackerConversation>(tracker, faults);
  };
}

}  // namespace trammel::emulate
