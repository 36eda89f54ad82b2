// The controller's watch of its host: the program that is loaded, and what is said when it is gone.

#include "app/device/galil_watch.hpp"

#include <thread>

#include "app/device/galil.hpp"
#include "core/mechanism/inverse.hpp"
#include "tests/app/emulate/client.hpp"
#include "tests/app/emulate/emulated.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/scripted_server.hpp"

namespace trammel::device {

namespace {

/// A controller that is emulated in a hurry; its programs wait as long as those of a real one.
struct Watched {
  emulate::Faults faults;
  emulate::EmulatedRobot robot{
      simulate::VirtualRobot(tests::emulated_truth()), {}, emulate::wall_clock(1000)};
  emulate::Galil galil{robot, faults};
  emulate::Server server{{.meanwhile = [this] { return galil.programs.work(); }},
                         emulate::galil_conversations(galil, faults)};
  tests::Client hand{server.port()};

  [[nodiscard]] GalilSettings settings() const {
    GalilSettings s;
    s.controller = {"127.0.0.1", server.port()};
    s.watch_host_s = 0.4;
    s.poll_s = s.settle_s = 0;
    s.machine = machine_of(paper_mechanism());
    for (int i = 0; i < kChains; ++i) {
      s.axes.push_back({.letter = "ABC"[i], .zero_mm = home()[i]});
    }
    return s;
  }
  static Displacements home() {
    return inverse(paper_mechanism().geometry, paper_mechanism().home).l_mm;
  }
};

}  // namespace

TEST_CASE("the program stops the axes it is given when it is not fed, and then switches them off",
          "[device][galil]") {
  GalilSettings s;
  s.watch_host_s = 0.5;
  s.speed_mm_s = 20;
  s.acceleration_mm_s2 = 100;
  for (const char letter : {'B', 'D', 'F'}) s.axes.push_back({.letter = letter});
  CHECK(host_watch_program(s) == std::vector<std::string>{"#HOST", "hostfed=0", "WT 250",
                                                          "JP #HOST,hostfed=1", "STBDF", "WT 700",
                                                          "MOBDF", "EN"});
}

TEST_CASE("a stage that is watched stands and moves as long as it is there, and nothing is left",
          "[device][galil]") {
  Watched watched;
  {
    GalilStage stage(watched.settings());
    REQUIRE(stage.home().ok());
    CHECK(watched.hand.number("MG _XQ1") >= 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(900));  // more than two deadlines
    CHECK(watched.hand.number("MG _MOA") == 0);
    CHECK(stage.move(Watched::home().array() + 3, {}).ok());
    CHECK(stage.home().ok());  // again: loaded anew
  }
  CHECK(watched.hand.number("MG _XQ1") == -1);
  CHECK(watched.hand.number("MG _MOA") == 1);
}

TEST_CASE("a watch that somebody has ended is no watch: nothing moves before it is there again",
          "[device][galil]") {
  Watched watched;
  GalilStage stage(watched.settings());
  REQUIRE(stage.home().ok());
  watched.hand.galil("HX1");
  const StageReport refused = stage.move(Watched::home().array() + 3, {});
  CHECK(refused.status == Status::fault);
  CHECK_THAT(refused.detail, Contains("not begun") && Contains("home again"));
  CHECK_FALSE(stage.homed());
  CHECK(stage.home().ok());
  CHECK(stage.move(Watched::home().array() + 3, {}).ok());
}

TEST_CASE("a controller that takes no program is not homed", "[device][galil]") {
  tests::ScriptedServer server{"\r"};
  server.otherwise([](const std::string& line) -> std::string {
    if (line == "\x12\x16") return "DMC4183 Rev 1.3h\r\n:";
    if (line == "MG _BN") return " 1.0000\r\n:";
    if (line == "DL") return "?";
    if (line.starts_with("MG") || line.starts_with("T") || line.starts_with("R")) {
      std::string answer;
      for (auto n = std::count(line.begin(), line.end(), ';'); n >= 0; --n) answer += " 0\r\n:";
      return answer;
    }
    return ":";
  });
  Watched watched;
  GalilSettings settings = watched.settings();
  settings.controller.port = server.port();
  settings.reply_timeout_s = 0.5;
  GalilStage stage(settings);
  const StageReport report = stage.home();
  CHECK_FALSE(report.ok());
  CHECK_THAT(report.detail, Contains("takes no program"));
  CHECK_FALSE(stage.homed());
}

}  // namespace trammel::device
