#pragma once
// What goes wrong on command: data, counted, so that a test can prove that it happened.

#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "app/emulate/server.hpp"

namespace trammel::emulate {

enum class FaultKind {
  lost_reply,       // the command is carried out, nothing is answered
  half_reply,       // the command is carried out, half of the answer arrives
  dropped,          // the command is carried out, the connection closes
  beam_break,       // tracker: a measurement finds no reflector
  beam_lost,        // tracker: a question for its status finds no reflector
  unstable,         // tracker: a measurement scatters far beyond its noise
  limit_hit,        // stage: a limit switch acts halfway through a move
  amplifier_fault,  // stage: a motor loses its power halfway through a move
  stall,            // stage: a motor does not follow its command
};

/// Strikes at the `at`-th occasion, from 1, of those that contain `only` (a command's text).
struct Fault {
  FaultKind kind = FaultKind::lost_reply;
  std::uint64_t at = 1;
  std::string only = {};
};

const char* name_of(FaultKind kind);

enum class Emulated { stage, tracker };

/// "KIND@N" or "KIND@N:TEXT", as "lost-reply@3:BG". Throws UsageError that lists the kinds which
/// `device` can have.
Fault parse_fault(std::string_view text, Emulated device);

/// "lost-reply, half-reply, …": the kinds a device can have.
std::string fault_kinds(Emulated device);

/// Safe to use from several threads.
class Faults {
 public:
  void add(const Fault& fault);
  /// At the next occasion from now on.
  void add_next(FaultKind kind, std::string only = {}) { add({kind, 1, std::move(only)}); }

  /// One occasion for faults of this kind: counts it for each of them, and says whether one
  /// strikes. Each fault counts from when it was added, and strikes once.
  [[nodiscard]] bool strikes(FaultKind kind, std::string_view command = {});

  /// How often a fault of this kind has struck.
  [[nodiscard]] int struck(FaultKind kind) const;

 private:
  struct Waiting {
    Fault fault;
    std::uint64_t seen = 0;
    bool done = false;
  };
  mutable std::mutex mutex_;
  std::vector<Waiting> all_;
};

/// What is left of the answer to `command` on a bad line: nothing, half of it, or a closed
/// connection. The command has been carried out all the same.
Answer over_bad_line(Faults& faults, std::string_view command, Answer answer);

}  // namespace trammel::emulate
