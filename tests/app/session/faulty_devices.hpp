#pragma once
// Devices that fail as told, in front of the simulated ones.

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "app/device/open.hpp"

namespace trammel::tests {

/// What goes wrong, and what was asked for. Each is asked before the call is let through, with the
/// number of that call from 1; an answer that is not ok is the device's.
struct Faults {
  using Ask = std::function<device::Status(int call)>;
  Ask home = {}, move = {}, stop = {}, beam = {}, measure = {}, thermometer = {};
  // What a device answers in place of its own number.
  std::function<void(device::PoseReport&, int call)> pose = {};
  std::function<void(device::TemperatureReport&, int call)> temperature = {};
  std::function<void(device::StageReport&, int call)> encoder = {};
  std::function<void(device::Devices&)> altered = {};  // when they are opened

  int homes = 0, moves = 0, measures = 0, temperatures = 0;
  std::atomic<int> stops = 0, beams = 0;
  /// After a device has failed the next call must be a stop: calls that were not.
  int calls_before_stop = 0;
  bool failed = false;

  void called() { calls_before_stop += failed ? 1 : 0; }
  device::Status asked(const Ask& ask, int call) {
    const device::Status status = ask ? ask(call) : device::Status::ok;
    failed = failed || status != device::Status::ok;
    return status;
  }
};

class FaultyStage : public device::Stage {
 public:
  FaultyStage(std::unique_ptr<Stage> real, std::shared_ptr<Faults> faults)
      : real_(std::move(real)), faults_(std::move(faults)) {}
  [[nodiscard]] std::string describe() const override { return real_->describe(); }
  [[nodiscard]] bool homed() const override { return real_->homed(); }
  device::StageReport home() override {
    faults_->called();
    const auto told = faults_->asked(faults_->home, ++faults_->homes);
    if (told != device::Status::ok) return {told, "as told", {}};
    return real_->home();
  }
  device::StageReport move(const Displacements& to_mm, const device::Watch& watch) override {
    faults_->called();
    const auto told = faults_->asked(faults_->move, ++faults_->moves);
    if (told != device::Status::ok) return {told, "as told", {}};
    device::StageReport report = real_->move(to_mm, watch);
    faults_->failed = faults_->failed || !report.ok();
    if (faults_->encoder) faults_->encoder(report, faults_->moves);
    return report;
  }
  device::StageReport stop() override {
    faults_->failed = false;
    const int call = ++faults_->stops;
    const auto told = faults_->stop ? faults_->stop(call) : device::Status::ok;
    if (told != device::Status::ok) return {told, "as told", {}};
    return real_->stop();
  }

 private:
  std::unique_ptr<Stage> real_;
  std::shared_ptr<Faults> faults_;
};

class FaultyTracker : public device::Tracker {
 public:
  FaultyTracker(std::unique_ptr<Tracker> real, std::shared_ptr<Faults> faults)
      : real_(std::move(real)), faults_(std::move(faults)) {}
  [[nodiscard]] std::string describe() const override { return real_->describe(); }
  [[nodiscard]] device::Status beam() override {
    const int call = ++faults_->beams;
    const auto told = faults_->beam ? faults_->beam(call) : device::Status::ok;
    return told != device::Status::ok ? told : real_->beam();
  }
  device::PoseReport measure(const device::Occasion& occasion) override {
    faults_->called();
    const auto told = faults_->asked(faults_->measure, ++faults_->measures);
    if (told != device::Status::ok) return {told, "as told", {}, ""};
    device::PoseReport report = real_->measure(occasion);
    if (faults_->pose) faults_->pose(report, faults_->measures);
    return report;
  }

 private:
  std::unique_ptr<Tracker> real_;
  std::shared_ptr<Faults> faults_;
};

class FaultyThermometer : public device::Thermometer {
 public:
  FaultyThermometer(std::unique_ptr<Thermometer> real, std::shared_ptr<Faults> faults)
      : real_(std::move(real)), faults_(std::move(faults)) {}
  [[nodiscard]] std::string describe() const override { return real_->describe(); }
  device::TemperatureReport read(const device::Occasion& occasion) override {
    faults_->called();
    const auto told = faults_->asked(faults_->thermometer, ++faults_->temperatures);
    if (told != device::Status::ok) return {told, "as told", 0};
    device::TemperatureReport report = real_->read(occasion);
    if (faults_->temperature) faults_->temperature(report, faults_->temperatures);
    return report;
  }

 private:
  std::unique_ptr<Thermometer> real_;
  std::shared_ptr<Faults> faults_;
};

inline device::Devices with_faults(device::Devices devices, const std::shared_ptr<Faults>& faults) {
  devices.stage = std::make_unique<FaultyStage>(std::move(devices.stage), faults);
  devices.tracker = std::make_unique<FaultyTracker>(std::move(devices.tracker), faults);
  devices.thermometer = std::make_unique<FaultyThermometer>(std::move(devices.thermometer), faults);
  if (faults->altered) faults->altered(devices);
  return devices;
}

/// For Surroundings::open.
inline auto opening(std::shared_ptr<Faults> faults) {
  return [faults = std::move(faults)](const std::string& stage, const std::string& tracker) {
    return with_faults(device::open_devices(stage, tracker), faults);
  };
}

}  // namespace trammel::tests
