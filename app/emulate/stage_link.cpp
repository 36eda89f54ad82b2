#include "app/emulate/stage_link.hpp"

#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <memory>
#include <sstream>
#include <vector>

#include "app/files/numbers.hpp"
#include "core/error.hpp"

namespace trammel::emulate {

namespace {

constexpr int kPatience_s = 5;

[[noreturn]] void no_stage(const std::string& host_port, const std::string& got) {
  throw DeviceError({.what = "the emulated stage at " + host_port + " does not say where it stands",
                     .got = got,
                     .hint = "start `trammel emulate galil` first and give its port"});
}

class Socket {
 public:
  Socket(const std::string& host, const std::string& port) {
    const addrinfo wanted{.ai_flags = 0,
                          .ai_family = AF_INET,
                          .ai_socktype = SOCK_STREAM,
                          .ai_protocol = 0,
                          .ai_addrlen = 0,
                          .ai_addr = nullptr,
                          .ai_canonname = nullptr,
                          .ai_next = nullptr};
    addrinfo* found = nullptr;
    if (::getaddrinfo(host.c_str(), port.c_str(), &wanted, &found) != 0) return;
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const timeval patience{.tv_sec = kPatience_s, .tv_usec = 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    connected_ = ::connect(socket_, found->ai_addr, found->ai_addrlen) == 0;
  }
  ~Socket() {
    if (socket_ >= 0) ::close(socket_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  /// What is answered up to `end`; empty when it is not.
  [[nodiscard]] std::string ask(std::string_view question, char end) const {
    if (!connected_ || ::send(socket_, question.data(), question.size(), MSG_NOSIGNAL) < 0) {
      return "";
    }
    std::string answer;
    for (char c = 0; answer.size() < 1000 && ::recv(socket_, &c, 1, 0) == 1;) {
      if (c == end) return answer;
      answer += c;
    }
    return "";
  }

 private:
  int socket_ = -1;
  bool connected_ = false;
};

}  // namespace

std::string standing_text(const Standing& s) {
  std::string text;
  for (const double value : {s.l_mm[0], s.l_mm[1], s.l_mm[2], s.from_mm[0], s.from_mm[1],
                             s.from_mm[2], static_cast<double>(s.epoch), s.time_s}) {
    text += number_text(value) + " ";
  }
  return text + (s.moving ? "1" : "0");
}

Standing parse_standing(std::string_view text) {
  std::istringstream words{std::string(text)};
  std::vector<double> values;
  for (std::string word; words >> word;) {
    if (const auto value = parse_number(word)) values.push_back(*value);
  }
  // 6: the epoch, 7: the time of work, thirty years at most
  const bool sound =
      values.size() == 9 && values[6] >= 1 && values[6] < 1e6 && values[7] >= 0 && values[7] < 1e9;
  if (!sound) {
    throw DeviceError({.what = "no standing of an emulated stage",
                       .got = std::string(text),
                       .expected = "nine numbers"});
  }
  return {.l_mm = {values[0], values[1], values[2]},
          .from_mm = {values[3], values[4], values[5]},
          .epoch = static_cast<int>(values[6]),
          .time_s = values[7],
          .moving = values[8] != 0};
}

Standing ask_standing(const std::string& host_port) {
  const std::size_t colon = host_port.rfind(':');
  if (colon == std::string::npos || !parse_integer(host_port.substr(colon + 1))) {
    throw UsageError({.what = "no address of an emulated stage",
                      .where = {.field = "--stage"},
                      .got = host_port,
                      .expected = "HOST:PORT"});
  }
  const Socket socket(host_port.substr(0, colon), host_port.substr(colon + 1));
  const std::string answer = socket.ask(std::string(kAskStanding) + "\r", ':');
  if (answer.empty()) no_stage(host_port, "no answer");
  return parse_standing(answer);
}

}  // namespace trammel::emulate
