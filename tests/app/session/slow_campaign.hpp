#pragma once
// A campaign over sockets in the time of the wall, and what the stage's wire and rails say of a
// stop.

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "app/files/plan_json.hpp"
#include "tests/app/session/socket_campaign.hpp"
#include "tests/support/paths.hpp"

namespace trammel::tests {

/// Rails that need 0.2 s for each mm to their home switches; a tracker whose link stalls on
/// command.
class SlowCampaign : public SocketCampaign {
 public:
  using Clock = std::chrono::steady_clock;
  std::atomic<int> signals = 0;
  std::atomic<bool> stalls = false;        // the tracker's link
  std::atomic<bool> stage_stalls = false;  // the stage's

  explicit SlowCampaign(double start_mm, double watch_host_s = 0,
                        const simulate::Truth& truth = emulated_truth())
      : SocketCampaign(two_points(truth.nominal), options(start_mm, watch_host_s, truth)) {
    around.stop_signals = [this] { return signals.load(); };
    lab.to_tracker.late_s = [this](std::string_view) { return stalls ? 2.0 : 0.0; };
    lab.to_stage.late_s = [this](std::string_view) { return stage_stalls ? 2.0 : 0.0; };
  }
  static Plan two_points(const Machine& machine) {
    Plan plan = plan_on(machine, small_plan());
    plan.points.resize(2);
    return plan;
  }
  static SocketOptions options(double start_mm, double watch_host_s, const simulate::Truth& truth) {
    SocketOptions options;
    options.truth = truth;
    options.watch_host_s = watch_host_s;
    options.step_s = 0;  // the world's own time
    options.reply_timeout_s = 5;
    for (emulate::RailSetup& rail : options.rails) rail.start_mm = start_mm;
    return options;
  }

  [[nodiscard]] std::string file() const { return (folder.path() / "p.db").string(); }

  /// The real program on these devices, without a standard stream, once its rails move to their
  /// switches.
  [[nodiscard]] pid_t program_homes() const {
    std::vector<std::string> words = {
        build_folder() + "/trammel",
        "session",
        "run",
        "c",
        "--db",
        file(),
        "--session",
        "s",
        "--plan",
        folder.write("plan.json", plan_json(request.plan).dump()).string(),
        "--plan-check",
        request.plan_check,
        "--stage",
        request.stage,
        "--tracker",
        request.tracker};
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const pid_t child = ::fork();
    if (child == 0) {
      ::close(STDOUT_FILENO);  // closed streams are nothing to die of
      ::close(STDERR_FILENO);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    await(begins());
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    return child;
  }

  /// The line with which all drives begin.
  [[nodiscard]] std::string begins() const {
    const int n = lab.robot.robot().truth().nominal.kind->n_chains;
    return "BG" + std::string("ABC").substr(0, static_cast<std::size_t>(n));
  }
  /// Waits for the n-th line that begins so.
  void await(std::string_view line, int n = 1) const {
    const auto patience = Clock::now() + std::chrono::seconds(30);
    while (lab.log.count(line) < n && Clock::now() < patience) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  /// Seconds from `wish` to the next ST or AB; a minute where there is none.
  [[nodiscard]] double stop_after_s(Clock::time_point wish) const {
    for (const WireLog::Line& line : lab.log.lines()) {
      if (line.at < wish || line.to != emulate::Emulated::stage) continue;
      if (!line.text.starts_with("ST") && !line.text.starts_with("AB")) continue;
      return std::chrono::duration<double>(line.at - wish).count();
    }
    return 60;
  }
  /// Until the rails rest.
  [[nodiscard]] double rest_after_s(Clock::time_point wish) const {
    while (lab.robot.standing().moving) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return std::chrono::duration<double>(Clock::now() - wish).count();
  }
};

}  // namespace trammel::tests
