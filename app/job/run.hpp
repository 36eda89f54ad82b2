#pragma once
// A calibration as a job: read, compute, store, or reuse what is stored.

#include <optional>
#include <string>
#include <vector>

#include "app/job/judged.hpp"
#include "app/job/stages.hpp"
#include "store/campaign.hpp"
#include "store/job.hpp"
#include "store/reading.hpp"

namespace trammel::job {

struct Request {
  std::string campaign;  // name or uuid
  std::string stage = {};
  Json parameters = Json::object();  // those that differ from the stage's defaults
  std::vector<std::string> sessions =
      {};                       // empty: every session without compensation (the baseline)
  bool force = false;           // compute and store again although the key is known
  bool dry_run = false;         // compute and store nothing: the outcome's job has id 0
  bool despite_screen = false;  // calibrate although the screen finds something gross
};

struct Outcome {
  store::Job job;
  bool reused = false;
};

/// Runs a stage on stored readings (excluded ones left out) and stores the job; or returns the
/// stored job of the same key. The inputs are hashed before and after: a difference fails the job.
/// In the result the pose error predicted after for each reading (predicted_after, points.hpp);
/// statistics position_mm and attitude_deg of what stands alike (core/judge/seen.hpp): in-sample
/// where the fit was made, held-out elsewhere, and apart from both what is of an epoch no fit has
/// seen. Readings that are wrong for certain (core/measure/bad_readings.hpp) are named, with what
/// the figures are without them; the parameter "without_suspects" leaves them out. Every stage but
/// diagnose refuses what the screen finds gross. Throws NotFoundError (campaign, session, stage),
/// InputError (parameters, readings), StoreError.
Outcome run(store::Connection& connection, const Request& request);

/// The stage was told that all epochs are one set-up.
bool is_one_set_up(const Json& parameters);

/// The campaign as a stored job took it: its sessions, without what it left out.
Campaign trained_on(store::Connection& connection, const store::Job& job);

/// What `run` would store, without storing it.
store::NewJob compute(store::Connection& connection, const Request& request);

/// The job computed again from the readings that it was computed from, with the exclusions that it
/// honoured, whatever was added since. Its key is the stored one unless the stage has another
/// algorithm_version now, or a reading is not what was stored.
store::NewJob recompute(store::Connection& connection, const store::Job& job);

/// The job's key as it is made today, over what the job was computed from: its own, unless a
/// database before version 5 made that.
store::JobKey key_today(store::Connection& connection, const store::Job& job);

/// A job that is not stored yet, and what it was computed from.
struct Computation {
  store::NewJob job;
  store::Sha256 readings_head = {};  // the end of the campaign's chain
  std::size_t n_exclusions = 0;      // of the campaign
};

/// What `run` would store; nothing where a job of its key is stored and the request does not force.
std::optional<Computation> compute_new(store::Connection& connection, const Request& request);

/// The campaign has the readings and exclusions that the job was computed from. What is stored
/// stays as it is: more of it is the only change there can be.
bool still_holds(store::Connection& connection, const Computation& computation);

/// What `run` would compute from, on the readings as they are now: the key and all inputs; no
/// result.
store::NewJob inputs_of(store::Connection& connection, const Request& request,
                        int key_scheme = store::kKeyScheme);

/// The campaign of a stored job, or of one that `compute` gave.
store::CampaignRow campaign_of(store::Connection& connection, const store::NewJob& job);

/// Two stored results are the same bit for bit, times that were taken aside.
bool same_result(const std::string& a, const std::string& b);

/// The correction that a stored job found.
Correction correction_of(store::Connection& connection, store::Id job_id);

/// The request that gives this job again: same stage, parameters, and sessions by name.
Request request_of(store::Connection& connection, const store::Job& job);

/// The job of this number, or the newest whose key begins with these six or more digits.
/// Throws NotFoundError.
store::Job find(store::Connection& connection, const std::string& text);

}  // namespace trammel::job
