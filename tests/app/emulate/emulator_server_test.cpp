#include "app/emulate/server.hpp"

#include <atomic>

#include "core/error.hpp"
#include "tests/app/emulate/client.hpp"
#include "tests/support/catch.hpp"

namespace trammel::emulate {

using tests::Client;

namespace {

using Seconds = std::chrono::duration<double>;

/// Says each line again; "later …" in a while, "bye" and closes.
class Echo : public Conversation {
 public:
  explicit Echo(std::atomic<int>& alive) : alive_(alive) { ++alive_; }
  ~Echo() override { --alive_; }
  std::vector<Answer> receive(std::string_view bytes) override {
    std::vector<Answer> answers;
    for (const LineReader::Line& line : reader_.add(bytes)) {
      Answer answer{.bytes = line.text + "\n"};
      if (line.text.starts_with("later")) answer.after = Seconds(0.05);
      answer.close = line.text == "bye";
      answers.push_back(std::move(answer));
    }
    return answers;
  }

 private:
  std::atomic<int>& alive_;
  LineReader reader_{'\n', 1000};
};

struct EchoServer {
  std::atomic<int> alive = 0;
  Server server;
  explicit EchoServer(const ServerOptions& options = {})
      : server(options, [this](const Peer&) { return std::make_unique<Echo>(alive); }) {}
  /// Waits until so many conversations are left.
  void until_alive(int n) const {
    while (alive != n) std::this_thread::yield();
  }
};

std::string lines(Client& client, std::ptrdiff_t n) {
  return client.receive(
      [n](const std::string& got) { return std::count(got.begin(), got.end(), '\n') >= n; });
}

}  // namespace

TEST_CASE("a line is whole however it was cut into packets", "[emulate]") {
  const EchoServer echo;
  Client client(echo.server.port());
  for (const char* piece : {"ab", "c\r", "\nsecond\r\nth"}) {
    client.send(piece);
  }
  CHECK(lines(client, 2) == "abc\nsecond\n");
  client.send("ird\n");
  CHECK(lines(client, 1) == "third\n");
}

TEST_CASE("a line too long is one line, cut", "[emulate]") {
  LineReader reader('\r', 5);
  CHECK(reader.add("12345678").empty());
  const auto cut = reader.add("9\r\n123\r12345\r");
  REQUIRE(cut.size() == 3);
  CHECK((cut[0].text == "12345" && cut[0].too_long));
  CHECK((cut[1].text == "123" && !cut[1].too_long));
  CHECK((cut[2].text == "12345" && !cut[2].too_long));
}

TEST_CASE("answers leave in the order of their due times, connections apart", "[emulate]") {
  const EchoServer echo;
  Client one(echo.server.port()), two(echo.server.port());
  one.send("later a\nnow b\n");
  two.send("x\n");
  CHECK(lines(two, 1) == "x\n");
  CHECK(lines(one, 2) == "now b\nlater a\n");
}

TEST_CASE("the ninth connection is refused until one of the eight has gone", "[emulate]") {
  const EchoServer echo;
  std::vector<std::unique_ptr<Client>> eight;
  for (int k = 0; k < 8; ++k) eight.push_back(std::make_unique<Client>(echo.server.port()));
  echo.until_alive(8);
  Client ninth(echo.server.port());
  CHECK(lines(ninth, 1).empty());
  CHECK(ninth.closed());
  eight.pop_back();  // FIN
  echo.until_alive(7);
  Client again(echo.server.port());
  again.send("hello\n");
  CHECK(lines(again, 1) == "hello\n");
  for (auto& client : eight) {
    client->send("still here\n");
    CHECK(lines(*client, 1) == "still here\n");
  }
}

TEST_CASE("an answer that closes is sent whole before", "[emulate]") {
  const EchoServer echo;
  Client client(echo.server.port());
  client.send("one\nbye\nnever\n");
  CHECK(client.receive([](const std::string&) { return false; }) == "one\nbye\n");
  CHECK(client.closed());
  echo.until_alive(0);
}

TEST_CASE("a client that does not read loses nothing and holds nobody up", "[emulate]") {
  const EchoServer echo;
  Client lazy(echo.server.port()), brisk(echo.server.port());
  constexpr int kLines = 600;
  const std::string line(900, 'x');
  std::thread writer([&] {
    for (int k = 0; k < kLines; ++k) lazy.send(line + "\n");
  });
  brisk.send("quick\n");
  CHECK(lines(brisk, 1) == "quick\n");
  const std::string all = lines(lazy, kLines);
  writer.join();
  CHECK(all.size() == kLines * (line.size() + 1));
}

TEST_CASE("a server stops while clients are connected and answers are due", "[emulate]") {
  auto echo = std::make_unique<EchoServer>();
  const int port = echo->server.port();
  Client client(port);
  client.send("hello\nlater\n");
  CHECK(lines(client, 1) == "hello\n");
  echo.reset();
  client.receive([](const std::string&) { return false; });
  CHECK(client.closed());
  CHECK_THROWS_WITH(Client(port), Contains("no server"));
}

TEST_CASE("an address that cannot be had is said with its port", "[emulate]") {
  const EchoServer first;
  ServerOptions taken;
  taken.port = first.server.port();
  CHECK_THROWS_WITH(EchoServer(taken),
                    Contains(std::to_string(taken.port)) && Contains("--port 0"));
  CHECK_THROWS_AS(EchoServer({.address = "nowhere"}), UsageError);
  CHECK_THROWS_AS(EchoServer({.port = 70000}), UsageError);
}

}  // namespace trammel::emulate
