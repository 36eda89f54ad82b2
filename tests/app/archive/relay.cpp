#include "tests/app/archive/relay.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>

namespace trammel::tests {

namespace {

sockaddr_un address_of(const std::filesystem::path& folder, int port) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = (folder / (".s.PGSQL." + std::to_string(port))).string();
  if (path.size() >= sizeof address.sun_path) throw std::runtime_error("a socket's name too long");
  std::memcpy(address.sun_path, path.c_str(), path.size());
  return address;
}

bool send_all(int to, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(to, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

/// Bytes of the first message in `bytes`, once it is whole; 0 before. The very first has no kind.
std::size_t message_size(std::string_view bytes, bool first) {
  const std::size_t head = first ? 0 : 1;
  if (bytes.size() < head + 4) return 0;
  std::size_t size = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    size = size << 8U | static_cast<unsigned char>(bytes[head + k]);
  }
  return bytes.size() >= head + size ? head + size : 0;
}

constexpr std::string_view kCommitted{
    "C\0\0\0\x0b"
    "COMMIT\0Z\0\0\0\x05I",
    18};

}  // namespace

Relay::Relay(std::filesystem::path server_folder, int port, Cut cut)
    : server_folder_(std::move(server_folder)), port_(port), cut_(std::move(cut)) {
  listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_un address = address_of(folder_.path(), port_);
  if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener_, 8) != 0) {
    throw std::runtime_error("no socket for the relay");
  }
  thread_ = std::thread([this] { serve(); });
}

Relay::~Relay() {
  ended_ = true;
  thread_.join();
  ::close(listener_);
}

std::string Relay::uri(const std::string& database, const std::string& role) const {
  return "postgresql://" + role + "@/" + database + "?host=" + folder_.path().string() +
         "&port=" + std::to_string(port_);
}

void Relay::serve() {
  while (!ended_) {
    pollfd waiting{listener_, POLLIN, 0};
    if (::poll(&waiting, 1, 20) <= 0) continue;
    const int client = ::accept(listener_, nullptr, nullptr);
    const int server = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_un address = address_of(server_folder_, port_);
    if (::connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
      talk(client, server);
    }
    ::close(client);
    ::close(server);
  }
}

void Relay::talk(int client, int server) {
  std::array<char, 65536> buffer{};
  std::string pending;  // of the client, not yet a whole message
  bool first = true;
  long n_answered = 0;
  const auto cut_at = [this](Cut::What what, long reached) {
    if (cut_.what != what || reached < cut_.after) return false;
    has_cut_ = true;
    return true;
  };
  while (!ended_) {
    std::array<pollfd, 2> both = {{{client, POLLIN, 0}, {server, POLLIN, 0}}};
    if (::poll(both.data(), both.size(), 20) <= 0) continue;
    if (both[1].revents != 0) {
      const ssize_t n = ::recv(server, buffer.data(), buffer.size(), 0);
      if (n <= 0) return;
      long pass = static_cast<long>(n);
      constexpr std::string_view kName{"server_version\0", 15};
      const auto named =
          std::search(buffer.begin(), buffer.begin() + n, kName.begin(), kName.end());
      if (!cut_.version.empty() && named + 17 < buffer.begin() + n) {
        std::copy_n(cut_.version.begin(), 2, named + 15);
      }
      if (cut_.what == Cut::What::server_bytes) pass = std::min(pass, cut_.after - n_answered);
      if (!send_all(client, {buffer.data(), static_cast<std::size_t>(pass)})) return;
      n_answered += pass;
      if (cut_at(Cut::What::server_bytes, n_answered)) return;
    }
    if (both[0].revents == 0) continue;
    const ssize_t n = ::recv(client, buffer.data(), buffer.size(), 0);
    if (n <= 0) return;
    pending.append(buffer.data(), static_cast<std::size_t>(n));
    if (cut_.what == Cut::What::client_bytes &&
        n_bytes_ + static_cast<long>(pending.size()) >= cut_.after) {
      send_all(server, std::string_view(pending).substr(
                           0, static_cast<std::size_t>(cut_.after - n_bytes_)));
      has_cut_ = true;
      return;
    }
    while (const std::size_t size = message_size(pending, first)) {
      if (cut_at(Cut::What::client_messages, n_messages_)) return;
      const std::string message = pending.substr(0, size);
      pending.erase(0, size);
      first = false;
      ++n_messages_;
      n_bytes_ += static_cast<long>(size);
      if (cut_.lie_of_commit && message.find("COMMIT") == 5) {
        has_cut_ = true;
        send_all(client, kCommitted);
        ::usleep(50000);  // the client reads it before the connection ends
        return;
      }
      if (!send_all(server, message)) return;
    }
  }
}

}  // namespace trammel::tests
