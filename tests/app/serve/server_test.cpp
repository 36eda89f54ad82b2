#include "app/serve/server.hpp"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "app/device/tcp.hpp"
#include "core/error.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"
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

struct Answer {
  int status = 0;  // 0: the connection ended without one
  std::map<std::string, std::string> headers = {};
  std::string body = {};
};

Answer parsed(const std::string& bytes) {
  const std::size_t end = bytes.find("\r\n\r\n");
  if (end == std::string::npos) return {};
  Answer answer;
  std::istringstream head(bytes.substr(0, end));
  std::string line;
  std::getline(head, line);
  answer.status = std::stoi(line.substr(std::string("HTTP/1.1 ").size()));
  while (std::getline(head, line)) {
    const std::size_t colon = line.find(": ");
    line.erase(std::min(line.find('\r'), line.size()));
    answer.headers[line.substr(0, colon)] = line.substr(colon + 2);
  }
  answer.body = bytes.substr(end + 4);
  return answer;
}

/// A server's address, "http://127.0.0.1:PORT/TOKEN/", and who asks there.
struct Client {
  explicit Client(const serve::Server& server) : Client(server.url()) {}
  explicit Client(const std::string& url) {
    const std::string before = "http://127.0.0.1:";
    REQUIRE(url.starts_with(before));
    const std::size_t slash = url.find('/', before.size());
    port = std::stoi(url.substr(before.size()));
    root = url.substr(slash);
  }

  [[nodiscard]] device::TcpLink connect() const { return {{"127.0.0.1", port}, soon()}; }
  static device::Deadline soon() { return device::in_s(60); }

  /// All that comes until the other side ends the connection.
  static Answer await(device::TcpLink& link) {
    std::string all;
    try {
      for (;;) all += link.receive(soon());
    } catch (const device::LinkError& end) {
      REQUIRE(end.kind == device::LinkError::Kind::closed);
    }
    return parsed(all);
  }

  [[nodiscard]] std::string request(const std::string& path, const std::string& method = "GET",
                                    const std::string& more = "") const {
    return method + " " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n" +
           more + "\r\n";
  }
  [[nodiscard]] Answer send(const std::string& bytes) const {
    device::TcpLink link = connect();
    link.send(bytes, soon());
    return await(link);
  }
  [[nodiscard]] Answer get(const std::string& path) const { return send(request(path)); }

  int port = 0;
  std::string root;
};

}  // namespace

TEST_CASE("the live page, its status and its data are answered under the token", "[serve]") {
  const serve::Server server(options());
  const Client client(server);
  CHECK(client.root.size() == 2 + 32);

  const Answer page = client.get(client.root);
  CHECK(page.status == 200);
  CHECK_THAT(page.body, Contains("connect-src 'self'") && Contains("SIMULATED"));
  CHECK(page.body.size() == std::stoul(page.headers.at("Content-Length")));
  CHECK(page.headers.at("Content-Type") == "text/html; charset=utf-8");
  CHECK(page.headers.at("Cache-Control") == "no-store");
  CHECK(page.headers.at("Referrer-Policy") == "no-referrer");
  CHECK(page.headers.at("X-Content-Type-Options") == "nosniff");
  CHECK(page.headers.at("X-Frame-Options") == "DENY");
  CHECK(page.headers.at("Cross-Origin-Resource-Policy") == "same-origin");

  const auto now = nlohmann::json::parse(client.get(client.root + "status.json").body);
  CHECK(now.at("state") == "done");
  CHECK(now.at("n_ok") == now.at("n_points"));
  CHECK(now.at("simulated") == true);
  CHECK(now.at("last").size() > 1);

  const Answer data = client.get(client.root + "page.json?again");
  CHECK(data.headers.at("Content-Type") == "application/json");
  CHECK(tests::schema_errors(nlohmann::json::parse(data.body), "report-page.schema.json") == "");
}

