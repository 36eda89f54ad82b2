#include "app/device/galil_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/device/galil_look.hpp"

namespace trammel::device {

namespace {

constexpr int kThread = 1;                 // 0 is what XQ alone and #AUTO use
constexpr int kFeedsPerDeadline = 8;       // four a window: three may be late
constexpr double kWatchRestMarginS = 0.5;  // beyond v / a: an encoder that follows its command

/// WT takes even milliseconds [K].
long wait_ms(double seconds) { return 2 * std::lround(seconds * 1000 / 2); }

const std::string kFeed = "hostfed=1";

}  // namespace

std::vector<std::string> host_watch_program(const GalilSettings& s) {
  const std::string axes = letters_of(s.axes);
  const double rest_s = std::max(s.speed_mm_s, s.homing_speed_mm_s) / s.acceleration_mm_s2;
  return {"#HOST",
          "hostfed=0",
          fmt::format("WT {}", wait_ms(s.watch_host_s / 2)),
          "JP #HOST,hostfed=1",
          "ST" + axes,
          fmt::format("WT {}", wait_ms(rest_s + kWatchRestMarginS)),
          "MO" + axes,
          "EN"};
}

GalilHostWatch::GalilHostWatch(GalilWire& wire, const GalilSettings& settings)
    : settings_(settings) {
  end(wire);  // of a program before this one, that was killed just now
  wire.download(host_watch_program(settings));
  wire.command(fmt::format("XQ #HOST,{}", kThread));
  wire.command(kFeed);
  const Deadline deadline = in_s(settings.watch_host_s / 2 + settings.reply_timeout_s);
  while (wire.ask_numbers("MG hostfed").front() != 0) {
    if (std::chrono::steady_clock::now() < deadline) {
      wait_s(settings.watch_host_s / kFeedsPerDeadline);
      continue;
    }
    throw GalilRefusal(0, {.what = "the controller does not run the program that watches its host",
                           .where = {.field = "controller.watch_host_s"},
                           .hint = "0 goes without: then nothing stops the rails when this program "
                                   "is killed"});
  }
  thread_ = std::thread([this] { feed(); });
}

GalilHostWatch::~GalilHostWatch() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool GalilHostWatch::runs(GalilWire& wire) {
  return wire.ask_numbers(fmt::format("MG _XQ{}", kThread)).front() >= 0;
}

void GalilHostWatch::end(GalilWire& wire) { wire.command(fmt::format("HX{}", kThread)); }

void GalilHostWatch::feed() {
  const std::chrono::duration<double> period(settings_.watch_host_s / kFeedsPerDeadline);
  std::unique_ptr<GalilWire> wire;
  std::unique_lock lock(mutex_);
  while (!ends_) {
    lock.unlock();
    try {
      if (!wire) {
        wire = std::make_unique<GalilWire>(settings_.controller, settings_.connect_timeout_s,
                                           settings_.watch_host_s);
      }
      wire->command(kFeed);
    } catch (const DeviceError&) {
      wire.reset();
    }
    lock.lock();
    changed_.wait_for(lock, period, [this] { return ends_; });
  }
}

}  // namespace trammel::device
