#pragma once
// What makes two computations the same.

#include <map>
#include <vector>

#include "core/measure/reading.hpp"

namespace trammel::store {

struct JobKeyInput {
  std::string stage;          // "lsq", "idw", …
  int algorithm_version = 1;  // bumped by hand when results change
  std::string parameters_json = "{}";
  std::string model_json = "{}";  // the model a job starts from, beside the mechanism
  const Campaign& campaign;       // mechanism, tracker and ordered readings, less the excluded ones
  std::vector<int> excluded_seqs = {};
  std::vector<std::string> parent_keys = {};
};

struct JobKey {
  std::string key = {};  // 64 hexadecimal digits
  std::map<std::string, std::string> parts =
      {};  // a digest per input, so that a change can be named
};

/// SHA-256 over stage, algorithm_version, canonical parameters, model (with mechanism and tracker),
/// the exact bits of the ordered readings, the exclusions, and the parents' keys. The campaign's
/// name, uuid and facts do not count: equal readings give equal results.
/// @throws InputError  parameters or model are not JSON (job_test.cpp)
JobKey job_key(const JobKeyInput& input);

/// The same JSON value always gives the same text: keys sorted, no spaces, shortest exact numbers.
std::string canonical_json(const std::string& text, const std::string& field);

}  // namespace trammel::store
