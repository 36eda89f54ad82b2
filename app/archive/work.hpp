#pragma once
// A worker: claims queued calibrations, computes them as a station would, stores what it found.

#include <functional>

#include "app/archive/heart.hpp"

namespace trammel::archive {

struct WorkOptions {
  std::string station;  // the worker's uuid
  std::string machine;
  unsigned jobs = 1;         // computed at once
  bool until_empty = false;  // end when nothing waits and nothing is claimed
  double lease_s = 60;
  Connect connect = {};
  std::function<bool()> stop = [] { return false; };     // asked between two works
  std::function<bool()> abandon = [] { return false; };  // give back what is claimed, and end
  std::function<void(const std::string& line)> say = [](const std::string&) {};
};

struct WorkDone {
  int computed = 0;  // and stored
  int known = 0;     // the archive has the job: nothing to compute
  int failed = 0;    // attempts, each given back with its reason
  int late = 0;      // finished after the lease had gone to another worker: dropped
  bool abandoned = false;
};

/// Each work: claim (one statement), pull the campaign into a scratch database, job::run there,
/// finish with the token: the result and the end of the work are one transaction. No transaction is
/// open while it computes. An archive that goes away is waited for, ten minutes at most.
/// @throws DeviceError  it did not come back; StoreError: it refuses this role
/// Proof: work_test.cpp
WorkDone work(const WorkOptions& options);

}  // namespace trammel::archive
