#include "app/serve/http.hpp"

#include <event2/buffer.h>
#include <event2/bufferevent.h>
#include <event2/event.h>
#include <event2/http.h>
#include <event2/listener.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <deque>
#include <thread>
#include <utility>

#include "core/error.hpp"

namespace trammel::serve {

namespace {

constexpr ev_ssize_t kMaxHeaders_bytes = 16 << 10;

constexpr std::array<std::pair<const char*, const char*>, 6> kHeaders = {{
    {"Cache-Control", "no-store"},
    {"Referrer-Policy", "no-referrer"},
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Connection", "close"},  // so that what follows a request is never taken for another
}};

evconnlistener* listen_on(event_base* base, int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return evconnlistener_new_bind(
      base, nullptr, nullptr, LEV_OPT_REUSEABLE | LEV_OPT_CLOSE_ON_FREE | LEV_OPT_CLOSE_ON_EXEC,
      SOMAXCONN, reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

int port_of(evconnlistener* listener) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  ::getsockname(evconnlistener_get_fd(listener), reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

/// A client that has gone away is no reason to end.
void block_broken_pipes() {
  sigset_t pipe;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
}

void send(evhttp_request* request, const Reply& reply) {
  evkeyvalq* headers = evhttp_request_get_output_headers(request);
  for (const auto& [name, value] : kHeaders) evhttp_add_header(headers, name, value);
  evhttp_add_header(headers, "Content-Type", reply.type);
  evbuffer* body = evhttp_request_get_output_buffer(request);
  evbuffer_add(body, reply.body.data(), reply.body.size());
  evhttp_send_reply(request, reply.status, nullptr, nullptr);
}

}  // namespace

/// Connections whose request has not come whole, oldest first. One too many, and the oldest is read
/// for the last time: a request that lies there is answered still, half a one ends. So none who
/// asks waits for those who do not, whatever handles this process may have.
class Waiting {
 public:
  explicit Waiting(std::size_t most) : most_(most) {}
  ~Waiting() {
    for (bufferevent* each : waiting_) bufferevent_decref(each);
  }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;

  /// Held too, so that its socket's number is not another's until it is left.
  bufferevent* enter(event_base* base) {
    bufferevent* made = bufferevent_socket_new(base, -1, BEV_OPT_CLOSE_ON_FREE);
    if (made == nullptr) return nullptr;
    bufferevent_incref(made);
    waiting_.push_back(made);
    if (waiting_.size() > most_) {
      ::shutdown(bufferevent_getfd(waiting_.front()), SHUT_RD);
      leave(waiting_.front());
    }
    return made;
  }
  void leave(bufferevent* connection) {
    const auto found = std::ranges::find(waiting_, connection);
    if (found == waiting_.end()) return;
    waiting_.erase(found);
    bufferevent_decref(connection);
  }

 private:
  std::size_t most_;
  std::deque<bufferevent*> waiting_;
};

/// All but the constructor and stop() in one thread: libevent's locks are not needed.
struct HttpServer::Loop {
  Loop(int wanted_port, std::chrono::milliseconds patience, std::size_t most_waiting, Answer asked)
      : answer(std::move(asked)), wake(::eventfd(0, EFD_CLOEXEC)), waiting(most_waiting) {
    evconnlistener* listener = listen_on(base.get(), wanted_port);
    if (listener == nullptr) {
      ::close(wake);
      throw Error(ExitCode::device, {.what = "the port is taken or may not be used",
                                     .where = {.field = "--port"},
                                     .got = std::to_string(wanted_port),
                                     .expected = "one that is free; 0 finds one"});
    }
    port = port_of(listener);
    evconnlistener_set_error_cb(listener, [](evconnlistener*, void*) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));  // until handles are free again
    });
    http.reset(evhttp_new(base.get()));
    evhttp_bind_listener(http.get(), listener);
    evhttp_set_allowed_methods(http.get(), EVHTTP_REQ_GET);
    evhttp_set_max_headers_size(http.get(), kMaxHeaders_bytes);
    evhttp_set_max_body_size(http.get(), 0);
    const timeval limit = {patience.count() / 1000, patience.count() % 1000 * 1000};
    evhttp_set_timeout_tv(http.get(), &limit);
    evhttp_set_bevcb(http.get(), on_connection, this);
    evhttp_set_gencb(http.get(), on_request, this);
    woken.reset(event_new(base.get(), wake, EV_READ, on_wake, base.get()));
    event_add(woken.get(), nullptr);
    thread = std::thread([this] {
      block_broken_pipes();
      event_base_dispatch(base.get());
      http.reset();
    });
  }
  ~Loop() {
    thread.join();
    woken.reset();
    ::close(wake);
  }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  static void on_wake(evutil_socket_t, short, void* base) {
    event_base_loopbreak(static_cast<event_base*>(base));
  }

  static bufferevent* on_connection(event_base* base, void* self) {
    return static_cast<Loop*>(self)->waiting.enter(base);
  }

  static void on_request(evhttp_request* request, void* self) {
    static_cast<Loop*>(self)->waiting.leave(
        evhttp_connection_get_bufferevent(evhttp_request_get_connection(request)));
    Reply reply;
    try {
      reply = static_cast<const Loop*>(self)->reply_to(*request);
    } catch (const std::exception&) {
      reply.status = HTTP_SERVUNAVAIL;
    }
    send(request, reply);
  }

  [[nodiscard]] Reply reply_to(evhttp_request& request) const {
    const char* host = evhttp_find_header(evhttp_request_get_input_headers(&request), "Host");
    const bool ours = host != nullptr && (host == fmt::format("127.0.0.1:{}", port) ||
                                          host == fmt::format("localhost:{}", port));
    const char* path = evhttp_uri_get_path(evhttp_request_get_evhttp_uri(&request));
    return ours && path != nullptr ? answer(path) : Reply{};
  }

  Answer answer;
  int wake;
  int port = 0;
  std::unique_ptr<event_base, decltype(&event_base_free)> base{event_base_new(), event_base_free};
  Waiting waiting;
  std::unique_ptr<event, decltype(&event_free)> woken{nullptr, event_free};
  std::unique_ptr<evhttp, decltype(&evhttp_free)> http{nullptr, evhttp_free};
  std::thread thread;
};

HttpServer::HttpServer(int port, std::chrono::milliseconds patience, std::size_t most_waiting,
                       Answer answer)
    : loop_(std::make_unique<Loop>(port, patience, most_waiting, std::move(answer))) {}

HttpServer::~HttpServer() { stop(); }

int HttpServer::port() const { return loop_->port; }

void HttpServer::stop() {
  const std::uint64_t one = 1;
  while (::write(loop_->wake, &one, sizeof one) < 0 && errno == EINTR) {
  }
}

}  // namespace trammel::serve
