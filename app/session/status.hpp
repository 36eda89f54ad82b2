#pragma once
// How a session is doing, read from the database by whoever looks: the runner does not notice.

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/session/base_check.hpp"
#include "core/mechanism/machine.hpp"
#include "store/campaign.hpp"

namespace trammel::session {

/// Everything that a terminal or a page shows of one session.
struct SessionStatus {
  std::string campaign;
  bool simulated = false;  // to be shown large
  std::string session;
  std::string plan;
  std::string state;   // running, paused, done, stopped, faulted, interrupted
  std::string detail;  // why it is paused, stopped or faulted; else empty: events grow old
  std::optional<int> process = {};  // that measures the campaign now
  bool compensated = false;
  int n_points = 0;
  int n_ok = 0;
  int epoch = 0;  // the last one; 0: not homed yet
  std::string now_utc;
  std::string started_utc;                       // of the first event
  std::string last_utc;                          // anything that was stored last
  double silent_s = 0;                           // since then
  std::optional<double> seconds_per_point = {};  // median of the last points
  std::optional<double> left_s = {};             // running or paused only

  /// A running session that has stored nothing for longer than `stall_after_s`.
  bool stalled = false;
  double stall_after_s = 0;

  /// Of the coordinates, those below: the rest of a deviation and of a drift is 0, and is not
  /// shown.
  Coordinates measured = {true, true, true};

  struct Deviation {  // measured minus target
    int point = 0;
    Eigen::Vector3d off = Eigen::Vector3d::Zero();  // mm, mm, rad
  };
  std::vector<Deviation> last = {};  // up to kLast, oldest first

  std::map<std::string, int> retries = {};  // failed attempts by class: "beam broken": 2
  int n_interrupted = 0;

  struct Drift {  // of a reference point, against its first reading
    int point = 0;
    int epoch = 0;
    std::string at_utc;
    Eigen::Vector3d off = Eigen::Vector3d::Zero();  // mm, mm, rad
  };
  std::vector<Drift> drift = {};  // in the order they were measured

  struct Base {  // the tracker's base nests, against where they were registered
    std::string at_utc;
    BaseCheck check;
  };
  std::vector<Base> base = {};

  static constexpr std::size_t kLast = 20;
};

/// `process`: who holds the campaign's lock (lock.hpp); `now_utc`: empty for now. Throws
/// NotFoundError for a session that is not there. What of its rows is no time, or no look at base
/// nests, is left out: no row hides the others.
SessionStatus status_of(store::Connection& connection, const store::CampaignRow& campaign,
                        const std::string& session, std::optional<int> process,
                        const std::string& now_utc = {});

/// The session that is looked at where none is named: the one with the latest event, reference
/// points apart. None: no runner has walked one.
std::optional<std::string> current_session(store::Connection& connection,
                                           const store::CampaignRow& campaign);

/// The fields of SessionStatus under their names, without "schema".
nlohmann::ordered_json status_json(const SessionStatus& status);

/// A screenful for a terminal, lines ended by \n; nothing of a file or device in it that a terminal
/// would act on. `width` in characters.
std::string status_text(const SessionStatus& status, int width = 80);

}  // namespace trammel::session
