// Programs in the emulated controller: downloaded, run without a host, ended.

#include <thread>

#include "tests/app/emulate/client.hpp"
#include "tests/app/emulate/emulated.hpp"
#include "tests/support/catch.hpp"

namespace trammel::emulate {

namespace {

struct Programmed {
  tests::Controller controller;
  Server server{{.meanwhile = [this] { return controller.galil.programs.work(); }},
                galil_conversations(controller.galil, controller.faults)};
  tests::Client client{server.port()};

  std::string download(const std::string& text) {
    client.send("DL\r" + text + "\x1a\r");
    return client.receive([](const std::string& got) { return got.size() >= 2; }, 500);
  }
  int code() { return static_cast<int>(client.number("MG _TC")); }
  void until_ended(const char* thread) {
    while (client.number(std::string("MG _XQ") + thread) >= 0) {
    }
  }
};

}  // namespace

TEST_CASE("a program runs in its thread, waits and jumps, and the host reads what it has set",
          "[emulate]") {
  Programmed p;
  CHECK(p.download("#A\rn=5;m=n\r#L\rm=0\rWT 30\rJP #L,m=1\rn=7\rEN\r") == "::");
  CHECK(p.client.galil("XQ #A,3") == ":");
  CHECK(p.client.number("MG _XQ3") >= 0);
  CHECK(p.client.number("MG _XQ0") == -1);
  for (int k = 0; k < 8; ++k) {  // as long as it is fed it goes round
    p.client.galil("m=1");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(p.client.number("MG n") == 5);
  p.until_ended("3");
  CHECK(p.client.number("MG n") == 7);
}

TEST_CASE("what a controller refuses of programs has its code", "[emulate]") {
  Programmed p;
  CHECK(p.client.galil("WT 10") == "?");
  CHECK(p.code() == 2);
  CHECK(p.client.galil("XQ") == "?");  // there is none
  CHECK(p.code() == 10);
  CHECK(p.download("#A\rWT 60000\rEN\r") == "::");
  CHECK(p.client.galil("XQ #B") == "?");
  CHECK(p.code() == 10);
  CHECK(p.client.galil("XQ #A") == ":");
  CHECK(p.client.galil("DL") == "?");  // while it runs
  CHECK(p.client.galil("HX0") == ":");
  CHECK(p.client.number("MG _XQ0") == -1);
  CHECK(p.download("#A\rXX\rn=1\rEN\r") == "::");  // a statement that is refused ends it
  CHECK(p.client.galil("XQ #A") == ":");
  p.until_ended("0");
  CHECK(p.client.galil("MG n") == "?");
}

TEST_CASE("AB ends programs, AB1 spares them", "[emulate]") {
  Programmed p;
  CHECK(p.download("#A\rWT 60000\rEN\r") == "::");
  p.client.galil("XQ #A");
  p.client.galil("AB1");
  CHECK(p.client.number("MG _XQ0") >= 0);
  p.client.galil("AB");
  CHECK(p.client.number("MG _XQ0") == -1);
}

}  // namespace trammel::emulate
