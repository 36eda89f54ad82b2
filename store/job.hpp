#pragma once
// Versioned computations with their inputs, results and statistics. Written once, whole.

#include <vector>

#include "core/mechanism/pose.hpp"
#include "store/job_key.hpp"
#include "store/provenance.hpp"
#include "store/statement.hpp"

namespace trammel::store {

struct Summary {
  double mean = 0;
  double max = 0;
  double min = 0;
  double p95 = 0;
  int n = 0;
};

/// One figure of a job. The unit ends the metric's name: position_mm, attitude_deg.
struct Statistic {
  std::string set;  // "identify", "validate", or a name of the job's own
  std::string metric;
  bool in_sample = false;  // judged on the readings it was fitted to
  std::optional<Summary> before = {};
  std::optional<Summary> after = {};
};

/// Pose error of one reading that is predicted after the correction.
struct JobPoint {
  int seq = 0;
  bool in_sample = false;
  Pose after = {};
};

struct NewJob {
  Id campaign_id = 0;
  JobKey key = {};
  std::string stage;
  int algorithm_version = 1;
  std::string parameters_json = "{}";
  std::string model_json = "{}";
  std::string result_json = "{}";  // canonical (job_key.hpp): it is large, and stored as it is
  int n_readings = 0;
  std::vector<Id> sessions = {};
  std::vector<Id> exclusions = {};  // honoured
  std::vector<Id> parents = {};
  std::vector<Statistic> statistics = {};
  double duration_s = 0;
};

struct Job {
  Id id = 0;
  int run = 1;  // of its key in the campaign; more than one where forced
  std::string created_utc;
  Provenance provenance;
  NewJob data;
};

/// Stores a job with all its parts in one transaction, sealed; nothing of it changes later. Under a
/// key that is stored the next run is added: ask find_job first.
/// @throws StoreError  a number that is not finite
Id add_job(Connection& connection, const NewJob& job);

/// The campaign's newest run with this key.
std::optional<Job> find_job(Connection& connection, Id campaign_id, std::string_view key);
bool has_job(Connection& connection, Id campaign_id, std::string_view key);
/// The campaign's newest job of this stage.
std::optional<Id> newest_job(Connection& connection, Id campaign_id, std::string_view stage);
/// @throws NotFoundError
Job get_job(Connection& connection, Id job_id);

/// Points of a job that was stored before version 4 of the schema: later ones have them in the
/// result (app/job/points.hpp).
std::vector<JobPoint> stored_points(Connection& connection, Id job_id);

struct JobRow {
  Id id = 0;
  Id campaign_id = 0;
  std::string campaign;
  std::string key;
  int run = 1;
  std::string stage;
  int algorithm_version = 1;
  int n_readings = 0;
  std::string created_utc;
  double duration_s = 0;
};
/// Of one campaign, or all.
std::vector<JobRow> list_jobs(Connection& connection, std::optional<Id> campaign_id = {});

}  // namespace trammel::store
