#pragma once
// A campaign over real sockets: the emulators' servers, the drivers, the runner, a database; and
// whether what was stored is what the virtual robot really did.

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/files/machine_json.hpp"
#include "app/session/plan_record.hpp"
#include "store/verify.hpp"
#include "tests/app/emulate/client.hpp"
#include "tests/app/emulate/emulated.hpp"
#include "tests/app/session/session_fixture.hpp"

namespace trammel::tests {

/// The time of the emulated world goes on by one step with each look at it: a move has the same
/// samples on any machine, and takes no time of this one.
inline emulate::NowS ticking(double step_s) {
  return [step_s, ticks = std::make_shared<std::atomic<std::int64_t>>(0)] {
    return step_s * static_cast<double>(ticks->fetch_add(1));
  };
}

inline int struck_in_all(const emulate::Faults& faults) {
  int n = 0;
  for (int kind = 0; kind <= static_cast<int>(emulate::FaultKind::stall); ++kind) {
    n += faults.struck(static_cast<emulate::FaultKind>(kind));
  }
  return n;
}

/// What came over both wires, in order.
class WireLog {
 public:
  struct Line {
    emulate::Emulated to = emulate::Emulated::stage;
    std::string text;
    bool struck = false;  // a fault befell it
    std::chrono::steady_clock::time_point at = std::chrono::steady_clock::now();
  };
  void add(Line line) {
    const std::lock_guard guard(mutex_);
    lines_.push_back(std::move(line));
  }
  [[nodiscard]] std::vector<Line> lines() const {
    const std::lock_guard guard(mutex_);
    return lines_;
  }
  [[nodiscard]] std::size_t size() const {
    const std::lock_guard guard(mutex_);
    return lines_.size();
  }
  [[nodiscard]] int count(std::string_view begin) const {
    int n = 0;
    for (const Line& line : lines()) n += line.text.starts_with(begin) ? 1 : 0;
    return n;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Line> lines_;
};

/// What a proxy between the program and a device does to the answers: before anybody connects.
struct Proxy {
  /// Changes an answer: renames, repeats, holds back one before.
  std::function<void(std::string& answer)> alter = {};
  /// The same, of what is answered at once, by what was asked.
  std::function<void(std::string_view asked, std::string& answer)> alter_asked = {};
  /// Seconds that the answer is late.
  std::function<double(std::string_view asked)> late_s = {};
};

/// A wire that is listened to.
class Tapped : public emulate::Conversation {
 public:
  Tapped(std::unique_ptr<Conversation> behind, emulate::Emulated to, const emulate::Faults& faults,
         WireLog& log, const Proxy& proxy)
      : behind_(std::move(behind)), to_(to), faults_(faults), log_(log), proxy_(proxy) {}

  std::vector<emulate::Answer> receive(std::string_view bytes) override {
    const int before = struck_in_all(faults_);
    auto answers = behind_->receive(bytes);
    log_.add({to_, std::string(bytes), struck_in_all(faults_) != before});
    for (emulate::Answer& answer : answers) {
      if (proxy_.late_s) answer.after += std::chrono::duration<double>(proxy_.late_s(bytes));
      if (proxy_.alter_asked && !answer.finish) proxy_.alter_asked(bytes, answer.bytes);
      if (!proxy_.alter || !answer.finish) continue;
      answer.finish = [proxy = &proxy_, finish = std::move(answer.finish)] {
        std::string text = finish();
        proxy->alter(text);  // in place: it may have a memory
        return text;
      };
    }
    return answers;
  }

 private:
  std::unique_ptr<Conversation> behind_;
  emulate::Emulated to_;
  const emulate::Faults& faults_;
  WireLog& log_;
  const Proxy& proxy_;
};

/// Both emulators as servers over one virtual robot.
struct SocketLaboratory {
  emulate::Faults stage_faults, tracker_faults;
  WireLog log;
  Proxy to_stage = {}, to_tracker = {};
  emulate::EmulatedRobot robot;
  emulate::Galil galil;
  emulate::EmulatedTracker tracker;
  emulate::Server stage_server, tracker_server;

