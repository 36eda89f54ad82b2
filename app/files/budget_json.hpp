#pragma once
// The fact "budget" of a campaign: what it states of its instruments.

#include <string>

#include "app/files/fields.hpp"
#include "core/judge/budget.hpp"

namespace trammel {

inline constexpr const char* kBudgetFact = "budget";

/// The object "budget" of a campaign's facts, as the one text that is stored. Throws InputError for
/// a field that is unknown or not a positive number, and for an MPE beside a calibration.
std::string read_budget(Fields fields);

/// What a campaign states; nothing without the fact. Proof: budget_test.cpp.
BudgetFacts budget_facts(const Campaign& campaign);

}  // namespace trammel