TEST_CASE("without the token, from a foreign name or to change something: nothing", "[serve]") {
  const serve::Server server(options());
  const Client client(server);
  std::string wrong = client.root;
  wrong[5] = wrong[5] == '0' ? '1' : '0';
  for (const std::string& path :
       {std::string("/"), std::string("/status.json"), wrong, wrong + "status.json",
        client.root + "../trammel.db", client.root + "trammel.db", client.root + "status.json/",
        client.root.substr(0, client.root.size() - 1), std::string("//"), std::string("*")}) {
    CAPTURE(path);
    const Answer answer = client.get(path);
    CHECK(answer.status >= 400);
    CHECK(answer.body.find("trammel") == std::string::npos);
  }
  const std::string at_root = "GET " + client.root + " HTTP/1.1\r\n";
  const std::string port = std::to_string(client.port);
  CHECK(client.send(at_root + "Host: localhost:" + port + "\r\n\r\n").status == 200);
  CHECK(client.send(at_root + "Host: evil.example:" + port + "\r\n\r\n").status == 404);
  CHECK(client.send(at_root + "\r\n").status == 404);
  for (const char* method : {"POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PATCH", "BREW"}) {
    CAPTURE(method);
    CHECK(client.send(client.request(client.root, method)).status >= 400);
  }
}

TEST_CASE("a body is not taken, and what follows a request is not answered", "[serve]") {
  const serve::Server server(options());
  const Client client(server);
  const std::string status = client.root + "status.json";
  for (const char* method : {"POST", "PUT"}) {
    const std::string head = client.request(status, method, "Content-Length: 4\r\n");
    CHECK(client.send(head + "null").status >= 400);
  }
  const Answer one = client.send(client.request(status) + client.request(status));
  CHECK(one.status == 200);
  CHECK(one.body.size() == std::stoul(one.headers.at("Content-Length")));
}

TEST_CASE("a client that is slow is cut off", "[serve]") {
  serve::Options impatient = options();
  impatient.patience = std::chrono::milliseconds(100);
  const serve::Server server(impatient);
  const Client client(server);
  for (const std::string& begun : {std::string(), "GET " + client.root, std::string("G")}) {
    device::TcpLink slow = client.connect();
    if (!begun.empty()) slow.send(begun, Client::soon());
    CHECK(Client::await(slow).status != 200);
  }
}

TEST_CASE("clients that are slow, go away or send too much keep no other from its answer",
          "[serve]") {
  const serve::Server server(options());
  const Client client(server);
  const std::string status = client.root + "status.json";
  std::vector<std::unique_ptr<device::TcpLink>> slow;
  for (int k = 0; k < 20; ++k) {
    slow.push_back(std::make_unique<device::TcpLink>(device::Endpoint{"127.0.0.1", client.port},
                                                     Client::soon()));
    slow.back()->send("GET " + status, Client::soon());
  }
  CHECK(client.get(status).status == 200);

  for (int k = 0; k < 5; ++k) client.connect().send(client.request(client.root), Client::soon());
  CHECK(client.get(status).status == 200);

  std::string endless = "GET " + status + " HTTP/1.1\r\n";
  for (int k = 0; k < 16; ++k) endless += "X: " + std::string(1 << 10, 'x') + "\r\n";
  CHECK(client.send(endless).status >= 400);
  CHECK(client.get(status).status == 200);
}

