#pragma once
// The real recorder, measured by what it acknowledged: a session on the paper's virtual robot. And
// a careless one, the control.

#include <filesystem>
#include <functional>

#include "app/session/session.hpp"
#include "store/open.hpp"

namespace trammel::test {

struct Recording {
  int acknowledged = 0;    // points of which the runner has said that they are stored
  bool reported = false;   // an error came out
  std::string error = {};  // what it said
  ExitCode code = ExitCode::ok;
  session::State state = session::State::planned;
};

/// A plan of `n` points of the paper's 80.
Plan plan_of_points(int n);

/// Opens (and makes) the database, runs or resumes session "s" of campaign "c" over a plan of
/// `n_points`, closes it. `at_question` is called whenever the runner asks whether to go on, with
/// the points acknowledged so far; `opened` once the database is open.
Recording record(const std::filesystem::path& file, int n_points,
                 const std::function<void(int)>& at_question = {},
                 const std::function<void(store::Connection&)>& opened = {});

struct Found {
  bool opens = false;     // for writing, log recovered
  bool verifies = false;  // every digest and count
  int n_points = 0;       // stored as ok, from the plan's beginning; with those kept aside
  std::string problem = {};
};

/// What stands in a database after whatever happened to it.
Found look_at(const std::filesystem::path& file);

/// Who records, and how what was recorded is looked at.
struct Recorder {
  std::function<Recording(const std::filesystem::path& file, int n_points,
                          const std::function<void(int)>& at_question)>
      record;
  std::function<Found(const std::filesystem::path& file)> look;
};

/// record() and look_at().
Recorder real_recorder();

/// The control that must lose: a bare loop of INSERTs that never looks at what SQLite answers, and
/// acknowledges each.
Recorder careless_recorder();

}  // namespace trammel::test
