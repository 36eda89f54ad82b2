#include "app/serve/server.hpp"

#include <fmt/format.h>
#include <httplib.h>
#include <sodium.h>

#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/report/page/page.hpp"
#include "app/session/lock.hpp"
#include "app/session/status.hpp"
#include "core/error.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"

namespace trammel::serve {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kLoopback = "127.0.0.1";
constexpr std::size_t kTokenBytes = 16;
constexpr int kPatience_s = 5;  // for a client that is slow to ask

std::string random_token() {
  if (sodium_init() < 0) throw Error(ExitCode::error, {.what = "no random numbers to be had"});
  std::array<unsigned char, kTokenBytes> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  return store::hex(bytes);
}

/// In a time that does not tell how much of it is right.
bool same(const std::string& a, const std::string& b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

Json status_now(const Options& options) {
  store::Connection db = store::open(options.database, store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  const auto current = session::current_session(db, campaign);
  const std::string name = options.session.empty() ? current.value_or("") : options.session;
  if (name.empty()) {
    throw NotFoundError(
        {.what = "the campaign has no session to watch",
         .where = {.field = "campaign"},
         .got = campaign.name,
         .hint = "its report is a page too: `trammel report CAMPAIGN --html FILE`"});
  }
  const auto process = session::CampaignLock::holder(db.file(), campaign.uuid);
  return session::status_json(session::status_of(db, campaign, name, process));
}

Json page_now(const Options& options) {
  store::Connection db = store::open(options.database, store::Access::read_only);
  return report::page_json(db, store::require_campaign(db, options.campaign));
}

void answer(httplib::Response& response, const std::string& text, const char* type) {
  response.set_header("Cache-Control", "no-store");
  response.set_header("Referrer-Policy", "no-referrer");
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("X-Frame-Options", "DENY");
  response.set_header("Cross-Origin-Resource-Policy", "same-origin");
  response.set_content(text, type);
}

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

struct Server::Inside {
  explicit Inside(Options given) : options(std::move(given)), token(random_token()) {}

  /// A name that leads here from outside (DNS rebinding) is not ours.
  [[nodiscard]] bool allowed(const httplib::Request& request) const {
    const std::string host = request.get_header_value("Host");
    return host == fmt::format("{}:{}", kLoopback, port) ||
           host == fmt::format("localhost:{}", port);
  }

  void route(const std::string& file, const std::function<void(httplib::Response&)>& reply) {
    http.Get("/([0-9a-f]*)/" + file,
             [this, reply](const httplib::Request& request, httplib::Response& response) {
               if (!allowed(request) || !same(request.matches[1].str(), token)) {
                 response.status = 404;
                 return;
               }
               reply(response);
             });
  }

  Options options;
  std::string token;
  int port = 0;
  httplib::Server http;
  std::thread thread;
};

Server::Server(Options options) : inside_(std::make_unique<Inside>(std::move(options))) {
  Inside& in = *inside_;
  static_cast<void>(status_now(in.options));  // what is not there is said now, not in a browser
  in.route("", [&in](httplib::Response& response) {
    Json page = page_now(in.options);
    page["live"] = {{"status", "status.json"}, {"page", "page.json"}};
    answer(response, report::page_html(page), "text/html; charset=utf-8");
  });
  in.route("status\\.json", [&in](httplib::Response& response) {
    answer(response, text_of(status_now(in.options)), "application/json");
  });
  in.route("page\\.json", [&in](httplib::Response& response) {
    answer(response, text_of(page_now(in.options)), "application/json");
  });
  in.http.set_exception_handler(
      [](const httplib::Request&, httplib::Response& response, std::exception_ptr) {
        response.status = 503;  // a database that is being replaced: the page asks again
      });
  in.http.new_task_queue = [] { return new httplib::ThreadPool(4); };
  in.http.set_socket_options([](socket_t socket) {  // the library would share a taken port
    const int on = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  });
  in.http.set_payload_max_length(0);
  in.http.set_read_timeout(kPatience_s);
  in.http.set_write_timeout(kPatience_s);
  if (in.options.port == 0) {
    in.port = in.http.bind_to_any_port(kLoopback);
  } else if (in.http.bind_to_port(kLoopback, in.options.port)) {
    in.port = in.options.port;
  }
  if (in.port <= 0) {
    throw Error(ExitCode::device, {.what = "the port is taken or may not be used",
                                   .where = {.field = "--port"},
                                   .got = std::to_string(in.options.port),
                                   .expected = "one that is free; 0 finds one"});
  }
  in.thread = std::thread([&in] { in.http.listen_after_bind(); });
  while (!in.http.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

Server::~Server() {
  stop();
  if (inside_->thread.joinable()) inside_->thread.join();
}

std::string Server::url() const {
  return fmt::format("http://{}:{}/{}/", kLoopback, inside_->port, inside_->token);
}

void Server::stop() { inside_->http.stop(); }

}  // namespace trammel::serve
