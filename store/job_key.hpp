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
  std::string model_json = "{}";  // the model a job starts from, beside the machine
  const Campaign& campaign;       // machine, tracker and ordered readings, less the excluded ones
  std::vector<int> excluded_seqs = {};
  std::vector<std::string> parent_keys = {};
};

/// How keys are made since version 5 of the schema: over big-endian bytes, of any machine. Jobs of
/// older databases keep theirs, of scheme 1.
inline constexpr int kKeyScheme = 2;

struct JobKey {
  std::string key = {};  // 64 hexadecimal digits
  std::map<std::string, std::string> parts =
      {};  // a digest per input, so that a change can be named
  int scheme = kKeyScheme;
};

/// SHA-256 over stage, algorithm_version, canonical parameters, model (with machine and tracker),
/// the exact bits of the ordered readings, the exclusions, and the parents' keys. The campaign's
/// name, uuid and facts do not count: equal readings give equal results.
/// Scheme 1: what a job of an older database is compared with.
/// @throws InputError  parameters or model are not JSON (job_test.cpp)
JobKey job_key(const JobKeyInput& input, int scheme = kKeyScheme);

/// The same JSON value always gives the same text: keys sorted, no spaces, shortest exact numbers.
std::string canonical_json(const std::string& text, const std::string& field);

}  // namespace trammel::store
