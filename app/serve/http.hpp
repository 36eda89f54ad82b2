#pragma once
// HTTP for browsers of this machine: GET on 127.0.0.1, and nothing more.

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace trammel::serve {

struct Reply {
  int status = 404;
  const char* type = "text/plain";
  std::string body = {};
};

/// Answers from a thread of its own, from construction until it is stopped, one request a
/// connection. Who asks by another name than 127.0.0.1 or localhost (DNS rebinding) gets 404, who
/// does anything but GET 501, and who sends more than 16 KiB of headers, or is slower than
/// `patience`, is cut off; so is, of more than `most_waiting` who have not asked yet, the one that
/// came first. Bodies are not read. No answer is kept by the browser, shown in a frame
/// or handed to a page of another site.
///
/// Over libevent, not cpp-httplib: Debian's is linked with OpenSSL, brotli and zlib, and sets up
/// OpenSSL whenever the program starts: 7.6 ms of each `trammel --version`, of 17.
///
/// Proof: server_test.cpp.
class HttpServer {
 public:
  /// Runs in the server's thread: the path of the address, without what stands behind '?'. What it
  /// throws is a 503: the browser asks again.
  using Answer = std::function<Reply(std::string_view path)>;

  /// Port 0: any that is free. Throws Error (exit 7) where the port is taken.
  HttpServer(int port, std::chrono::milliseconds patience, std::size_t most_waiting, Answer answer);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] int port() const;
  /// Ends the answering and closes what is open; from any thread.
  void stop();

 private:
  struct Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace trammel::serve
