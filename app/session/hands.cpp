#include "app/session/hands.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/mechanism/nominal_machine.hpp"

namespace trammel::session {

namespace {

using device::Devices;
using device::Status;

constexpr double kSlowestMmS = 1;  // a stage that does not say its speed is given this
constexpr double kArmMm = 100;     // a turn moves what is so far from the platform's origin
constexpr std::chrono::milliseconds kStopAgain{250};  // while the call beside it goes on

struct BeamReport {
  Status status = Status::fault;
  std::string detail = {};
};

/// What the store takes: no number beyond it can have been measured.
bool plausible(const Pose& pose) {
  return std::abs(pose.x_mm) <= 1e6 && std::abs(pose.y_mm) <= 1e6 && std::abs(pose.phi_rad) <= 1e3;
}

Failure of(Status status, std::string detail) {
  if (status == Status::ok) return {};
  return {Failure::Cause::device, status, std::move(detail)};
}

/// A command may differ from the checked one by what compensation learns on the way.
CheckOptions with_slack(CheckOptions check) {
  constexpr double kSlackMm = 1, kSlackShare = 0.9;
  check.limit_margin_mm = std::max(0.0, check.limit_margin_mm - kSlackMm);
  check.singularity_margin *= kSlackShare;
  check.link_clearance_mm *= kSlackShare;
  check.max_platform_mm_s /= kSlackShare;
  return check;
}

}  // namespace

Failure unsafe(std::string detail) {
  return {Failure::Cause::unsafe, Status::fault, std::move(detail)};
}

std::string Failure::words() const {
  if (cause == Cause::cancelled) return "stopped by the operator";
  return cause == Cause::device ? std::string(device::name_of(status)) + ": " + detail : detail;
}

ExitCode Failure::exit_code() const {
  if (cause == Cause::unsafe || cause == Cause::elsewhere) return ExitCode::safety_stop;
  if (cause == Cause::gross) return ExitCode::invalid_data;
  return cause == Cause::storage ? ExitCode::storage : ExitCode::device;
}

Hands::Hands(std::shared_ptr<Devices> devices, const CheckOptions& check,
             const Deadlines& deadlines, std::function<bool()> meanwhile)
    : devices_(std::move(devices)),
      check_(with_slack(check)),
      deadlines_(deadlines),
      meanwhile_(std::move(meanwhile)) {
  const Machine& machine = devices_->machine;
  const InverseResult home = MachineSolver(machine).drives(machine.home);
  if (!home.ok()) throw InputError({.what = "the home pose is out of reach"});
  home_.l_mm = home_.from_mm = home.l_mm;
  place_ = home_;
  pose_ = machine.home;
}

template <class Report>
Failure Hands::call(const char* what, double deadline_s, Report& report,
                    std::function<Report(Devices&)> ask) {
  // The call owns what it writes to: it may outlive this.
  const auto answer = std::make_shared<Report>();
  const auto job = [answer, devices = devices_, ask = std::move(ask)] { *answer = ask(*devices); };
  const auto meanwhile = [this] {
    if (!cancelled_->load() && !(meanwhile_ && meanwhile_())) return;
    cancelled_->store(true);
    stop_beside();
  };
  if (!calls_.run(Watchdog::Seconds(deadline_s), job, meanwhile)) {
    hung_ = true;
    cancelled_->store(true);  // a stage that still asks learns it at its next poll
    return {
        Failure::Cause::hung, Status::timeout,
        fmt::format("{}: no answer within {:g} s; the watchdog stops the stage", what, deadline_s)};
  }
  if (cancelled_->load()) return {Failure::Cause::cancelled, Status::fault, what};
  report = *answer;
  return of(report.status, std::string(what) + ": " + report.detail);
}

Failure Hands::home() {
  device::StageReport report;
  Failure failure = call<device::StageReport>("homing", deadlines_.home_s, report,
                                              [](Devices& d) { return d.stage->home(); });
  if (failure.any()) return failure;
  place_ = home_;
  pose_ = devices_->machine.home;
  on_course_ = true;
  return {};
}

Failure Hands::move(const Displacements& to_mm) {
  if (!to_mm.allFinite()) return unsafe("a displacement that is not a number is not sent");
  const auto violations = check_move(devices_->machine, place_.l_mm, pose_, to_mm, check_);
  if (!violations.empty()) return unsafe("not sent: " + describe(violations.front()));
  const double length_mm = (to_mm - place_.l_mm).cwiseAbs().maxCoeff();
  const double speed_mm_s =
      devices_->motion.speed_mm_s > 0 ? devices_->motion.speed_mm_s : kSlowestMmS;
  const device::Watch watch = [devices = devices_.get(), cancelled = cancelled_] {
    return cancelled->load() ? Status::fault : devices->tracker->beam();
  };
  device::StageReport report;
  const Failure failure =
      call<device::StageReport>("stage", deadlines_.move_s + 2 * length_mm / speed_mm_s, report,
                                [to_mm, watch](Devices& d) { return d.stage->move(to_mm, watch); });
  if (failure.any()) {
    on_course_ = false;
    return failure;
  }
  for (int i = 0; i < kChains; ++i) {
    if (std::abs(to_mm[i] - place_.l_mm[i]) > kStandstillMm) place_.from_mm[i] = place_.l_mm[i];
  }
  stand_at(to_mm);
  if (!report.encoder_mm.allFinite()) return unsafe("the stage's encoders give no numbers");
  encoder_mm_ = report.encoder_mm;
  return {};
}

void Hands::stand_at(const Displacements& l_mm) {
  place_.l_mm = l_mm;
  const MachinePose at = MachineSolver(devices_->machine).pose(l_mm, pose_);
  if (at.ok()) pose_ = at.pose;
}

/// The call under way may be one that moves the stage, or is about to, and may be waiting for quite
/// another device: the stage is stopped now, and again until the call has returned. What it says is
/// asked for by stop().
void Hands::stop_beside() {
  const auto now = std::chrono::steady_clock::now();
  if (now < stopped_beside_ + kStopAgain) return;
  static_cast<void>(stops_.run(Watchdog::Seconds(deadlines_.stop_s), [devices = devices_] {
    static_cast<void>(devices->stage->stop());
  }));
  stopped_beside_ = std::chrono::steady_clock::now();
}

Failure Hands::stop() {
  const auto answer = std::make_shared<device::StageReport>();
  on_course_ = false;
  cancelled_->store(true);
  const bool returned =
      stops_.run(Watchdog::Seconds(deadlines_.stop_s),
                 [answer, devices = devices_] { *answer = devices->stage->stop(); });
  cancelled_->store(hung_);
  if (!returned) {
    return {Failure::Cause::hung, Status::timeout, "the stage does not answer to stop"};
  }
  if (answer->ok() && answer->encoder_mm.allFinite()) stand_at(answer->encoder_mm);
  return of(answer->status, "stop: " + answer->detail);
}

Failure Hands::beam() {
  BeamReport report;
  return call<BeamReport>("tracker", deadlines_.ask_s, report, [](Devices& d) {
    return BeamReport{d.tracker->beam(), "the reflector is not seen"};
  });
}

Failure Hands::temperature(const device::Occasion& occasion, double& temp_degc) {
  device::TemperatureReport report;
  const Failure failure = call<device::TemperatureReport>(
      "thermometer", deadlines_.ask_s, report,
      [occasion](Devices& d) { return d.thermometer->read(occasion); });
  if (failure.any()) return failure;
  if (!(report.temp_degc >= -273.15 && report.temp_degc <= 1000)) {
    return of(Status::fault, "thermometer: its answer is no temperature");
  }
  temp_degc = report.temp_degc;
  return {};
}

Failure Hands::measure(const device::Occasion& occasion, device::PoseReport& seen) {
  device::Occasion asked = occasion;
  if (measured_at_) {
    asked.moved_mm = std::hypot(pose_.x_mm - measured_at_->x_mm, pose_.y_mm - measured_at_->y_mm,
                                kArmMm * (pose_.phi_rad - measured_at_->phi_rad));
  }
  const Failure failure =
      call<device::PoseReport>("tracker", deadlines_.measure_s, seen,
                               [asked](Devices& d) { return d.tracker->measure(asked); });
  if (failure.any()) return failure;
  if (!plausible(seen.pose)) return of(Status::fault, "tracker: its answer is no pose");
  // A tracker sees more than an axis has: what the machine does not state as measured is left out.
  seen.pose = NominalMachine(devices_->machine).measured_else(seen.pose, {});
  measured_at_ = pose_;
  return {};
}

Failure Hands::base(const device::Occasion& occasion, BaseDrift& drift) {
  device::BaseReport report;
  const Failure failure = call<device::BaseReport>(
      "base nests", deadlines_.measure_s, report,
      [occasion](Devices& d) { return d.tracker->measure_base(occasion); });
  if (failure.any()) return failure;
  if (!plausible(report.drift.shift) || !std::isfinite(report.drift.largest_mm)) {
    return of(Status::fault, "base nests: their places are no numbers");
  }
  drift = report.drift;
  return {};
}

}  // namespace trammel::session
