#include "tests/stress/recorder.hpp"

#include <sqlite3.h>

#include <algorithm>

#include "app/session/side_file.hpp"
#include "core/plan/build.hpp"
#include "core/plan/grids.hpp"
#include "store/campaign.hpp"
#include "store/verify.hpp"
#include "tests/support/paths.hpp"

namespace trammel::test {

Plan plan_of_points(int n) {
  std::vector<Pose> targets = paper_80();
  targets.resize(static_cast<std::size_t>(n));
  return build_plan({.name = "stress", .groups = {{"", targets}}});
}

Recording record(const std::filesystem::path& file, int n_points,
                 const std::function<void(int)>& at_question,
                 const std::function<void(store::Connection&)>& opened) {
  Recording recording;
  session::Request request;
  request.campaign = "c";
  request.session = "s";
  request.plan = plan_of_points(n_points);
  request.stage = "sim:" + tests::source_folder() + "/examples/paper/robot.json";
  session::Surroundings around;
  int stored = 0;
  around.stored = [&stored](int n) { stored = n; };
  around.stop_signals = [&] {
    recording.acknowledged = stored;
    if (at_question) at_question(stored);
    return 0;
  };
  try {
    store::Connection db = store::open(file, store::Access::create);
    if (opened) opened(db);
    const session::Outcome outcome = session::run_or_resume(db, request, around);
    recording.state = outcome.state;
    recording.acknowledged = outcome.n_stored;
    recording.reported = outcome.state != session::State::done;
    recording.error = outcome.detail;
    recording.code = outcome.exit_code();
    if (at_question) at_question(recording.acknowledged);
  } catch (const Error& error) {
    recording.acknowledged = stored;
    recording.reported = true;
    recording.error = error.what();
    recording.code = error.code();
  }
  return recording;
}

Found look_at(const std::filesystem::path& file) {
  Found found;
  try {
    store::Connection db = store::open(file, store::Access::create);
    found.opens = true;
    const store::CheckReport report = store::verify(db);
    found.verifies = report.ok();
    if (!report.ok()) found.problem = report.findings.front();
    const auto campaign = store::find_campaign(db, "c");
    const auto session = campaign ? store::find_session(db, campaign->id, "s") : std::nullopt;
    if (!session) return found;
    session::recover(db, *campaign);  // a line that is torn is none
    std::vector<int> seqs;
    for (const store::Attempt& a : store::attempts(db, session->id)) {
      if (a.status == "ok") seqs.push_back(a.point_seq);
    }
    std::ranges::sort(seqs);
    while (static_cast<std::size_t>(found.n_points) < seqs.size() &&
           seqs[static_cast<std::size_t>(found.n_points)] == found.n_points + 1) {
      ++found.n_points;
    }
  } catch (const std::exception& error) {
    found.problem = error.what();
  }
  return found;
}

Recorder real_recorder() {
  return {[](const auto& file, int n, const auto& at) { return record(file, n, at); }, look_at};
}

namespace {

int rows_in(sqlite3* db) {
  int n = 0;
  const auto take = [](void* to, int, char** values, char**) {
    *static_cast<int*>(to) = std::stoi(values[0]);
    return 0;
  };
  sqlite3_exec(db, "SELECT count(*) FROM point", take, &n, nullptr);
  return n;
}

}  // namespace

Recorder careless_recorder() {
  const auto record = [](const std::filesystem::path& file, int n,
                         const std::function<void(int)>& at_question) {
    Recording recording{.state = session::State::done};
    sqlite3* db = nullptr;
    sqlite3_open(file.c_str(), &db);
    sqlite3_exec(db, "PRAGMA journal_mode = WAL", nullptr, nullptr, nullptr);
    sqlite3_exec(db, "CREATE TABLE IF NOT EXISTS point (id INTEGER)", nullptr, nullptr, nullptr);
    for (int k = rows_in(db) + 1; k <= n; ++k) {
      sqlite3_exec(db, ("INSERT INTO point VALUES (" + std::to_string(k) + ")").c_str(), nullptr,
                   nullptr, nullptr);
      recording.acknowledged = k;
      if (at_question) at_question(k);
    }
    sqlite3_close(db);
    return recording;
  };
  const auto look = [](const std::filesystem::path& file) {
    sqlite3* db = nullptr;
    Found found{.opens = sqlite3_open(file.c_str(), &db) == SQLITE_OK, .verifies = true};
    found.n_points = rows_in(db);
    sqlite3_close(db);
    return found;
  };
  return {record, look};
}

}  // namespace trammel::test
