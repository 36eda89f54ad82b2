#include "app/archive/work.hpp"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <vector>

#include "app/archive/pull.hpp"
#include "app/files/temporary_folder.hpp"
#include "app/job/diff.hpp"
#include "app/job/rerun_all.hpp"
#include "store/canonical.hpp"
#include "store/open.hpp"

namespace trammel::archive {

namespace {

using std::chrono::steady_clock;
constexpr std::chrono::milliseconds kLook{500};  // between looks into an empty queue
constexpr std::chrono::minutes kPatience{10};    // with an archive that went away

std::string hex_text(store::Bytes bytes) { return "\\x" + store::hex(bytes); }
std::string hex_text(const std::string& bytes) {
  return hex_text(store::Bytes(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

std::optional<Claim> claim_next(Link& link, const WorkOptions& options) {
  const auto rows = link.ask(
      "SELECT id, token, stage, campaign, station, parameters_json, force "
      "FROM trammel.claim($1, $2, $3)",
      {options.station, options.machine, std::to_string(options.lease_s)});
  if (rows.empty()) return std::nullopt;
  const Link::Row& row = rows[0];
  return Claim{.id = text_of(row, 0),
               .token = text_of(row, 1),
               .stage = text_of(row, 2),
               .campaign = text_of(row, 3),
               .station = text_of(row, 4),
               .parameters_json = row.at(5),
               .force = text_of(row, 6) == "t"};
}

/// The job, computed or known, and the row it is stored as.
struct Found {
  job::Outcome outcome;
  std::optional<store::CanonicalRow> row = {};
};

Found compute(Link& link, const Claim& claim) {
  const TemporaryFolder scratch;
  const auto file = scratch.path() / "scratch.db";
  pull(link, {.station = claim.station, .campaign = claim.campaign, .with_results = !claim.force},
       file);
  store::Connection db = store::open(file, store::Access::write);
  const job::Json parameters =
      claim.parameters_json ? job::Json::parse(*claim.parameters_json) : job::Json(nullptr);
  Found found{.outcome = job::run(db, job::rerun_request(db, claim.campaign, claim.stage,
                                                         parameters, claim.force))};
  if (!found.outcome.reused) {
    const auto& tables = store::sealed_tables();
    const auto sealed = std::ranges::find(tables, "job", &store::Sealed::table);
    found.row = store::canonical_row(db, *sealed, found.outcome.job.id);
  }
  return found;
}

/// Whether the work was still ours.
bool finish(Link& link, const Claim& claim, const Found& found, const WorkOptions& options) {
  const std::string key = found.outcome.job.data.key.key;
  if (!found.row) {
    return link.ask("SELECT trammel.finish($1, $2, $3, $4, $5, NULL, NULL, NULL, NULL, NULL)",
                    {claim.id, claim.token, options.station, options.machine, key})
               .at(0)
               .at(0) == "t";
  }
  const store::CanonicalRow& row = *found.row;
  return link.ask("SELECT trammel.finish($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)",
                  {claim.id, claim.token, options.station, options.machine, key,
                   hex_text(store::sha256_of(job::outcome_text(found.outcome.job.data))),
                   hex_text(row.key), fmt::format("{{{}}}", fmt::join(row.n_rows, ",")),
                   hex_text(row.bytes), hex_text(store::sha256_of(row.bytes))})
             .at(0)
             .at(0) == "t";
}

class Worker {
 public:
  explicit Worker(const WorkOptions& options)
      : options_(options), heart_(options.connect, options.lease_s) {}

  WorkDone run() {
    std::vector<std::jthread> threads;
    running_ = options_.jobs;
    for (unsigned k = 0; k < options_.jobs; ++k) {
      threads.emplace_back([this] {
        try {
          work_on();
        } catch (...) {
          const std::scoped_lock lock(mutex_);
          broken_ = std::current_exception();
          ended_ = true;
        }
        --running_;
      });
    }
    while (running_ > 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      if (!options_.abandon()) continue;
      heart_.release_all();
      done_.abandoned = true;
      for (auto& thread : threads) thread.detach();  // they compute: the process ends without them
      return done_;
    }
    threads.clear();
    if (broken_) std::rethrow_exception(broken_);
    return done_;
  }

 private:
  [[nodiscard]] bool ends() const { return ended_ || options_.stop(); }

  void work_on() {
    std::unique_ptr<Link> link;
    auto heard = steady_clock::now();
    while (!ends()) {
      try {
        if (!link) link = options_.connect();
        const bool any = one(*link);
        heard = steady_clock::now();
        if (any) continue;
        if (options_.until_empty && nothing_open(*link)) return;
        std::this_thread::sleep_for(kLook);
      } catch (const DeviceError& error) {
        link.reset();
        if (steady_clock::now() - heard > kPatience) throw;
        say("the archive is gone, trying again: " + error.text().got);
        std::this_thread::sleep_for(kLook);
      }
    }
  }

  static bool nothing_open(Link& link) {
    return link.ask("SELECT 1 FROM trammel.work WHERE state IN ('waiting', 'claimed') LIMIT 1")
        .empty();
  }

  /// False: there is nothing to do.
  bool one(Link& link) {
    const auto claim = claim_next(link, options_);
    if (!claim) return false;
    heart_.add(*claim);
    const std::unique_ptr<const Claim, std::function<void(const Claim*)>> beating(
        &*claim, [this](const Claim* held) { heart_.remove(*held); });
    const auto began = steady_clock::now();
    std::string failure;
    try {
      const Found found = compute(link, *claim);
      const bool mine = finish(link, *claim, found, options_);
      const std::scoped_lock lock(mutex_);
      ++(!mine ? done_.late : found.outcome.reused ? done_.known : done_.computed);
      options_.say(fmt::format("{} of {}: {} in {:.2f} s", claim->stage, claim->campaign,
                               !mine                  ? "too late, dropped"
                               : found.outcome.reused ? "known"
                                                      : "stored",
                               std::chrono::duration<double>(steady_clock::now() - began).count()));
      return true;
    } catch (const Error& error) {
      failure = describe(error.text());
    } catch (const std::exception& error) {
      failure = error.what();
    }
    // Where the connection is gone this fails, too, and the lease ends by itself.
    link.ask("SELECT trammel.give_back($1, $2, $3)", {claim->id, claim->token, failure});
    const std::scoped_lock lock(mutex_);
    ++done_.failed;
    options_.say(fmt::format("{} of {} failed: {}", claim->stage, claim->campaign, failure));
    return true;
  }

  void say(const std::string& line) {
    const std::scoped_lock lock(mutex_);
    options_.say(line);
  }

  const WorkOptions& options_;
  Heart heart_;
  std::mutex mutex_;
  WorkDone done_;
  std::exception_ptr broken_;
  std::atomic<bool> ended_ = false;
  std::atomic<unsigned> running_ = 0;
};

}  // namespace

WorkDone work(const WorkOptions& options) { return Worker(options).run(); }

}  // namespace trammel::archive
