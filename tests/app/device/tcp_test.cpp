#include "app/device/tcp.hpp"

#include <signal.h>
#include <sys/time.h>

#include "tests/support/catch.hpp"
#include "tests/support/scripted_server.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

constexpr double kSoonS = 0.1;
constexpr double kLongS = 10;

LinkError::Kind kind_of_receive(TcpLink& link, double timeout_s) {
  try {
    static_cast<void>(link.receive(in_s(timeout_s)));
  } catch (const LinkError& error) {
    return error.kind;
  }
  FAIL("something was received");
  return LinkError::Kind::nonsense;
}

}  // namespace

TEST_CASE("bytes go out and come back over one connection", "[device][tcp]") {
  tests::ScriptedServer server("\n");
  server.on("ping", "pong");
  TcpLink link({"127.0.0.1", server.port()}, in_s(kLongS));
  CHECK(link.pending().empty());
  link.send("ping\n", in_s(kLongS));
  CHECK(link.receive(in_s(kLongS)) == "pong");
}

TEST_CASE("silence ends at the deadline and leaves the line closed", "[device][tcp]") {
  tests::ScriptedServer server("\n");
  TcpLink link({"127.0.0.1", server.port()}, in_s(kLongS));
  const auto begin = std::chrono::steady_clock::now();
  CHECK(kind_of_receive(link, kSoonS) == LinkError::Kind::silent);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  CHECK(took.count() >= kSoonS);
  CHECK(took.count() < kLongS);
  CHECK_THROWS_AS(link.send("ping\n", in_s(kSoonS)), LinkError);
}

TEST_CASE("a connection ended by the other side is told, on reading and writing", "[device][tcp]") {
  tests::ScriptedServer server("\n");
  server.on("go", {{"half", true}});
  TcpLink link({"127.0.0.1", server.port()}, in_s(kLongS));
  link.send("go\n", in_s(kLongS));
  CHECK(link.receive(in_s(kLongS)) == "half");
  CHECK(kind_of_receive(link, kLongS) == LinkError::Kind::closed);
  TcpLink again({"127.0.0.1", server.port()}, in_s(kLongS));
  server.vanish();
  // The first bytes may still go into the buffer; no SIGPIPE ends the program after them.
  CHECK_THROWS_AS(
      [&] {
        for (int k = 0; k < 1000; ++k) again.send("ping\n", in_s(kLongS));
      }(),
      LinkError);
}

TEST_CASE("nobody at a port, or a host without an address, is no connection", "[device][tcp]") {
  int port = 0;
  {
    const tests::ScriptedServer server("\n");
    port = server.port();
  }
  for (const Endpoint& to : {Endpoint{"127.0.0.1", port}, {"no such host.invalid", 1}}) {
    try {
      const TcpLink link(to, in_s(1));
      FAIL("connected to " + to.text());
    } catch (const LinkError& error) {
      CHECK(error.kind == LinkError::Kind::no_connection);
      CHECK(error.code() == ExitCode::device);
    }
  }
}

TEST_CASE("a wait beyond what the clock counts is a long one", "[device][tcp]") {
  const auto now = std::chrono::steady_clock::now();
  for (const double seconds : {1e9, 1e10, 1e300})
    CHECK(in_s(seconds) > now + std::chrono::years(30));
  CHECK(in_s(-1e300) < now);
}

TEST_CASE("signals while waiting neither end nor lengthen the wait", "[device][tcp]") {
  tests::ScriptedServer server("\n");
  server.on("go", {{"late", false, 0.1}});
  TcpLink link({"127.0.0.1", server.port()}, in_s(kLongS));
  struct sigaction act {};
  struct sigaction old {};
  act.sa_handler = [](int) {};
  REQUIRE(::sigaction(SIGALRM, &act, &old) == 0);  // without SA_RESTART
  const itimerval every_5_ms{{0, 5000}, {0, 5000}}, none{};
  ::setitimer(ITIMER_REAL, &every_5_ms, nullptr);
  link.send("go\n", in_s(kLongS));
  const std::string got = link.receive(in_s(kLongS));
  const LinkError::Kind then = kind_of_receive(link, kSoonS);
  ::setitimer(ITIMER_REAL, &none, nullptr);
  ::sigaction(SIGALRM, &old, nullptr);
  CHECK(got == "late");
  CHECK(then == LinkError::Kind::silent);
}
