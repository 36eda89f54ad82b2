#include "tests/support/scripted_server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>

namespace trammel::tests {

ScriptedServer::ScriptedServer(std::string end) : end_(std::move(end)) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* any = reinterpret_cast<sockaddr*>(&address);
  if (::bind(listener_, any, size) != 0 || ::listen(listener_, 4) != 0 ||
      ::getsockname(listener_, any, &size) != 0 || ::pipe2(wake_, O_CLOEXEC) != 0) {
    throw std::runtime_error("no socket on the loopback");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { serve(); });
}

ScriptedServer::~ScriptedServer() {
  vanish();
  ::close(wake_[0]);
}

void ScriptedServer::vanish() {
  if (!thread_.joinable()) return;
  ::close(wake_[1]);  // wakes every poll
  thread_.join();
  for (std::thread& talk : talks_) talk.join();
  ::close(listener_);
}

void ScriptedServer::on(const std::string& line, std::vector<Answer> answers) {
  const std::scoped_lock lock(mutex_);
  answers_[line] = {answers.begin(), answers.end()};
}

void ScriptedServer::forget(const std::string& line) {
  const std::scoped_lock lock(mutex_);
  answers_.erase(line);
}

void ScriptedServer::otherwise(std::function<std::string(const std::string&)> answer) {
  const std::scoped_lock lock(mutex_);
  otherwise_ = std::move(answer);
}

std::vector<std::string> ScriptedServer::lines() const {
  const std::scoped_lock lock(mutex_);
  return lines_;
}

int ScriptedServer::count(const std::string& line) const {
  const std::scoped_lock lock(mutex_);
  return static_cast<int>(std::count(lines_.begin(), lines_.end(), line));
}

Answer ScriptedServer::answer_to(const std::string& line) {
  std::unique_lock lock(mutex_);
  lines_.push_back(line);
  Answer answer = kUsual;
  const auto found = answers_.find(line);
  if (found != answers_.end()) {
    answer = found->second.front();
    if (found->second.size() > 1) found->second.pop_front();
  }
  const auto otherwise = otherwise_;
  lock.unlock();
  if (answer.usual) answer.bytes = otherwise ? otherwise(line) : "";
  return answer;
}

void ScriptedServer::await_none() const {
  while (open_ > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void ScriptedServer::serve() {
  for (;;) {
    std::array<pollfd, 2> wait{{{listener_, POLLIN, 0}, {wake_[0], POLLIN, 0}}};
    if (::poll(wait.data(), wait.size(), -1) <= 0) continue;
    if (wait[1].revents != 0) return;
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket < 0) continue;
    ++connections_;
    ++open_;
    talks_.emplace_back([this, socket] {
      talk(socket);
      ::close(socket);
      --open_;
    });
  }
}

void ScriptedServer::talk(int socket) {
  std::string text;
  std::array<char, 1024> buffer;
  for (;;) {
    std::array<pollfd, 2> wait{{{socket, POLLIN, 0}, {wake_[0], POLLIN, 0}}};
    if (::poll(wait.data(), wait.size(), -1) <= 0) continue;
    if (wait[1].revents != 0) return;
    const ssize_t got = ::recv(socket, buffer.data(), buffer.size(), 0);
    if (got <= 0) return;
    text.append(buffer.data(), static_cast<std::size_t>(got));
    for (std::size_t at = text.find(end_); at != std::string::npos; at = text.find(end_)) {
      const Answer answer = answer_to(text.substr(0, at));
      text.erase(0, at + end_.size());
      if (answer.delay_s > 0) {
        std::this_thread::sleep_for(std::chrono::duration<double>(answer.delay_s));
      }
      const auto& bytes = answer.bytes;
      if (::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0 || answer.close) return;
    }
  }
}

}  // namespace trammel::tests
