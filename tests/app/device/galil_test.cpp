#include "app/device/galil.hpp"

#include <fmt/format.h>

#include <cmath>
#include <future>
#include <map>
#include <mutex>

#include "core/mechanism/machine_solver.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/scripted_server.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

const std::string kLook = "MG _BGA;MG _BGB;MG _BGC;TEA;TEB;TEC;SCA;SCB;SCC";

/// Registers that keep what was set, and moves that take `looks` questions: just enough of a
/// controller for every line the driver sends to have its answer. Faults are scripted over it.
class Controller {
 public:
  Controller() {
    server.otherwise([this](const std::string& line) { return answer(line); });
    for (const char axis : std::string("ABC")) {
      set(std::string("_MO") + axis, 1);
      set(std::string("SC") + axis, 1);
    }
  }

  void set(const std::string& name, long long value) {
    const std::scoped_lock lock(mutex_);
    registers_[name] = value;
  }
  long long get(const std::string& name) {
    const std::scoped_lock lock(mutex_);
    return registers_[name];
  }
  /// A power cycle.
  void reset() {
    const std::scoped_lock lock(mutex_);
    registers_.clear();
    for (const char axis : std::string("ABC")) registers_[std::string("_MO") + axis] = 1;
  }

  tests::ScriptedServer server{"\r"};
  std::atomic<int> looks = 1;  // questions during which a move still runs

 private:
  std::string answer(const std::string& line) {
    std::string bytes;
    for (std::size_t from = 0; from <= line.size();) {
      const std::size_t end = std::min(line.find(';', from), line.size());
      bytes += part(line.substr(from, end - from));
      from = end + 1;
    }
    return bytes;
  }

  std::string part(std::string text) {
    const std::scoped_lock lock(mutex_);
    if (text == "\x12\x16") return "DMC4183 Rev 1.3h\r\n:";
    if (text.starts_with("MG ")) text = text.substr(3);
    if (text.starts_with("EO") || text.starts_with("CW")) return ":";
    if (text.starts_with("AB")) return stopped(7);
    if (text.starts_with("ST")) return stopped(4);
    if (text.starts_with("SH")) return put("_MO" + text.substr(2), 0);
    if (text.starts_with("MO")) return put("_MO" + text.substr(2), 1);
    if (text.starts_with("HM")) return put("HM" + text.substr(2), 1);
    if (text.starts_with("BG")) return begin(text.substr(2));
    if (text.starts_with("DP")) return zero(text.substr(2, 1));
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) return value(text);
    if (text.ends_with("=?")) return value(text.substr(0, equals));
    return put(text.substr(0, equals), std::stoll(text.substr(equals + 1)));
  }

  std::string put(const std::string& name, long long value) {
    registers_[name] = value;
    return ":";
  }

  std::string value(const std::string& name) {
    if (name == "_BGA") --left_;  // the first of each look
    const long long number = name.starts_with("_BG")
                                 ? (left_ >= 0 && moves_.find(name[3]) != std::string::npos)
                             : name.starts_with("SC") && left_ >= 0 ? 0
                                                                    : registers_[name];
    return (number < 0 ? "" : " ") + std::to_string(number) + "\r\n:";
  }

  std::string begin(const std::string& axes) {
    for (const char axis : axes) {
      const std::string a(1, axis);
      if (registers_["_MO" + a] != 0) return refuse(" 20 Begin not valid with motor off");
      const bool homes = std::exchange(registers_["HM" + a], 0) != 0;
      registers_["SC" + a] = homes ? 10 : 1;
      registers_["RP" + a] = registers_["TP" + a] = homes ? 0 : registers_["PA" + a];
    }
    moves_ = axes;
    left_ = looks;
    return ":";
  }

  std::string zero(const std::string& axis) {
    registers_["RP" + axis] = registers_["TP" + axis] = 0;
    return ":";
  }

  std::string stopped(int code) {
    if (left_ >= 0) {
      for (const char axis : moves_) registers_[std::string("SC") + axis] = code;
    }
    left_ = -1;
    return ":";
  }

  std::string refuse(const std::string& why) {
    why_ = why + "\r\n:";
    server.on("TC1", why_);
    return "?";
  }

  std::mutex mutex_;
  std::map<std::string, long long> registers_;
  std::string moves_;
  std::string why_;
  int left_ = -1;
};

GalilSettings settings_for(const Controller& controller) {
  GalilSettings s;
  s.controller = {"127.0.0.1", controller.server.port()};
  s.connect_timeout_s = 10;
  s.machine = machine_of(paper_mechanism());
  const Displacements home_mm = drives_of(s.machine, s.machine.home);
  for (int i = 0; i < kChains; ++i) {
    s.axes.push_back({"ABC"[i], 10, 8192, 1, i == 1 ? -1 : 1, home_mm[i]});
  }
  s.poll_s = 0;
  s.settle_s = 0;
  s.homing_timeout_s = 5;
  s.acceleration_mm_s2 = 2000;
  s.speed_mm_s = 400;  // the scripted moves are short in time
  return s;
}

