#include "app/device/t2sa_wire.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <thread>
#include <vector>

#include "app/device/freshness.hpp"
#include "app/files/numbers.hpp"
#include "core/units.hpp"

namespace trammel::device {

namespace {

constexpr std::size_t kMaxLineBytes = 4096;
constexpr double kBusyPauseS = 0.05;

struct T2saCode {
  int code;
  Status status;
};
// ERR codes [S]; what each means for the runner is ours: what a person must put right is a fault.
constexpr std::array<T2saCode, 5> kT2saCodes = {{
    {201, Status::timeout},      // busy, and stayed so
    {304, Status::unstable},     // drift tolerance
    {305, Status::beam_broken},  // measurement of a point failed
    {338, Status::beam_broken},  // instrument not ready
    {340, Status::beam_broken},  // measurement of a point group failed
}};

std::vector<std::string_view> split_at(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t at = text.find(separator);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

std::string_view without_blanks(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

/// Three numbers; nothing when one is none.
std::optional<Eigen::Vector3d> three_numbers(const std::vector<std::string_view>& parts) {
  if (parts.size() != 3) return std::nullopt;
  Eigen::Vector3d values;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = parse_number(without_blanks(parts[k]));
    if (!value) return std::nullopt;
    values[static_cast<int>(k)] = *value;
  }
  return values;
}

}  // namespace

std::optional<T2saReply> parse_t2sa_reply(const std::string& line) {
  constexpr std::size_t kHead = 7;  // "ACK-300"
  const bool accepted = line.starts_with("ACK-");
  if (line.size() < kHead || (!accepted && !line.starts_with("ERR-"))) return std::nullopt;
  const std::string_view digits = std::string_view(line).substr(4, 3);
  if (digits.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
  if (line.size() > kHead && line[kHead] != ' ') return std::nullopt;
  return T2saReply{accepted, *parse_integer(digits),
                   std::string(without_blanks(std::string_view(line).substr(kHead))), line};
}

std::optional<T2saPoint> parse_t2sa_point(const std::string& body) {
  constexpr std::string_view kHead = "Single Point Measurement ", kResult = " result ";
  const std::size_t at = body.find(kResult);
  if (!body.starts_with(kHead) || at == std::string::npos || at < kHead.size()) return {};
  // x,y,z may have blanks after the commas; the time and the word are the last three.
  std::string_view rest = std::string_view(body).substr(at + kResult.size());
  std::array<std::string_view, 3> tail;
  for (auto word = tail.rbegin(); word != tail.rend(); ++word) {
    const std::size_t blank = rest.rfind(' ');
    if (blank == std::string_view::npos) return {};
    *word = rest.substr(blank + 1);
    rest = without_blanks(rest.substr(0, blank));
  }
  const auto at_mm = three_numbers(split_at(rest, ','));
  if (!at_mm || (tail[2] != "True" && tail[2] != "False")) return {};
  const std::string_view name = std::string_view(body).substr(kHead.size(), at - kHead.size());
  return T2saPoint{*at_mm, tail[2] == "True", std::string(without_blanks(name)),
                   parse_stamp_s(std::string(tail[0]) + " " + std::string(tail[1]))};
}

bool t2sa_name_is(std::string_view name, std::string_view expected) {
  return std::ranges::equal(name, expected, [](unsigned char a, unsigned char b) {
    return std::tolower(a) == std::tolower(b);
  });
}

bool t2sa_name_holds(std::string_view name, std::string_view part) {
  for (std::size_t at = 0; at + part.size() <= name.size(); ++at) {
    if (t2sa_name_is(name.substr(at, part.size()), part)) return true;
  }
  return false;
}

std::optional<T2saFrame> parse_t2sa_offset(const std::string& body) {
  constexpr std::string_view kHead = "Object Offset Report ";
  if (!body.starts_with(kHead)) return {};
  const auto parts = split_at(body, ';');
  constexpr std::array<std::string_view, 6> kNames = {"X:", "Y:", "Z:", "Rx:", "Ry:", "Rz:"};
  if (parts.size() < 1 + kNames.size()) return {};
  std::vector<std::string_view> values;
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const std::string_view part = without_blanks(parts[k + 1]);
    if (!part.starts_with(kNames[k])) return {};
    values.push_back(part.substr(kNames[k].size()));
  }
  const auto shift_mm = three_numbers({values.begin(), values.begin() + 3});
  const auto angles_deg = three_numbers({values.begin() + 3, values.end()});
  if (!shift_mm || !angles_deg) return {};
  return T2saFrame{fixed_axes(*shift_mm, *angles_deg * rad_from_deg(1)),
                   std::string(parts[0].substr(kHead.size())),
                   parts.size() > 7 ? parse_stamp_s(without_blanks(parts[7])) : std::nullopt};
}

Eigen::Isometry3d fixed_axes(const Eigen::Vector3d& shift_mm, const Eigen::Vector3d& angles_rad) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = shift_mm;
  T.linear() = (Eigen::AngleAxisd(angles_rad[2], Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(angles_rad[1], Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(angles_rad[0], Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return T;
}

Status status_of_t2sa(int code) {
  for (const T2saCode& known : kT2saCodes) {
    if (known.code == code) return known.status;
  }
  return Status::fault;
}

T2saWire::T2saWire(const Endpoint& to, double connect_timeout_s, double reply_timeout_s)
    : link_(to, in_s(connect_timeout_s)), reply_timeout_s_(reply_timeout_s) {}

std::string T2saWire::receive_line(const std::string& asked, Deadline deadline) {
  for (;;) {
    const std::size_t end = buffer_.find('\n');
    if (end != std::string::npos) {
      std::string line = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      if (line.ends_with('\r')) line.pop_back();
      return line;
    }
    try {
      buffer_ += link_.receive(deadline);
    } catch (const LinkError& error) {
      ErrorText text = error.text();
      text.where.field = asked;
      if (!buffer_.empty()) text.what += ", only half of one";
      throw LinkError(error.kind, text);
    }
    if (buffer_.size() > kMaxLineBytes) {
      link_.close();
      throw LinkError(
          LinkError::Kind::nonsense,
          {.what = "a line without end", .where = {.field = asked}, .got = buffer_.substr(0, 60)});
    }
  }
}

void T2saWire::out_of_step(const std::string& line, const std::string& got,
                           const std::string& expected) {
  link_.close();
  throw LinkError(LinkError::Kind::out_of_step, {.what = "an answer that nobody asked for",
                                                 .where = {.field = line},
                                                 .got = got,
                                                 .expected = expected});
}

T2saReply T2saWire::ask(const std::string& line, bool patient) {
  const Deadline deadline = in_s(reply_timeout_s_);
  for (;;) {
    buffer_ += link_.pending();
    if (!buffer_.empty()) out_of_step(line, buffer_.substr(0, 60), "nothing before it is asked");
    link_.send(line + "\r\n", deadline);
    const std::string got = receive_line(line, deadline);
    const auto reply = parse_t2sa_reply(got);
    if (!reply) {
      link_.close();
      throw LinkError(LinkError::Kind::nonsense, {.what = "an answer of no known form",
                                                  .where = {.field = line},
                                                  .got = got.substr(0, 60),
                                                  .expected = "ACK-nnn or ERR-nnn"});
    }
    const auto next_try = in_s(kBusyPauseS);
    const bool busy = !reply->accepted && reply->code == kT2saBusy;
    if (!busy || !patient || next_try >= deadline) return *reply;
    std::this_thread::sleep_until(next_try);
  }
}

}  // namespace trammel::device