  /// `step_s` of each look at the time; 0: the time is the world's own.
  SocketLaboratory(const simulate::Truth& truth, double step_s,
                   const emulate::EmulatedRobot::Rails& rails = {})
      : robot(simulate::VirtualRobot(truth), rails,
              step_s > 0 ? ticking(step_s) : emulate::wall_clock(1)),
        galil(robot, stage_faults),
        tracker(
            robot.robot(), emulate::default_tracker(), [this] { return robot.standing(); },
            tracker_faults, EmulatedLaboratory::kSpeedup),
        stage_server({.meanwhile = [this] { return galil.programs.work(); }},
                     tapped(emulate::galil_conversations(galil, stage_faults),
                            emulate::Emulated::stage, stage_faults)),
        tracker_server({}, tapped(emulate::tracker_conversations(tracker, tracker_faults),
                                  emulate::Emulated::tracker, tracker_faults)) {}

 private:
  emulate::Server::Make tapped(emulate::Server::Make make, emulate::Emulated to,
                               const emulate::Faults& faults) {
    return [this, make = std::move(make), to,
            &faults](const emulate::Peer& peer) -> std::unique_ptr<emulate::Conversation> {
      return std::make_unique<Tapped>(make(peer), to, faults, log,
                                      to == emulate::Emulated::tracker ? to_tracker : to_stage);
    };
  }
};

/// Tells which point is tried.
class TellingClock : public device::Clock {
 public:
  TellingClock(std::unique_ptr<Clock> real, std::function<void(int seq)> tell)
      : real_(std::move(real)), tell_(std::move(tell)) {}
  void start(const Plan& plan, double start_s) override { real_->start(plan, start_s); }
  double time_s(const PlannedPoint& point) override {
    tell_(point.seq);
    return real_->time_s(point);
  }
  [[nodiscard]] double end_s() const override { return real_->end_s(); }

 private:
  std::unique_ptr<Clock> real_;
  std::function<void(int seq)> tell_;
};

struct SocketOptions {
  simulate::Truth truth = emulated_truth();
  double reply_timeout_s = 0.2;  // what a lost reply costs
  double step_s = 0.01;
  emulate::EmulatedRobot::Rails rails = {};
  bool blind = false;      // the tracker's file lets pass whatever the triangle of nests tells
  bool base_nests = true;  // else the base's frame is stated
  double watch_host_s = 0;
  double following_mm = 0.5;
};

class SocketCampaign {
 public:
  explicit SocketCampaign(const Plan& plan, const SocketOptions& options = {})
      : lab(options.truth, options.step_s, options.rails) {
    const std::string examples = source_folder() + "/examples/emulated/";
    auto stage = nlohmann::json::parse(read_text(examples + "stage.json"));
    stage["controller"]["port"] = lab.stage_server.port();
    stage["controller"]["reply_timeout_s"] = options.reply_timeout_s;
    if (options.watch_host_s > 0) stage["controller"]["watch_host_s"] = options.watch_host_s;
    const Machine& machine = options.truth.nominal;
    if (machine.kind->name != stage["mechanism"]["type"]) {
      stage["mechanism"] = machine_json(machine);
      auto& axes = stage["axes"];
      axes.erase(axes.begin() + machine.kind->n_chains, axes.end());
    }
    stage["motion"]["following_mm"] = options.following_mm;
    stage["motion"]["poll_s"] = 0;
    // In the world's own time a motor needs some to come to rest.
    stage["motion"]["settle_s"] = options.step_s > 0 ? 0 : 0.05;
    auto tracker = nlohmann::json::parse(read_text(examples + "tracker.json"));
    tracker["source"]["port"] = lab.tracker_server.port();
    tracker["source"]["reply_timeout_s"] = options.reply_timeout_s;
    if (options.blind) {
      tracker["sigma_mm"] = 10;
      tracker["symmetric_because"] = "at this sigma no triangle tells its nests apart";
      tracker.erase("out_of_plane_mm");
    }
    if (!options.base_nests) {
      tracker.erase("base_nests");
      tracker["base_frame"] = stated_frame();
    }
    request = request_for(plan);
    request.stage = "galil:" + folder.write("stage.json", stage.dump()).string();
    request.tracker = "t2sa:" + folder.write("tracker.json", tracker.dump()).string();
    request.plan_check = (folder.path() / "check.json").string();
    session::write_plan_record(request.plan_check, plan, lab.robot.robot().truth().nominal, {});
    around.sleep = [](double) {};
    around.stored = [this](int) { witness(); };
    around.open = [this](const std::string& stage_word, const std::string& tracker_word) {
      device::Devices devices = device::open_devices(stage_word, tracker_word);
      devices.clock = std::make_unique<TellingClock>(std::move(devices.clock), [this](int seq) {
        point_ = seq;
        if (begun) begun(seq);
      });
      if (altered) altered(devices);
      return devices;
    };
  }

