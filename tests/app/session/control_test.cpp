// The real program, told by other processes of it what to do.

#include <chrono>
#include <future>
#include <thread>

#include "app/files/plan_json.hpp"
#include "app/session/status.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"

namespace trammel::session {

using namespace tests;

namespace {

using Words = std::vector<std::string>;

/// A long session of the real program, and questions to it from others.
struct Measured {
  TemporaryFolder folder;
  std::string file = (folder.path() / "t.db").string();
  std::string plan;
  std::future<Finished> program;

  Measured() {
    PlanRequest request{.name = "long", .groups = {{"", paper_80()}}};
    request.repeats = 100;
    plan = folder.write("plan.json", plan_json(build_plan(request)).dump()).string();
    program = start(
        {"session", "run", "c", "--plan", plan, "--session", "s", "--stage", "sim:" + kPaperRobot});
  }
  ~Measured() {
    if (program.valid()) static_cast<void>(ask({"session", "stop", "c", "--now"}));
  }
  [[nodiscard]] std::future<Finished> start(Words words) const {
    words.insert(words.end(), {"--db", file});
    return std::async(std::launch::async,
                      [words, this] { return run_program(words, folder.path()); });
  }
  [[nodiscard]] Finished ask(Words words) const {
    words.insert(words.end(), {"--db", file});
    return run_program(words, folder.path());
  }
  /// Waits for what the status must say.
  bool comes(const std::function<bool(const nlohmann::json&)>& what) const {
    for (int tries = 0; tries < 2000; ++tries) {
      const Finished answer = ask({"session", "status", "c", "--session", "s", "--json"});
      if (answer.exit_code == 0 && what(nlohmann::json::parse(answer.out).at("status")))
        return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
};

}  // namespace

TEST_CASE("another terminal pauses a session, resumes it in a new epoch, watches and stops it",
          "[session]") {
  Measured measured;
  REQUIRE(measured.comes([](const auto& s) { return s.at("n_ok") > 3; }));
  const Finished paused = measured.ask({"session", "pause", "c", "--json"});
  INFO(paused.err);
  REQUIRE(paused.exit_code == 0);
  REQUIRE(measured.comes([](const auto& s) { return s.at("state") == "paused"; }));
  const auto points = [&measured] {
    store::Connection db = store::open(measured.file, store::Access::read_only);
    return store::find_session(db, store::require_campaign(db, "c").id, "s")->n_ok;
  };
  CHECK_THAT(measured.ask({"session", "status", "c"}).err,
             Contains("next: trammel session resume c"));
  const int while_paused = points();
  CHECK(points() == while_paused);
  CHECK(measured.ask({"session", "resume", "c", "--session", "s"}).exit_code == 0);
  REQUIRE(measured.comes([&](const auto& s) {
    return s.at("state") == "running" && s.at("n_ok") > while_paused && s.at("epoch") == 2;
  }));
  auto watching = measured.start({"session", "status", "c", "--watch", "--interval", "0.05"});
  const Finished stopped = measured.ask({"session", "stop", "c"});
  CHECK(stopped.exit_code == 0);
  const Finished ended = measured.program.get();
  CHECK(ended.exit_code == 130);
  const Finished watched = watching.get();  // ends with the session
  CHECK(watched.exit_code == 0);
  CHECK_THAT(watched.out, Contains("SIMULATED") && Contains("c / s: "));
  CHECK(watched.out.find('\x1b') == std::string::npos);
  store::Connection db = store::open(measured.file, store::Access::read_only);
  const auto session = store::find_session(db, store::require_campaign(db, "c").id, "s");
  CHECK(session->last_event == "stopped");
  CHECK(session->n_ok < session->n_points);
  for (const auto& a : store::attempts(db, session->id)) CHECK(a.status == "ok");
  CHECK(measured.ask({"session", "pause", "c"}).exit_code == 3);  // nobody measures any more
}

TEST_CASE("a reader of the status that is killed does not disturb the session", "[session]") {
  Measured measured;
  int before = 0;
  REQUIRE(measured.comes([&](const auto& s) {
    before = s.at("n_ok");
    return before > 3;
  }));
  const Finished killed = run_program(
      {"session", "status", "c", "--watch", "--interval", "0.01", "--db", measured.file},
      measured.folder.path(), 150);
  CHECK(killed.exit_code == -1);
  CHECK(measured.comes([&](const auto& s) { return s.at("n_ok") > before; }));
  CHECK(measured.ask({"session", "stop", "c", "--now"}).exit_code == 0);
  const Finished ended = measured.program.get();
  CHECK(ended.exit_code == 130);
  CHECK(measured.ask({"session", "recover", "c"}).exit_code == 0);
}

}  // namespace trammel::session
