#pragma once
// Commands and answers of a Galil DMC-41x3 over one connection. README.md has the rules of the
// wire and where each was read.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/device/tcp.hpp"

namespace trammel::device {

/// The controller answered `?`: what was sent, and what it said to TC1.
struct GalilRefusal : DeviceError {
  GalilRefusal(int tc_code, ErrorText text) : DeviceError(std::move(text)), code(tc_code) {}
  int code;
};

struct GalilReply {
  bool accepted = false;
  std::string value = {};  // without blanks and line ends; empty for a command without an answer
};

/// Cuts the byte stream into answers. A prompt is `:` (done) or `?` (refused) where a line begins,
/// blanks aside; there is one for each `;` part of what was sent. Bytes with bit 7 set are the text
/// of a program in the controller (CW 1) and belong to no answer.
/// Proof: galil_wire_test.cpp (the golden exchanges, cut at every byte).
class GalilReplyCutter {
 public:
  void feed(std::string_view bytes);
  /// The next complete answer.
  std::optional<GalilReply> next();
  /// Bytes that make no complete answer.
  [[nodiscard]] const std::string& rest() const { return rest_; }
  /// What programs in the controller said, and forgets it.
  std::string take_unsolicited();

 private:
  std::string rest_;
  std::string unsolicited_;
};

/// Longest line the controller takes, the carriage return included (80 [S] for its sisters, [K]
/// for the DMC-41x3).
inline constexpr std::size_t kGalilLineBytes = 80;

class GalilWire {
 public:
  /// Connects, turns echo off (EO 0) and marks unsolicited text (CW 1). Throws LinkError,
  /// GalilRefusal. `first` is sent at once, before anything is waited for: a stop that a slow line
  /// must not hold back. Whether it was refused is for who asks next.
  GalilWire(const Endpoint& to, double connect_timeout_s, double reply_timeout_s,
            const std::string& first = {});

  /// Sends one command that may be refused. Throws GalilRefusal with the text of TC1; LinkError
  /// when the outcome is unknown.
  std::string command(const std::string& line);

  /// Puts a program in the place of the one in the controller's memory (DL … ^Z) [K, the two
  /// prompts of its end S]. Throws as command().
  void download(const std::vector<std::string>& lines);

  /// Asks several questions at once ("TPA;TPB"), none of which a controller refuses: one answer
  /// each. A refusal is a LinkError: how the rest of such a line is answered is not documented.
  std::vector<std::string> ask(const std::string& line);

  /// The same, as numbers. An answer that is no number of 32 bits is a LinkError.
  std::vector<double> ask_numbers(const std::string& line);

  /// Whether the line is still open and in step, now that nothing is being asked.
  [[nodiscard]] bool alive();

  /// What programs in the controller said meanwhile.
  std::string take_unsolicited() { return cutter_.take_unsolicited(); }
  [[nodiscard]] const Endpoint& endpoint() const { return link_.endpoint(); }

 private:
  void send(const std::string& line);
  void send_bytes(const std::string& bytes);
  GalilReply receive(const std::string& line, Deadline deadline);
  [[noreturn]] void nonsense(const std::string& what, const std::string& got);

  TcpLink link_;
  double reply_timeout_s_;
  GalilReplyCutter cutter_;
};

}  // namespace trammel::device