  TemporaryFolder folder;
  SocketLaboratory lab;
  session::Request request;
  session::Surroundings around;
  std::function<void(int seq)> begun = {};             // at each try of a point
  std::function<void(device::Devices&)> altered = {};  // when they are opened
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);

  session::Outcome run() { return session::run_or_resume(db, request, around); }

  /// Where the robot stood when a point was said to be stored. Called by around.stored.
  void witness() { seen_[point_] = lab.robot.standing(); }

  /// Once, at the first try of the point.
  void arm(int at, emulate::Emulated where, emulate::Fault fault) {
    begun = [this, at, where, fault = std::move(fault), done = false](int seq) mutable {
      if (seq != at || done) return;
      done = true;
      faults(where).add(fault);
    };
  }
  emulate::Faults& faults(emulate::Emulated where) {
    return where == emulate::Emulated::stage ? lab.stage_faults : lab.tracker_faults;
  }
  [[nodiscard]] int struck() const {
    return struck_in_all(lab.stage_faults) + struck_in_all(lab.tracker_faults);
  }

  std::vector<store::Attempt> attempts() {
    const auto campaign = store::require_campaign(db, "c");
    return store::attempts(db, store::find_session(db, campaign.id, "s")->id);
  }

  [[nodiscard]] std::string last_event() {
    const auto owner = store::require_campaign(db, "c");
    return store::events(db, store::find_session(db, owner.id, "s")->id).back().detail;
  }

  /// What an operator does after a limit: moves the rail off its switch by hand.
  void free_rails() {
    Client hand(lab.stage_server.port());
    for (const char axis : {'A', 'B', 'C'}) {
      const std::string name(1, axis);
      const bool forward = hand.number("MG _LF" + name) == 0;
      if (!forward && hand.number("MG _LR" + name) != 0) continue;
      hand.galil("SH" + name);
      hand.galil("PR" + name + (forward ? "=-800" : "=800"));
      hand.galil("BG" + name);
      while (hand.number("MG _BG" + name) != 0) {
      }
      hand.galil("MO" + name);
    }
  }

  /// Why readings are left out, by their number.
  std::map<int, std::string> excluded() {
    std::map<int, std::string> why;
    for (const store::Exclusion& e : store::exclusions(db, store::require_campaign(db, "c").id)) {
      why[e.seq] = e.reason;
    }
    return why;
  }

  /// Readings of the session that are not what they must be, in words: each point once, none of a
  /// try that failed, none that the tracker did not accept, each of where the robot really stood
  /// and how its rails really came there, but for those that are excluded; and points that were
  /// acknowledged and are not there. `whole`: every point is there.
  std::vector<std::string> problems(bool whole = true);

 private:
  /// Of the base in the frame of the emulator's tracker, as a file states it.
  static nlohmann::json stated_frame() {
    const Eigen::Isometry3d T = emulate::default_tracker().from_base.inverse();
    const Eigen::Matrix3d R = T.linear();
    return {{"x_mm", T.translation()[0]},
            {"y_mm", T.translation()[1]},
            {"z_mm", T.translation()[2]},
            {"rx_deg", deg_from_rad(std::atan2(R(2, 1), R(2, 2)))},
            {"ry_deg", deg_from_rad(std::asin(-R(2, 0)))},
            {"rz_deg", deg_from_rad(std::atan2(R(1, 0), R(0, 0)))}};
  }
  void compare(int seq, const store::NewReading& stored, std::vector<std::string>& found) const;

