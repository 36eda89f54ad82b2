#pragma once
// The heartbeats of a worker: what it has claimed stays its own while it computes.

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "app/archive/link.hpp"

namespace trammel::archive {

using Connect = std::function<std::unique_ptr<Link>()>;

/// A claim of work, as trammel.work has it.
struct Claim {
  std::string id, token;
  std::string stage, campaign, station;  // the campaign's uuid and its station
  std::optional<std::string> parameters_json = {};
  bool force = false;
};

/// A thread with connections of its own, which renews every claim each third of the lease. Where
/// the archive can't be reached it goes on trying; what is no longer ours is found at `finish`.
/// Proof: fleet_test.cpp (a server that dies under a worker).
class Heart {
 public:
  Heart(Connect connect, double lease_s);
  void add(const Claim& claim);
  void remove(const Claim& claim);
  /// Gives back all that is claimed, without counting the attempt: the worker stops now.
  void release_all();

 private:
  void beat(const std::stop_token& ended);
  void for_each_claim(const std::function<void(Link& link, const Claim& claim)>& what);
  Connect connect_;
  double lease_s_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::map<std::string, Claim> claims_;  // by token
  std::jthread thread_;                  // last: it uses all above
};

}  // namespace trammel::archive