/// A wait that ends a test which must wait for it.
constexpr double kShortS = 0.2;

struct Homed {
  Controller controller;
  std::unique_ptr<GalilStage> stage;
  Displacements home_mm;
  explicit Homed(double wait_s = 5) {
    GalilSettings settings = settings_for(controller);
    settings.reply_timeout_s = settings.margin_s = settings.settle_timeout_s = wait_s;
    stage = std::make_unique<GalilStage>(settings);
    const StageReport report = stage->home();
    INFO(report.detail);
    REQUIRE(report.ok());
    home_mm = report.encoder_mm;
  }
  [[nodiscard]] Displacements target() const { return home_mm + Displacements(10, -5, 2.5); }
};

const Watch kUnwatched = [] { return Status::ok; };

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("homing ends at count 0 of each axis, at home, with soft limits set", "[device][galil]") {
  Homed h;
  CHECK(h.stage->homed());
  CHECK(h.controller.get("OEA") == 1);
  CHECK(h.controller.get("_MOB") == 0);
  CHECK(h.controller.get("ERA") == 820);  // twice 0.5 mm
  const double home_counts = h.home_mm[0] * 819.2;
  CHECK(h.controller.get("BLA") == std::llround(std::ceil(-home_counts)));
  CHECK(h.controller.get("FLA") == std::llround(std::floor((600 - h.home_mm[0]) * 819.2)));
  CHECK(h.controller.get("FLB") ==
        std::llround(std::floor(home_counts)));  // counts fall on the second rail
  CHECK(has(h.stage->describe(), "DMC4183 Rev 1.3h"));
}

