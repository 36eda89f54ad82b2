// Lines, prompts and handles.

#include "app/emulate/galil.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/emulate/stage_link.hpp"

namespace trammel::emulate {

namespace {

struct ErrorRow {
  int code;
  const char* words;
};

constexpr std::array<ErrorRow, 27> kErrors = {{
    {1, "Unrecognized command"},
    {2, "Command only valid from program"},
    {3, "Command not valid in program"},
    {4, "Operand error"},
    {5, "Input buffer full"},
    {6, "Number out of range"},
    {7, "Command not valid while running"},
    {8, "Command not valid while not running"},
    {9, "Variable error"},
    {10, "Empty program line or undefined label"},
    {11, "Invalid label or line number"},
    {20, "Begin not valid with motor off"},
    {21, "Begin not valid while running"},
    {22, "Begin not possible due to Limit Switch"},
    {24, "Begin not valid because no sequence defined"},
    {50, "Not enough fields"},
    {51, "Question mark not valid"},
    {58, "Bad command response i.e. _GNX"},
    {66, "Array space full"},
    {82, "Undefined Array"},
    {124, "Ethernet handle already in use"},
    {126, "Closed Ethernet handle"},
    {133, "Command locked"},
    {134, "All motors must be in MO for this command"},
    {135, "Motor must be in MO"},
    {140, "Serial encoder error"},
    {141, "Feature not supported"},
}};

class GalilConversation : public Conversation {
 public:
  GalilConversation(Galil& galil, Faults& faults, const Peer& peer)
      : galil_(galil), faults_(faults), handle_(galil.attach(peer)) {}
  ~GalilConversation() override { galil_.detach(handle_); }

  std::vector<Answer> receive(std::string_view bytes) override {
    std::vector<Answer> answers;
    for (const LineReader::Line& line : reader_.add(bytes)) {
      if (line.too_long) download_.reset();  // such a program is not taken
      const auto download = of_download(line.text);
      if (download && download->empty()) continue;
      Answer answer{.bytes = download        ? *download
                             : line.too_long ? galil_.line_too_long()
                                             : galil_.line(line.text)};
      answers.push_back(over_bad_line(faults_, line.text, std::move(answer)));
    }
    return answers;
  }

 private:
  /// What a line of a download is answered, from DL to ^Z or a backslash: nothing before the end,
  /// and then a prompt for each of the two [S: a MIDAS front end waits for "::"]. Nothing for a
  /// line of no download. DL is refused while a program runs [K].
  std::optional<std::string> of_download(const std::string& text) {
    if (!download_) {
      if (text != "DL" || galil_.programs.any_runs()) return std::nullopt;
      download_.emplace();
      return "";
    }
    const bool ends = text.ends_with('\x1a') || text.ends_with('\\');
    download_->push_back(text.substr(0, text.size() - (ends ? 1 : 0)));
    if (!ends) return "";
    galil_.programs.load(*std::exchange(download_, {}));
    return "::";
  }

  Galil& galil_;
  Faults& faults_;
  int handle_;
  std::optional<std::vector<std::string>> download_;
  LineReader reader_{'\r', kMaxLine};
};

}  // namespace

std::string error_text(int code) {
  const auto* row = std::find_if(kErrors.begin(), kErrors.end(),
                                 [code](const ErrorRow& r) { return r.code == code; });
  if (row == kErrors.end()) return std::to_string(code);
  return fmt::format("{} {}", code, row->words);
}

Galil::Galil(EmulatedRobot& robot, Faults& faults) : robot_(robot), faults_(faults) {
  for (Axis& a : axes_) a.motion = a.motion.blocked(0);  // nothing wired, nothing moves
  for (int i = 0; i < robot.robot().truth().nominal.kind->n_chains; ++i) {
    Axis& a = axis(i);
    a.rail = i;
    a.motion = robot.at_power_up(i);
    a.zero = a.motion.at(0).commanded;  // at power-up the register says 0, wherever the rail is
  }
}

std::string Galil::line(std::string_view text) {
  std::string answer = echo ? std::string(text) + "\r" : "";
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find(';', from), text.size());
    answer += sub_command(text.substr(from, end - from));
    from = end + 1;
  }
  return answer;
}

std::string Galil::line_too_long() {
  error = 5;
  return "?";
}

std::string Galil::sub_command(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  if (text.empty()) return ":";
  update();
  try {
    return run_command(*this, text) + ":";
  } catch (const Refused& refused) {
    error = refused.code;
    return "?";
  }
}

int Galil::attach(const Peer& peer) {
  for (std::size_t k = 0; k < handles_.size(); ++k) {
    if (handles_[k].port != 0) continue;
    handles_[k] = peer;
    return static_cast<int>(k);
  }
  return -1;  // a server with more connections than the controller has handles
}

void Galil::detach(int handle) {
  if (handle >= 0) handles_[static_cast<std::size_t>(handle)] = {};
}

std::string Galil::handles_text() const {
  const auto commas = [](std::string address) {
    std::replace(address.begin(), address.end(), '.', ',');
    return address;
  };
  std::string text = "CONTROLLER IP ADDRESS 127,0,0,1 ETHERNET ADDRESS 00-50-4C-20-31-32\r\n";
  for (std::size_t k = 0; k < handles_.size(); ++k) {
    const char letter = static_cast<char>('A' + k);
    if (handles_[k].port == 0) {
      text += fmt::format(" IH{} AVAILABLE\r\n", letter);
    } else {
      text += fmt::format(" IH{} TCP PORT 23 TO IP ADDRESS {} PORT {}\r\n", letter,
                          commas(handles_[k].address), handles_[k].port);
    }
  }
  return text;
}

std::string Galil::standing_text() const { return emulate::standing_text(robot_.standing()); }

Server::Make galil_conversations(Galil& galil, Faults& faults) {
  return [&galil, &faults](const Peer& peer) -> std::unique_ptr<Conversation> {
    return std::make_unique<GalilConversation>(galil, faults, peer);
  };
}

}  // namespace trammel::emulate
