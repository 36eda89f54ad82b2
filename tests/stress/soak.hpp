#pragma once
// Thousands of points over sockets, on devices that fail at random, by a runner that is stopped and
// dies.

#include <cstdint>
#include <string>

#include "app/emulate/faults.hpp"
#include "core/plan/plan.hpp"
#include "tests/app/session/socket_campaign.hpp"

namespace trammel::test {

/// The paper's 80 points again and again.
Plan soak_plan(int n_points);
/// Nothing changes with the time: what is left between two runs is noise.
tests::SocketOptions steady();

struct SoakOptions {
  int n_points = 2000;  // 80 or more
  double share = 0.15;  // of points at which a device fails
  std::uint64_t seed = 20240973;
};

struct SoakCount {
  int points = 0;          // stored in the end
  int faults = 0;          // that struck
  int failed_tries = 0;    // stored as such
  int lives = 0;           // of the runner: the first, and each resume
  int deaths = 0;          // of these, cut off between two statements
  int lost = 0;            // lives after which fewer points were there than had been acknowledged
  int wrong = 0;           // readings that are repeated, or not what the robot really did
  int early = 0;           // the control: lives that a program which acknowledges a point when it
                           // begins it would have ended with a loss
  int parameters = 0;      // independent combinations of parameters that are identified
  double worst_sigma = 0;  // largest difference among them from those of the fault-free run, in
                           // standard uncertainties of the difference
  std::string first_problem = {};
};

/// The emulators' servers, the Galil and T2SA drivers, the real runner and a database on disk; the
/// same plan without faults beside it. Every kind of fault strikes, at random occasions.
SoakCount soak_over_sockets(const SoakOptions& options = {});

struct WireCount {
  int runs = 0;     // campaigns, one fault each
  int resumed = 0;  // that faulted, and were gone on with
  int wrong = 0;    // that did not come to their end, or hold a reading that is repeated or invalid
  std::string first_problem = {};
};

/// A campaign of four points again and again, with one answer lost, halved or dropped: that to the
/// n-th line to the stage, then to the tracker, n = 1, 1 + stride, … to the last.
WireCount sweep_wires(emulate::FaultKind kind, std::uint64_t stride = 1);

}  // namespace trammel::test
