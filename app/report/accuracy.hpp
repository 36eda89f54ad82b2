#pragma once
// The answer to v_accuracy, by the judge that the report asks.

#include "store/query.hpp"

namespace trammel::report {

/// v_accuracy (store/README.md) for all campaigns of the file: what each job states of its own fit
/// (source `predicted`), and each complete compensated session against its baseline (`measured`),
/// by the rules of core/judge. Proof: speakers_agree_test.cpp.
store::ComputedTable accuracy(store::Connection& connection);

}  // namespace trammel::report
