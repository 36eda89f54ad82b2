#include "app/job/rerun_all.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "store/open.hpp"
#include "store/query.hpp"
#include "store/transaction.hpp"

namespace trammel::job {

namespace {

constexpr std::size_t kBatch = 32;     // jobs a commit at least: more where commits are slow
constexpr std::size_t kWaiting = 512;  // found and not yet stored: threads wait beyond

/// What a thread has found about a campaign: a job, or that one is known, or why there is none.
struct Found {
  std::string campaign;
  std::optional<Computation> job = {};
  std::string failure = {};
};

/// Jobs on their way from the threads that compute to the one that writes.
class Belt {
 public:
  explicit Belt(unsigned producers) : producers_(producers) {}

  /// False when nobody takes any more.
  bool put(Found found) {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [this] { return waiting_.size() < kWaiting || closed_; });
    if (closed_) return false;
    waiting_.push_back(std::move(found));
    if (waiting_.size() >= kBatch) some_.notify_one();
    return true;
  }
  void producer_ends() {
    const std::scoped_lock lock(mutex_);
    --producers_;
    some_.notify_one();
  }
  /// All that waits, once it is a batch or nobody adds to it; empty: there is no more.
  std::deque<Found> take() {
    std::unique_lock lock(mutex_);
    some_.wait(lock, [this] { return waiting_.size() >= kBatch || producers_ == 0; });
    room_.notify_all();
    return std::exchange(waiting_, {});
  }
  void close() {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
    room_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable some_, room_;
  std::deque<Found> waiting_;
  unsigned producers_;
  bool closed_ = false;
};

/// Threads that compute give way to the one that writes (Linux gives each a priority of its own):
/// what they find is stored as they go, not when they are done.
void give_way() {
#ifdef __linux__
  constexpr int kNicer = 10;
  const auto thread = static_cast<id_t>(gettid());
  setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + kNicer);
#endif
}

struct Chosen {
  store::Id id = 0;
  std::string name;
};

/// The condition is a stranger's SQL: it is asked through a connection that can only read.
std::vector<Chosen> chosen_campaigns(const std::filesystem::path& file, const std::string& where) {
  constexpr std::chrono::seconds kLimit{30};
  store::Connection reader = store::open(file, store::Access::read_only);
  store::Query query(
      reader, "SELECT campaign_id, name FROM campaign WHERE (" + where + "\n) ORDER BY campaign_id",
      kLimit);
  std::vector<Chosen> all;
  while (const auto row = query.next()) {
    all.push_back({std::get<std::int64_t>(row->at(0)), std::get<std::string>(row->at(1))});
  }
  return all;
}

Found find(store::Connection& connection, const Sweep& sweep, const Chosen& campaign) {
  Found found{.campaign = campaign.name};
  try {
    found.job = compute_new(connection, rerun_request(connection, campaign.name, sweep.stage,
                                                      sweep.parameters, sweep.force));
  } catch (const StoreError&) {
    throw;
  } catch (const Error& error) {
    found.failure = describe(error.text());
  }
  return found;
}

/// Stores a batch in one transaction; what changed under a job fails it. While nobody else has
/// written since `version` nothing can have changed.
void store_batch(store::Connection& connection, const std::deque<Found>& batch, bool dry_run,
                 std::int64_t version, SweepResult& result) {
  std::optional<store::Transaction> transaction;
  if (!dry_run) transaction.emplace(connection);
  const bool unchanged = dry_run || store::data_version(connection) == version;
  int computed = 0, reused = 0;
  for (const Found& found : batch) {
    if (!found.failure.empty()) {
      result.failed.push_back({found.campaign, found.failure});
    } else if (!found.job) {
      ++reused;
    } else if (!unchanged && !still_holds(connection, *found.job)) {
      result.failed.push_back({found.campaign, "the readings changed while they were calibrated"});
    } else {
      if (!dry_run) store::add_job(connection, found.job->job);
      ++computed;
    }
  }
  if (transaction) transaction->commit();
  result.computed += computed;
  result.reused += reused;
}

}  // namespace

Request rerun_request(store::Connection& connection, const std::string& campaign,
                      const std::string& stage, const Json& parameters, bool force) {
  Request request{.campaign = campaign, .stage = stage, .force = force};
  const store::Id campaign_id = store::require_campaign_id(connection, campaign);
  if (const auto id = store::newest_job(connection, campaign_id, stage)) {
    const Request earlier = request_of(connection, store::get_job(connection, *id));
    request.parameters = earlier.parameters;
    request.sessions = earlier.sessions;
  }
  if (!parameters.is_null()) request.parameters = parameters;
  return request;
}

SweepResult rerun_all(store::Connection& connection, const Sweep& sweep) {
  const Stage& stage = find_stage(sweep.stage);
  if (!sweep.parameters.is_null()) static_cast<void>(completed(stage, sweep.parameters));
  const std::int64_t version = store::data_version(connection);
  const std::vector<Chosen> campaigns = chosen_campaigns(connection.file(), sweep.where);
  SweepResult result{.campaigns = static_cast<int>(campaigns.size()), .failed = {}};
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const unsigned n_threads = sweep.threads > 0 ? sweep.threads : cores;

  Belt belt(n_threads);
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stop{false};
  std::exception_ptr broken;
  std::mutex broken_mutex;
  const auto produce = [&] {
    give_way();
    try {
      store::Connection reader = store::open(connection.file(), store::Access::read_only);
      for (std::size_t k = next++; k < campaigns.size() && !stop; k = next++) {
        if (!belt.put(find(reader, sweep, campaigns[k]))) break;
      }
    } catch (...) {
      const std::scoped_lock lock(broken_mutex);
      broken = std::current_exception();
      stop = true;
    }
    belt.producer_ends();
  };
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < n_threads; ++t) threads.emplace_back(produce);
  try {
    for (auto batch = belt.take(); !batch.empty(); batch = belt.take()) {
      store_batch(connection, batch, sweep.dry_run, version, result);
      sweep.progress(result.computed + result.reused + static_cast<int>(result.failed.size()),
                     result.campaigns);
      if (!result.stopped && sweep.stop()) result.stopped = stop = true;
    }
  } catch (...) {
    stop = true;
    belt.close();
    throw;  // the threads end with `threads`
  }
  threads.clear();
  if (broken) std::rethrow_exception(broken);
  return result;
}

}  // namespace trammel::job
