#include "app/device/galil_wire.hpp"

#include <algorithm>
#include <utility>

#include "app/files/numbers.hpp"

namespace trammel::device {

namespace {

constexpr std::size_t kMaxAnswerBytes = 65'536;
constexpr char kTextBit = '\x80';
constexpr double kEnd = 2147483648.0;  // counts and operands are s32 [S]: from -kEnd to below kEnd

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const std::size_t from = text.find_first_not_of(kBlank);
  if (from == std::string_view::npos) return {};
  return text.substr(from, text.find_last_not_of(kBlank) - from + 1);
}

/// "20 Begin not valid with motor off": the number, 0 where there is none.
int code_of(const std::string& tc1) {
  return parse_integer(std::string_view(tc1).substr(0, tc1.find(' '))).value_or(0);
}

}  // namespace

void GalilReplyCutter::feed(std::string_view bytes) {
  for (const char byte : bytes) {
    if ((byte & kTextBit) != 0) {
      unsolicited_ += static_cast<char>(byte & ~kTextBit);
    } else {
      rest_ += byte;
    }
  }
  if (unsolicited_.size() > kMaxAnswerBytes) {
    unsolicited_.erase(0, unsolicited_.size() - kMaxAnswerBytes);
  }
}

std::optional<GalilReply> GalilReplyCutter::next() {
  bool line_begins = true;
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    const char byte = rest_[k];
    if (line_begins && (byte == ':' || byte == '?')) {
      const GalilReply reply{byte == ':', std::string(trimmed({rest_.data(), k}))};
      rest_.erase(0, k + 1);
      return reply;
    }
    if (byte == '\n' || byte == '\r') {
      line_begins = true;
    } else if (byte != ' ') {
      line_begins = false;
    }
  }
  return std::nullopt;
}

std::string GalilReplyCutter::take_unsolicited() { return std::exchange(unsolicited_, {}); }

GalilWire::GalilWire(const Endpoint& to, double connect_timeout_s, double reply_timeout_s,
                     const std::string& first)
    : link_(to, in_s(connect_timeout_s)), reply_timeout_s_(reply_timeout_s) {
  if (!first.empty()) {
    send(first);
    static_cast<void>(receive(first, in_s(reply_timeout_s_)));
  }
  command("EO 0");
  command("CW 1");
}

void GalilWire::nonsense(const std::string& what, const std::string& got) {
  link_.close();
  throw LinkError(
      LinkError::Kind::nonsense,
      {.what = what,
       .got = "'" + got.substr(0, 60) + "' from " + link_.endpoint().text(),
       .hint = "is this a Galil controller, and does no other program speak over this line?"});
}

bool GalilWire::alive() {
  try {
    cutter_.feed(link_.pending());
    return cutter_.rest().empty();
  } catch (const LinkError&) {
    return false;
  }
}

void GalilWire::send(const std::string& line) {
  TRAMMEL_ASSERT(line.size() + 1 <= kGalilLineBytes);
  send_bytes(line + "\r");
}

void GalilWire::send_bytes(const std::string& bytes) {
  cutter_.feed(link_.pending());
  if (!cutter_.rest().empty()) nonsense("an answer that nobody asked for", cutter_.rest());
  link_.send(bytes, in_s(reply_timeout_s_));
}

void GalilWire::download(const std::vector<std::string>& lines) {
  std::string text = "DL\r";
  for (const std::string& line : lines) text += line + "\r";
  send_bytes(text + "\x1a\r");
  const Deadline deadline = in_s(reply_timeout_s_);
  for (int prompts = 0; prompts < 2; ++prompts) {
    if (!receive("DL", deadline).accepted) nonsense("the controller takes no program", "?");
  }
}

GalilReply GalilWire::receive(const std::string& line, Deadline deadline) {
  for (;;) {
    if (const auto reply = cutter_.next()) return *reply;
    if (cutter_.rest().size() > kMaxAnswerBytes) {
      nonsense("an answer without end to " + line, cutter_.rest());
    }
    try {
      cutter_.feed(link_.receive(deadline));
    } catch (const LinkError& error) {
      ErrorText text = error.text();
      text.where.field = line;
      if (!cutter_.rest().empty()) text.what += ", only half of one";
      throw LinkError(error.kind, text);
    }
  }
}

std::string GalilWire::command(const std::string& line) {
  send(line);
  const GalilReply reply = receive(line, in_s(reply_timeout_s_));
  if (reply.accepted) return reply.value;
  send("TC1");
  const GalilReply why = receive("TC1", in_s(reply_timeout_s_));
  throw GalilRefusal(code_of(why.value), {.what = "the controller refuses a command",
                                          .where = {.field = line},
                                          .got = why.accepted ? why.value : "no reason"});
}

std::vector<std::string> GalilWire::ask(const std::string& line) {
  send(line);
  const Deadline deadline = in_s(reply_timeout_s_);
  std::vector<std::string> values;
  for (auto left = std::count(line.begin(), line.end(), ';') + 1; left > 0; --left) {
    const GalilReply reply = receive(line, deadline);
    if (!reply.accepted) nonsense("the controller refuses a question", line);
    values.push_back(reply.value);
  }
  return values;
}

std::vector<double> GalilWire::ask_numbers(const std::string& line) {
  std::vector<double> numbers;
  for (const std::string& value : ask(line)) {
    const auto number = parse_number(value);
    if (!number || *number < -kEnd || *number >= kEnd) {
      nonsense("no number of a Galil is the answer to " + line, value);
    }
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace trammel::device
