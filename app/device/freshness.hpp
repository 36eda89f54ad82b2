#pragma once
// Whether an instrument's answer is of now: its own time, and that it is not the last one again.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace trammel::device {

/// "11/27/2026 14:00:00" in seconds of the instrument's own clock since 1970. Nothing for what is
/// no such date: 99/99/0000, 02/30/2026, 25:00:00, a year before 2020 or after 2099.
std::optional<std::int64_t> parse_stamp_s(std::string_view text);

/// The platform has moved when it stands so many sigma of a point from where it stood.
inline constexpr double kMovedSigmas = 10;

/// Seconds of this host's clock that only runs forward.
double host_now_s();

/// What an instrument has said before, and what its next answer must therefore say.
///
/// An instrument tells whole seconds of its own local time, which is ahead of the host's clock by
///   a = max over its answers of (stamp - host time of the answer)
/// (an answer that is old makes a no larger; it may fall by 1e-4 of the time, as clocks run apart).
/// An answer is old when
///   stamp < the latest stamp of this connection - 1 s                                        (1)
///   stamp < host time of the question + a - 2 s           (`by_host_clock` alone)            (2)
/// and of no time at all when it is later than its coming by more than the hour by which clocks are
/// put forward; but for one jump back by an hour (+-2 s against a), when the clocks are put back;
/// and where all values are the bits of the last answer for the same nest, though the platform has
/// moved. (3) Proof: freshness_test.cpp.
class Freshness {
 public:
  /// An emulated instrument has a time of its own, with which (2) does not go.
  explicit Freshness(bool by_host_clock = true) : by_host_clock_(by_host_clock) {}

  void connected() { latest_s_.reset(); }

  /// Why an answer is not of now; empty when it is. `stamp_s` is nothing where it could not be
  /// read.
  std::string look_at_time(const std::optional<std::int64_t>& stamp_s, double asked_s,
                           double answered_s);
  /// The same, of its values. `moved`: the platform stands elsewhere than at the last `taken`.
  std::string look_at_values(const std::string& nest, const std::vector<double>& values,
                             bool moved);
  /// All answers since the last time made a reading.
  void taken();

  /// The jump of the clock that was allowed, once; then nothing until the next.
  std::string take_note() { return std::exchange(note_, {}); }

 private:
  bool by_host_clock_;
  std::optional<std::int64_t> latest_s_;  // stamp, of this connection
  std::optional<double> ahead_s_;         // a
  double ahead_at_s_ = 0;                 // on the host's clock
  bool hour_taken_ = false;
  std::string note_;
  std::map<std::string, std::vector<double>> last_, now_;  // values by nest
};

}  // namespace trammel::device
