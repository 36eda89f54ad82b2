#pragma once
// The chain nominal -> geometry -> +effect -> … of a diagnosis, as the campaign's model versions.

#include "app/job/correction_json.hpp"
#include "core/diagnose/diagnose.hpp"
#include "store/job.hpp"

namespace trammel::job {

/// One object per step of the gap: {"name", "correction", "effects", "geometry", "identify_rms_mm",
/// …}: what this step fitted, each value with its unit and the standard deviation it has in this
/// model (none where only combinations with others are known). Changes count from nominal.
/// Proof: model_chain_test.cpp.
Json model_chain_json(const Diagnosis& diagnosis);

/// Stores the chain that a diagnose job found as the campaign's next model versions, each the child
/// of the one before. A job whose chain is stored already is left alone: a process may have died
/// between the two.
void store_model_chain(store::Connection& connection, const store::Job& job);

}  // namespace trammel::job
