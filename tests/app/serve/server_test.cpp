#include "app/serve/server.hpp"

#include <httplib.h>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;

namespace {

/// A campaign of a few points, measured on the virtual robot.
class Laboratory {
 public:
  Laboratory() {
    const std::string robot = tests::source_folder() + "/examples/paper/robot.json";
    run({"plan", "create", "lattice", "--step", "100", "--out", "plan.json"});
    run({"session", "run", "lab", "--plan", "plan.json", "--stage", "sim:" + robot});
  }
  [[nodiscard]] std::filesystem::path database() const { return folder_.path() / "trammel.db"; }

 private:
  void run(const std::vector<std::string>& words) const {
    const tests::Finished finished = tests::run_program(words, folder_.path());
    CAPTURE(words, finished.err);
    REQUIRE(finished.exit_code == 0);
  }
  tests::TemporaryFolder folder_;
};

const Laboratory& laboratory() {
  static const Laboratory made;
  return made;
}

serve::Options options() { return {.database = laboratory().database(), .campaign = "lab"}; }

/// "http://127.0.0.1:PORT/TOKEN/" in its two parts.
struct Address {
  explicit Address(const std::string& url) {
    const std::size_t slash = url.find('/', std::string("http://").size());
    host = url.substr(0, slash);
    path = url.substr(slash);
  }
  std::string host, path;
};

}  // namespace

TEST_CASE("the live page, its status and its data are answered under the token", "[serve]") {
  const serve::Server server(options());
  const Address at(server.url());
  CHECK(at.host.starts_with("http://127.0.0.1:"));
  CHECK(at.path.size() == 2 + 32);
  httplib::Client client(at.host);

  const auto page = client.Get(at.path);
  REQUIRE(page);
  CHECK(page->status == 200);
  CHECK_THAT(page->body, Contains("connect-src 'self'") && Contains("SIMULATED"));
  CHECK(page->get_header_value("Cache-Control") == "no-store");
  CHECK(page->get_header_value("Referrer-Policy") == "no-referrer");

  const auto status = client.Get(at.path + "status.json");
  REQUIRE(status);
  const auto now = nlohmann::json::parse(status->body);
  CHECK(now.at("state") == "done");
  CHECK(now.at("n_ok") == now.at("n_points"));
  CHECK(now.at("simulated") == true);
  CHECK(now.at("last").size() > 1);

  const auto data = client.Get(at.path + "page.json");
  REQUIRE(data);
  CHECK(tests::schema_errors(nlohmann::json::parse(data->body), "report-page.schema.json") == "");
}

TEST_CASE("without the token, from a foreign name or to change something: nothing", "[serve]") {
  const serve::Server server(options());
  const Address at(server.url());
  httplib::Client client(at.host);
  std::string wrong = at.path;
  wrong[5] = wrong[5] == '0' ? '1' : '0';
  for (const std::string& path :
       {std::string("/"), std::string("/status.json"), wrong, wrong + "status.json",
        at.path + "../trammel.db", at.path + "trammel.db", std::string("//")}) {
    CAPTURE(path);
    const auto answer = client.Get(path);
    REQUIRE(answer);
    CHECK(answer->status == 404);
    CHECK(answer->body.find("trammel") == std::string::npos);
  }
  const auto rebound = client.Get(at.path, {{"Host", "evil.example"}});
  REQUIRE(rebound);
  CHECK(rebound->status == 404);
  for (const auto& answer : {client.Post(at.path + "status.json"),
                             client.Put(at.path, "x", "text/plain"), client.Delete(at.path)}) {
    REQUIRE(answer);
    CHECK(answer->status >= 400);
  }
}

TEST_CASE("each server has a token of its own, and a port that is taken is said", "[serve]") {
  const serve::Server one(options());
  const serve::Server two(options());
  CHECK(Address(one.url()).path != Address(two.url()).path);
  serve::Options taken = options();
  taken.port = std::stoi(Address(one.url()).host.substr(std::string("http://127.0.0.1:").size()));
  CHECK_THROWS_AS(serve::Server(taken), Error);
  serve::Options nobody = options();
  nobody.campaign = "nobody";
  CHECK_THROWS_AS(serve::Server(nobody), NotFoundError);
}
