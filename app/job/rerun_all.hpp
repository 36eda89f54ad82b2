#pragma once
// One calibration of a whole archive: computed side by side, stored in batches.

#include <functional>

#include "app/job/run.hpp"

namespace trammel::job {

struct Sweep {
  std::string stage;
  std::string where = "1";    // SQL condition on the columns of `campaign`
  Json parameters = nullptr;  // of every campaign; null: each as in its newest job of the stage
  bool force = false;
  bool dry_run = false;                               // compute all, store nothing
  unsigned threads = 0;                               // that compute; 0: as many as the machine has
  std::function<bool()> stop = [] { return false; };  // asked before each campaign
  std::function<void(int done, int total)> progress = [](int, int) {};
};

struct SweepFailure {
  std::string campaign;
  std::string text;
};

struct SweepResult {
  int campaigns = 0;  // that the condition names
  int computed = 0;   // and stored, unless a dry run
  int reused = 0;     // the stored job of the same key stands
  bool stopped = false;
  std::vector<SweepFailure> failed;
};

/// What a rerun of a campaign (by name or uuid) asks: the sessions and, where none are given
/// (null), the parameters of its newest job of the stage; else the baseline and the stage's
/// defaults.
Request rerun_request(store::Connection& connection, const std::string& campaign,
                      const std::string& stage, const Json& parameters, bool force);

/// Runs a stage on each campaign that `where` names, with the parameters and sessions of its newest
/// job of that stage (else the stage's defaults and the baseline). Each thread reads through a
/// connection of its own; the caller's writes what they have found, some dozens of jobs a commit.
/// Killed or stopped, all of a batch or nothing of it is stored, and the next sweep goes on after
/// it: what is stored has a known key. A campaign that gained readings or exclusions since it was
/// read fails, and so does one that the stage refuses; the others go on.
/// Throws NotFoundError (stage), InputError (parameters, condition), StoreError.
/// Proof: threads and batches give the jobs that `run` gives, bit for bit (rerun_all_test.cpp).
SweepResult rerun_all(store::Connection& connection, const Sweep& sweep);

}  // namespace trammel::job
