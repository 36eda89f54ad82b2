#include "app/serve/server.hpp"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "app/report/page/page.hpp"
#include "app/serve/http.hpp"
#include "app/session/lock.hpp"
#include "app/session/status.hpp"
#include "core/error.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"

namespace trammel::serve {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kTokenBytes = 16;

std::string random_token() {
  if (sodium_init() < 0) throw Error(ExitCode::error, {.what = "no random numbers to be had"});
  std::array<unsigned char, kTokenBytes> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  return store::hex(bytes);
}

/// In a time that does not tell how much of it is right.
bool same(std::string_view a, std::string_view b) {
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
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  return report::page_json(db, campaign, report::gather(db, campaign));
}

std::string text_of(const Json& json) {
  return report::printable_texts(json).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string live_page(const Options& options) {
  Json page = page_now(options);
  page["live"] = {{"status", "status.json"}, {"page", "page.json"}};
  return report::page_html(page);
}

/// What stands under the token.
struct Page {
  const char* name;
  const char* type;
  std::string (*now)(const Options&);
};
constexpr std::array<Page, 3> kPages = {{
    {"", "text/html; charset=utf-8", live_page},
    {"status.json", "application/json",
     [](const Options& options) { return text_of(status_now(options)); }},
    {"page.json", "application/json",
     [](const Options& options) { return text_of(page_now(options)); }},
}};

Reply reply_to(std::string_view path, const std::string& root, const Options& options) {
  if (path.size() < root.size() || !same(path.substr(0, root.size()), root)) return {};
  const auto* page = std::find_if(kPages.begin(), kPages.end(), [&](const Page& each) {
    return each.name == path.substr(root.size());
  });
  if (page == kPages.end()) return {};
  return {.status = 200, .type = page->type, .body = page->now(options)};
}

}  // namespace

struct Server::Inside {
  explicit Inside(Options given)
      : options(std::move(given)),
        http(options.port, options.patience, options.most_waiting,
             [this](auto path) { return reply_to(path, root, options); }) {}

  Options options;
  std::string root = "/" + random_token() + "/";
  HttpServer http;
};

Server::Server(Options options) {
  static_cast<void>(status_now(options));  // what is not there is said now, not in a browser
  inside_ = std::make_unique<Inside>(std::move(options));
}

Server::~Server() = default;

std::string Server::url() const {
  return fmt::format("http://127.0.0.1:{}{}", inside_->http.port(), inside_->root);
}

void Server::stop() { inside_->http.stop(); }

}  // namespace trammel::serve
