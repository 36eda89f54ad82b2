#pragma once
// The controller watches this program: one that is killed, stopped, cut off from the network or
// without power leaves rails that come to rest.

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "app/device/galil_settings.hpp"
#include "app/device/galil_wire.hpp"

namespace trammel::device {

/// The program on the controller. Each W = watch_host_s / 2 it clears what it is fed with, and
/// stops the rails when nothing has come since: no sooner than W and no later than 2 W after the
/// last feed. Once they rest the servos go off.
std::vector<std::string> host_watch_program(const GalilSettings& settings);

/// Loads that program over `wire` (in the place of the program in the controller's memory; nothing
/// is burned in), starts it and sees it run; then feeds it over a connection of its own until
/// destroyed. A feed that is lost is tried again on a new connection: what counts is the deadline.
/// Throws LinkError; GalilRefusal where the controller does not run it. Precondition: the rails
/// rest. Proof: tests/app/device/galil_watch_test.cpp.
class GalilHostWatch {
 public:
  GalilHostWatch(GalilWire& wire, const GalilSettings& settings);
  ~GalilHostWatch();
  GalilHostWatch(const GalilHostWatch&) = delete;
  GalilHostWatch& operator=(const GalilHostWatch&) = delete;

  /// False: it was not fed in time and has stopped the rails, or somebody has ended it.
  [[nodiscard]] static bool runs(GalilWire& wire);
  /// Ends the program, so that nothing need be fed.
  static void end(GalilWire& wire);

 private:
  void feed();

  GalilSettings settings_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace trammel::device