TEST_CASE("a move sets all three axes, starts them as one and reports both positions",
          "[device][galil]") {
  Homed h;
  const StageReport report = h.stage->move(h.target(), kUnwatched);
  INFO(report.detail);
  REQUIRE(report.ok());
  CHECK(h.controller.get("PAA") == 8192);
  CHECK(h.controller.get("PAB") == 4096);
  CHECK(h.controller.get("PAC") == 2048);
  CHECK(h.controller.server.count("BGABC") == 2);  // homing, and this
  CHECK((report.commanded_mm - h.target()).cwiseAbs().maxCoeff() < 1e-9);
  CHECK((report.encoder_mm - h.target()).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(h.controller.get("SPA") == 327'680);
  CHECK(h.controller.get("ACA") % 1024 == 0);
}

TEST_CASE("a rail that stays is not started", "[device][galil]") {
  Homed h;
  REQUIRE(h.stage->move(h.home_mm + Displacements(0, 3, 0), kUnwatched).ok());
  CHECK(h.controller.server.count("BGB") == 1);
}

TEST_CASE("before homing, beyond the stroke or without a number nothing is sent",
          "[device][galil]") {
  Controller controller;
  GalilStage stage(settings_for(controller));
  CHECK(stage.move(Displacements(1, 1, 1), kUnwatched).status == Status::fault);
  CHECK(controller.server.lines().empty());
  Homed h;
  for (const double l_mm : {-0.1, 600.1, std::nan("")}) {
    const StageReport report = h.stage->move(Displacements(l_mm, 260, 260), kUnwatched);
    CHECK(report.status == Status::limit);
    CHECK(has(report.detail, "rail 1 would leave its stroke"));
  }
  CHECK(h.controller.server.count("BGABC") == 1);
}

TEST_CASE("a watch that is not ok stops the stage within one poll", "[device][galil]") {
  for (const Status seen : {Status::beam_broken, Status::timeout, Status::fault}) {
    Homed h;
    h.controller.looks = 1'000'000;
    int asked = 0;
    const Watch watch = [&] { return ++asked < 4 ? Status::ok : seen; };
    const StageReport report = h.stage->move(h.target(), watch);
    CHECK(report.status == seen);
    CHECK(asked == 4);
    CHECK(h.controller.server.count("STABC") == 1);
    CHECK(has(report.detail, "the rails stand at"));
  }
}

TEST_CASE("a watch that is not ok before the move lets nothing begin", "[device][galil]") {
  Homed h;
  const Watch watch = [] { return Status::beam_broken; };
  CHECK(h.stage->move(h.target(), watch).status == Status::beam_broken);
  CHECK(h.controller.server.count("BGABC") == 1);
}

TEST_CASE("stop codes are told as sentences and stop the other rails", "[device][galil]") {
  struct Case {
    int code;
    Status status;
    const char* words;
    bool homed;
    int off;
  };
  for (const Case& c : {Case{2, Status::limit, "rail 2 ran into its forward limit", true, 0},
                        {3, Status::limit, "reverse limit", true, 0},
                        {4, Status::fault, "did not come from here", false, 1},
                        {6, Status::fault, "abort input", false, 1},
                        {8, Status::following_error, "position error", false, 1},
                        {12, Status::fault, "encoder failure", false, 1},
                        {15, Status::fault, "amplifier fault", false, 1},
                        {77, Status::fault, "unknown reason (SC 77)", false, 1}}) {
    CAPTURE(c.code);
    Homed h;
    const std::string answer =
        fmt::format(" 1\r\n: 0\r\n: 1\r\n: 0\r\n: 0\r\n: 0\r\n: 0\r\n: {}\r\n: 0\r\n:", c.code);
    const std::string rest = " 0\r\n: 0\r\n: 0\r\n: 0\r\n: 0\r\n: 0\r\n: 4\r\n: 2\r\n: 4\r\n:";
    h.controller.server.on(kLook, {{answer}, {rest}});
    const StageReport report = h.stage->move(h.target(), kUnwatched);
    CHECK(report.status == c.status);
    CHECK_THAT(report.detail, Catch::Matchers::Contains(c.words));
    CHECK(h.controller.server.count("STABC") == 1);
    CHECK(h.stage->homed() == c.homed);
    CHECK(h.controller.get("_MOA") == c.off);
  }
}

TEST_CASE("an encoder that leaves its command stops the stage", "[device][galil]") {
  Homed h;
  h.controller.looks = 1'000'000;
  h.controller.set("TEB", 420);  // 0.51 mm
  const StageReport report = h.stage->move(h.target(), kUnwatched);
  CHECK(report.status == Status::following_error);
  CHECK(has(report.detail, "rail 2"));
  CHECK(h.controller.get("_MOC") == 1);
  CHECK_FALSE(h.stage->homed());
}

TEST_CASE("a rail that never ends its move, or never settles, times out", "[device][galil]") {
  Homed h(kShortS);
  h.controller.set("TEC", 8);  // 0.0098 mm, the band is 0.005
  const StageReport unsettled = h.stage->move(h.target(), kUnwatched);
  CHECK(unsettled.status == Status::timeout);
  CHECK(has(unsettled.detail, "rail 3 does not settle"));
  h.controller.set("TEC", 0);
  h.controller.looks = 1'000'000;
  const StageReport stalled = h.stage->move(h.home_mm, kUnwatched);
  CHECK(stalled.status == Status::timeout);
  CHECK(has(stalled.detail, "still move"));
  CHECK(h.controller.server.count("STABC") == 2);
  h.controller.looks = 1;
  CHECK(h.stage->homed());
  CHECK(h.stage->move(h.home_mm, kUnwatched).ok());
}

TEST_CASE("where ST is refused the stage is aborted", "[device][galil]") {
  Homed h;
  h.controller.looks = 1'000'000;
  h.controller.server.on("STABC", "?");
  h.controller.server.on("TC1", " 1 Unrecognized command\r\n:");
  const StageReport report = h.stage->move(
      h.target(), [n = 0]() mutable { return ++n < 3 ? Status::ok : Status::beam_broken; });
  CHECK(report.status == Status::beam_broken);
  CHECK(h.controller.server.count("AB1") == 1);
}

TEST_CASE("a refused start says why", "[device][galil]") {
  Homed h;
  h.controller.server.on("BGABC", "?");
  h.controller.server.on("TC1", " 22 Begin not possible due to Limit Switch\r\n:");
  const StageReport report = h.stage->move(h.target(), kUnwatched);
  CHECK(report.status == Status::limit);
  CHECK(has(report.detail, "22 Begin not possible due to Limit Switch"));
}

TEST_CASE("a value that the controller cuts to size is refused", "[device][galil]") {
  Homed h;
  h.controller.server.on("SPA=?", " 300000\r\n:");
  const StageReport report = h.stage->move(h.target(), kUnwatched);
  CHECK(report.status == Status::fault);
  CHECK(has(report.detail, "got 300000, expected 327680"));
  CHECK(h.controller.server.count("BGABC") == 1);
}

TEST_CASE("a lost or halved answer at any step is an outcome unknown, and is asked for",
          "[device][galil]") {
  std::vector<std::string> steps;
  {
    Homed h;
    const std::size_t before = h.controller.server.lines().size();
    REQUIRE(h.stage->move(h.target(), kUnwatched).ok());
    const auto lines = h.controller.server.lines();
    for (std::size_t k = before; k < lines.size(); ++k) {
      if (std::find(steps.begin(), steps.end(), lines[k]) == steps.end()) steps.push_back(lines[k]);
    }
  }
  REQUIRE(steps.size() > 25);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const std::string& line = steps[k];
    // By turns: a connection that ends after half an answer, or none; silence after half, or none.
    const tests::Answer fault{k % 4 < 2 ? "" : " 4", k % 8 != 0 && k % 8 != 2};
    CAPTURE(line, fault.bytes, fault.close);
    Homed h(kShortS);
    h.controller.looks = 3;
    h.controller.server.on(line, {fault, tests::kUsual});
    const int connections = h.controller.server.connections();
    const StageReport report = h.stage->move(h.target(), kUnwatched);
    CHECK(report.status == Status::timeout);
    CHECK_THAT(report.detail, Catch::Matchers::Contains("unknown") &&
                                  Catch::Matchers::Contains("the rails stand at"));
    CHECK(h.controller.server.connections() == connections + 1);
    CHECK(h.controller.server.count("STABC") == 1);
    CHECK(h.stage->homed());
    const StageReport again = h.stage->move(h.target(), kUnwatched);
    INFO(again.detail);
    CHECK(again.ok());
  }
}

TEST_CASE("a controller that was reset behind a lost answer must be homed again",
          "[device][galil]") {
  Homed h;
  h.controller.server.on("BGABC", {{"", true}, tests::kUsual});
  h.controller.reset();
  const StageReport report = h.stage->move(h.target(), kUnwatched);
  CHECK(report.status == Status::fault);
  CHECK(has(report.detail, "home again"));
  CHECK_FALSE(h.stage->homed());
}

TEST_CASE("a line closed while idle is opened again without a word, unless the set-up is gone",
          "[device][galil]") {
  Homed h;
  const auto close_after_stop = [&] {
    h.controller.server.on("RPA;RPB;RPC", {{" 0\r\n: 0\r\n: 0\r\n:", true}, tests::kUsual});
    REQUIRE(h.stage->stop().ok());
    h.controller.server.await_none();
  };
  close_after_stop();
  CHECK(h.stage->move(h.target(), kUnwatched).ok());
  close_after_stop();
  h.controller.reset();
  const StageReport report = h.stage->move(h.home_mm, kUnwatched);
  CHECK(report.status == Status::fault);
  CHECK(has(report.detail, "home again"));
}

TEST_CASE("when nothing answers any more, nobody claims that the stage stands", "[device][galil]") {
  Homed h;
  h.controller.looks = 1'000'000;
  const StageReport report = h.stage->move(h.target(), [&, n = 0]() mutable {
    if (++n == 3) h.controller.server.vanish();
    return Status::ok;
  });
  CHECK(report.status == Status::fault);
  CHECK(has(report.detail, "unknown"));
  CHECK(has(report.detail, "emergency stop"));
  CHECK_FALSE(h.stage->homed());
}

TEST_CASE("homing that ends at a limit or is refused leaves a stage that is not homed",
          "[device][galil]") {
  Controller controller;
  GalilStage stage(settings_for(controller));
  controller.server.on(kLook, " 0\r\n: 0\r\n: 0\r\n: 0\r\n: 0\r\n: 0\r\n: 10\r\n: 3\r\n: 10\r\n:");
  const StageReport limit = stage.home();
  CHECK(limit.status == Status::limit);
  CHECK(has(limit.detail, "homing: rail 2 ran into its reverse limit"));
  CHECK_FALSE(stage.homed());
  controller.server.forget(kLook);
  controller.server.on("MG _MOA;MG _MOB;MG _MOC", " 0\r\n: 1\r\n: 0\r\n:");
  CHECK(has(stage.home().detail, "a servo does not switch on"));
  CHECK_FALSE(stage.homed());
}

TEST_CASE("stop from another thread stops a stage whose own call does not return",
          "[device][galil]") {
  Homed h;
  h.controller.looks = 1'000'000;
  std::promise<void> moving;
  auto move = std::async(std::launch::async, [&] {
    return h.stage->move(h.target(), [&, n = 0]() mutable {
      if (++n == 2) moving.set_value();
      return Status::ok;
    });
  });
  moving.get_future().wait();
  CHECK(h.stage->stop().ok());
  const StageReport report = move.get();
  CHECK_FALSE(report.ok());
  CHECK(h.controller.server.count("STABC") >= 1);
}

TEST_CASE("a stage that is let go is stopped and its servos are off", "[device][galil]") {
  Homed h;
  h.stage.reset();
  CHECK(h.controller.server.count("STABC") == 1);
  for (const char* servo : {"_MOA", "_MOB", "_MOC"}) CHECK(h.controller.get(servo) == 1);
}
