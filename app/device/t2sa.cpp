#include "app/device/t2sa.hpp"

#include <fmt/format.h>

#include <chrono>
#include <thread>
#include <utility>

#include "core/error.hpp"
#include "core/measure/base_frame.hpp"

namespace trammel::device {

namespace {

constexpr double kWarmUpPauseS = 1;

PoseReport refused(const T2saReply& reply, const std::string& asked) {
  return {status_of_t2sa(reply.code), asked + ": " + reply.raw, {}, reply.raw};
}

}  // namespace

std::string T2saTracker::describe() const {
  return "laser tracker behind T2SA at " + settings_.server.text();
}

Status T2saTracker::lost(const LinkError& error) {
  wire_.reset();
  const bool may_come_back = reached_ && error.kind != LinkError::Kind::nonsense;
  return may_come_back ? Status::timeout : Status::fault;
}

void T2saTracker::connect() {
  if (wire_) return;
  auto wire = std::make_unique<T2saWire>(settings_.server, settings_.connect_timeout_s,
                                         settings_.reply_timeout_s);
  wire_ = std::move(wire);
  fresh_.connected();
  reached_ = true;
  warm_up();
}

/// Until the laser is on: LOFF, then WARM for a while, then LON.
void T2saTracker::warm_up() {
  const Deadline deadline = in_s(settings_.warm_up_s);
  bool switched_on = false;
  for (;;) {
    const T2saReply laser = wire_->ask("?LSTA");
    if (laser.accepted && laser.body.starts_with("LON")) return;
    if (!switched_on && laser.body.starts_with("LOFF")) {
      static_cast<void>(wire_->ask("!LST:1"));
      switched_on = true;
      continue;
    }
    if (!laser.accepted || in_s(kWarmUpPauseS) >= deadline) {
      throw LinkError(LinkError::Kind::silent,
                      {.what = "the laser is not on", .got = laser.raw, .expected = "LON"});
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(kWarmUpPauseS));
  }
}

Status T2saTracker::beam() {
  try {
    connect();
    const T2saReply state = wire_->ask("?STAT", false);
    if (parse_t2sa_point(state.body) || parse_t2sa_offset(state.body)) {
      wire_->out_of_step("?STAT", state.raw, "a state");
    }
    if (state.accepted || state.code == kT2saBusy) return Status::ok;
    return status_of_t2sa(state.code);
  } catch (const LinkError& error) {
    return lost(error);
  }
}

/// Why a point is not of now; empty when it is.
std::string T2saTracker::not_of_now(const T2saTarget& target, const T2saPoint& point,
                                    double asked_s, bool moved) {
  const std::string why = fresh_.look_at_time(point.stamp_s, asked_s, host_now_s());
  if (!why.empty()) return why;
  const Eigen::Vector3d& at = point.at_mm;
  return fresh_.look_at_values(target.address, {at.x(), at.y(), at.z()}, moved);
}

/// An answer that is not of now: what comes next on this line is not trusted either.
PoseReport T2saTracker::old(const std::string& why, const std::string& asked,
                            const T2saReply& reply) {
  wire_.reset();
  return {Status::timeout, asked + ": an answer that is not of now, " + why + ": " + reply.raw};
}

/// Measures the targets one after the other; stops at the first that fails. raw_reply has all.
PoseReport T2saTracker::points_of(const std::vector<T2saTarget>& targets, bool moved,
                                  std::vector<NestPoint>& points) {
  PoseReport report{Status::ok, ""};
  for (const T2saTarget& target : targets) {
    const std::string asked = "!MEAS_SINGLE_POINT:" + target.address;
    const double asked_s = host_now_s();
    const T2saReply reply = wire_->ask(asked);
    report.raw_reply += (report.raw_reply.empty() ? "" : "\n") + reply.raw;
    const auto point = parse_t2sa_point(reply.body);
    const std::string name = target.address.substr(target.address.rfind(';') + 1);
    if (reply.accepted && !(point && t2sa_name_is(point->name, name))) {
      wire_->out_of_step(asked, reply.raw, "Single Point Measurement " + name + " …");
    }
    PoseReport failed;
    if (!reply.accepted) {
      failed = refused(reply, asked);
    } else if (const std::string why = not_of_now(target, *point, asked_s, moved); !why.empty()) {
      failed = old(why, asked, reply);
    } else if (!point->good) {
      failed = {Status::unstable, asked + ": the point was not accepted: " + reply.raw};
    } else {
      points.push_back({target.nest, point->at_mm});
      continue;
    }
    failed.raw_reply = report.raw_reply;
    return failed;
  }
  return report;
}

/// Once an epoch: what was set up anew may stand elsewhere.
PoseReport T2saTracker::register_base(int epoch) {
  if (registered_epoch_ == epoch || settings_.base.empty()) return {Status::ok, ""};
  std::vector<NestPoint> points;
  PoseReport report = points_of(settings_.base_points, false, points);
  if (!report.ok()) {
    report.detail = "base nests: " + report.detail;
    return report;
  }
  const BaseFrame frame = frame_of_base(points, settings_.base);
  settings_.nests.frame.T_B_T = frame.T_B_T;
  registered_ = std::move(points);
  registered_epoch_ = epoch;
  return report;
}

PoseReport T2saTracker::measure_points(bool moved) {
  std::vector<NestPoint> points;
  PoseReport report = points_of(settings_.points, moved, points);
  if (!report.ok()) return report;
  return pose_report(points, settings_.nests, report.raw_reply);
}

PoseReport T2saTracker::measure_object(bool moved) {
  const std::string& group = settings_.object_group;
  const double asked_s = host_now_s();
  const T2saReply done = wire_->ask("!CMDEXE:" + group);
  if (!done.accepted) return refused(done, "!CMDEXE:" + group);
  const std::string asked = settings_.object_reference.empty()
                                ? "?POS " + group
                                : "?OFFSET:" + group + ";" + settings_.object_reference;
  const T2saReply reply = wire_->ask(asked);
  if (!reply.accepted) return refused(reply, asked);
  const auto frame = parse_t2sa_offset(reply.body);
  if (!(frame && t2sa_name_holds(frame->name, group))) {
    wire_->out_of_step(asked, reply.raw, "Object Offset Report … " + group + " …");
  }
  std::string why = fresh_.look_at_time(frame->stamp_s, asked_s, host_now_s());
  if (why.empty()) {
    const double* values = frame->T.data();
    why = fresh_.look_at_values(group, {values, values + frame->T.matrix().size()}, moved);
  }
  if (!why.empty()) return old(why, asked, reply);
  return pose_report(frame->T, settings_.nests, reply.raw);
}

/// Since the registration; the first time that is just now.
BaseReport T2saTracker::measure_base(const Occasion& occasion) {
  try {
    connect();
    PoseReport report = register_base(occasion.epoch);
    std::vector<NestPoint> points;
    if (report.ok()) report = points_of(settings_.base_points, false, points);
    if (!report.ok()) return {report.status, report.detail};
    return {Status::ok, "",
            base_drift(registered_, points, settings_.nests.frame.T_B_T, settings_.nests.sigma_mm)};
  } catch (const LinkError& error) {
    return {lost(error), error.what()};
  } catch (const InputError& error) {
    return {Status::fault, error.what()};
  }
}

PoseReport T2saTracker::measure(const Occasion& occasion) {
  try {
    connect();
    PoseReport report = register_base(occasion.epoch);
    if (!report.ok()) return report;
    const bool moved = occasion.moved_mm > kMovedSigmas * settings_.nests.sigma_mm;
    report = settings_.object_group.empty() ? measure_points(moved) : measure_object(moved);
    if (!report.ok()) return report;
    fresh_.taken();
    report.detail = fresh_.take_note();
    return report;
  } catch (const LinkError& error) {
    return {lost(error), error.what()};
  } catch (const InputError& error) {  // base nests on one line, a point that is no point
    return {Status::fault, error.what()};
  }
}

}  // namespace trammel::device