  int point_ = 0;  // that is being tried
  std::map<int, emulate::Standing> seen_;
};

constexpr const char* kLost = "acknowledged, and not there";
// Six sigma of a pose of three nests, and of the base found by three; half a count of each rail.
constexpr double kSeenMm = 0.06, kSeenRad = 6e-4, kStandsMm = 0.006;

inline void SocketCampaign::compare(int seq, const store::NewReading& stored,
                                    std::vector<std::string>& found) const {
  const auto wrong = [&](const std::string& what) {
    found.push_back(fmt::format("point {}: {}", seq, what));
  };
  const auto stood = seen_.find(seq);
  if (stood == seen_.end()) return wrong("stored, and nobody was told");
  const emulate::Standing& standing = stood->second;
  if (standing.moving) wrong("the robot moved");
  const MachinePose truly = lab.robot.robot().seen_pose({.cmd_mm = standing.l_mm,
                                                         .from_mm = standing.from_mm,
                                                         .epoch = standing.epoch,
                                                         .time_s = standing.time_s,
                                                         .temp_degc = {}});
  const Reading& reading = stored.reading;
  const Eigen::Vector3d off = reading.measured->vector() - truly.pose.vector();
  const double off_mm = std::hypot(off[0], off[1]);
  if (!(off_mm < kSeenMm && std::abs(off[2]) < kSeenRad)) {
    wrong(fmt::format("{:.4f} mm and {:.6f} rad from where the platform was", off_mm, off[2]));
  }
  for (int i = 0; i < kChains; ++i) {
    if (!(std::abs(reading.conditions.cmd_mm[i] - standing.l_mm[i]) < kStandsMm)) {
      wrong(fmt::format("rail {} stands {:.4f} mm, commanded {:.4f}", i + 1, standing.l_mm[i],
                        reading.conditions.cmd_mm[i]));
    }
    if (!(std::abs(reading.conditions.from_mm[i] - standing.from_mm[i]) < 2 * kStandsMm)) {
      wrong(fmt::format("rail {} came from {:.4f} mm, stored {:.4f}", i + 1, standing.from_mm[i],
                        reading.conditions.from_mm[i]));
    }
  }
  if (!((*stored.encoder_mm - standing.l_mm).cwiseAbs().maxCoeff() < kStandsMm)) {
    wrong("an encoder that is off");
  }
  if (!stored.raw_reply || stored.raw_reply->find("False") != std::string::npos ||
      stored.raw_reply->find("ERR-") != std::string::npos) {
    wrong("of an answer that was not accepted");
  }
}

inline std::vector<std::string> SocketCampaign::problems(bool whole) {
  std::vector<std::string> found;
  std::map<store::Id, int> point_of;
  for (const store::Attempt& a : attempts()) {
    if (a.status == "ok") {
      point_of[a.id] = a.point_seq;
    } else if (a.n_readings != 0) {
      found.push_back(fmt::format("point {}: readings of a try that {}", a.point_seq, a.status));
    }
  }
  const auto campaign = store::require_campaign(db, "c");
  const store::Id id = store::find_session(db, campaign.id, "s")->id;
  std::map<int, int> times;
  const std::map<int, std::string> left_out = excluded();
  for (const store::StoredReading& r : store::readings(db, campaign.id, {id})) {
    const int seq = point_of.at(r.attempt_id.value());
    ++times[seq];
    if (!left_out.contains(r.data.reading.seq)) compare(seq, r.data, found);
  }
  for (const PlannedPoint& point : request.plan.points) {
    const int n = times[point.seq];
    if (n > 1 || (whole && n == 0)) {
      found.push_back(fmt::format("point {}: stored {} times", point.seq, n));
    }
    if (n == 0 && seen_.contains(point.seq)) {
      found.push_back(fmt::format("point {}: {}", point.seq, kLost));
    }
  }
  if (!store::verify(db).ok()) found.push_back("the database does not verify");
  return found;
}

}  // namespace trammel::tests
