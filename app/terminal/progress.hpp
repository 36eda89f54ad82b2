#pragma once

#include <chrono>
#include <string>

namespace trammel::terminal {

/// n/N, time left, last deviation; on stderr: a bar that is drawn over itself on a terminal, else a
/// line now and then.
class Progress {
 public:
  /// `quiet`: nothing at all. `already`: points stored by earlier runs.
  Progress(bool quiet, bool terminal, int already, int total);

  /// `done` of the total are done, and what else there is to say.
  void reached(int done, const std::string& note = {});
  /// One more point is stored; its pose was `deviation_mm` off the target.
  void stored(double deviation_mm);
  /// A line of its own, above the bar.
  void say(const std::string& text);
  /// Ends the bar's line.
  void end();

 private:
  [[nodiscard]] std::string time_left() const;

  bool quiet_;
  bool terminal_;
  int already_;
  int done_;
  int total_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

/// "12:34 min", "1:02:03 h".
std::string clock_text(double seconds);

}  // namespace trammel::terminal