namespace {

/// A server in a process that may have 300 handles, as one that has been left running.
class Narrow {
 public:
  explicit Narrow(const serve::Options& options) {
    int ends[2];
    REQUIRE(::pipe(ends) == 0);
    child_ = ::fork();
    if (child_ == 0) {
      const rlimit few = {300, 300};
      ::setrlimit(RLIMIT_NOFILE, &few);
      const serve::Server server(options);
      const std::string there = server.url();
      static_cast<void>(!::write(ends[1], there.data(), there.size()));
      for (;;) ::pause();
    }
    char text[256];
    url = std::string(text, static_cast<std::size_t>(::read(ends[0], text, sizeof text)));
    ::close(ends[0]);
    ::close(ends[1]);
  }
  ~Narrow() {
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  Narrow(const Narrow&) = delete;
  Narrow& operator=(const Narrow&) = delete;
  std::string url;

 private:
  pid_t child_ = -1;
};

/// Seconds until a request is answered that comes after `n` halves, which are held open; 3: never.
double answered_after_s(const serve::Options& options, int n) {
  const Narrow server(options);
  const Client client(server.url);
  std::vector<std::unique_ptr<device::TcpLink>> halves;
  for (int k = 0; k < n; ++k) {
    halves.push_back(std::make_unique<device::TcpLink>(device::Endpoint{"127.0.0.1", client.port},
                                                       Client::soon()));
    halves.back()->send("GET " + client.root, Client::soon());
  }
  device::TcpLink whole = client.connect();
  const auto asked = std::chrono::steady_clock::now();
  whole.send(client.request(client.root + "status.json"), Client::soon());
  std::string answer;
  try {
    answer = whole.receive(device::in_s(3));
  } catch (const device::LinkError& error) {
    CHECK(error.kind == device::LinkError::Kind::silent);
    return 3;
  }
  CHECK(answer.starts_with("HTTP/1.1 200"));
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - asked).count();
}

}  // namespace

TEST_CASE("beside 1,100 clients who never end their requests, one who asks is answered in a second",
          "[serve]") {
  constexpr int kClients = 1100;
  rlimit handles{};
  REQUIRE(::getrlimit(RLIMIT_NOFILE, &handles) == 0);
  if (handles.rlim_max < 2 * kClients)
    return tests::skip("no more than " + std::to_string(handles.rlim_max) + " handles");
  const rlimit many = {handles.rlim_max, handles.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_NOFILE, &many) == 0);
  serve::Options served = options();
  CHECK(answered_after_s(served, kClients) < 1);

  served.most_waiting = 10'000;  // the control: who keeps them all has no handle left
  CHECK(answered_after_s(served, kClients) == 3);
  REQUIRE(::setrlimit(RLIMIT_NOFILE, &handles) == 0);
}

TEST_CASE("of a request that lies there whole when its turn to go has come, the answer comes",
          "[serve]") {
  serve::Options few = options();
  few.most_waiting = 1;
  const serve::Server server(few);
  const Client client(server.url());
  for (int n = 0; n < 50; ++n) {
    device::TcpLink first = client.connect();
    first.send(client.request(client.root + "status.json"), Client::soon());
    const device::TcpLink second = client.connect(), third = client.connect();
    CHECK(Client::await(first).status == 200);
  }
}

TEST_CASE("while the database is being replaced the page is told to ask again", "[serve]") {
  const tests::TemporaryFolder folder;
  const auto database = folder.path() / "lab.db", aside = folder.path() / "aside.db";
  std::filesystem::copy_file(laboratory().database(), database);
  serve::Options moving = options();
  moving.database = database;
  const serve::Server server(moving);
  const Client client(server);
  std::filesystem::rename(database, aside);
  for (const char* name : {"", "status.json", "page.json"}) {
    const Answer answer = client.get(client.root + name);
    CHECK(answer.status == 503);
    CHECK(answer.body.empty());
  }
  std::filesystem::rename(aside, database);
  CHECK(client.get(client.root + "status.json").status == 200);
}

TEST_CASE("a server that is stopped ends what is open and refuses what comes", "[serve]") {
  serve::Server server(options());
  const Client client(server);
  device::TcpLink open = client.connect();
  open.send("GET ", Client::soon());
  CHECK(client.get(client.root + "status.json").status == 200);
  std::thread([&server] { server.stop(); }).join();
  CHECK(Client::await(open).status == 0);
  server.stop();
  CHECK_THROWS_AS(client.connect(), device::LinkError);
}

TEST_CASE("each server has a token of its own, and a port that is taken is said", "[serve]") {
  const serve::Server one(options());
  const serve::Server two(options());
  CHECK(Client(one).root != Client(two).root);
  serve::Options taken = options();
  taken.port = Client(one).port;
  try {
    const serve::Server third(taken);
    FAIL("two servers on one port");
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::device);
    CHECK(error.text().got == std::to_string(taken.port));
  }
  serve::Options nobody = options();
  nobody.campaign = "nobody";
  CHECK_THROWS_AS(serve::Server(nobody), NotFoundError);
}
