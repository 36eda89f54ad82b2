#include "app/files/budget_json.hpp"

#include <array>

#include "app/files/json_file.hpp"

namespace trammel {

namespace {

struct Entry {
  const char* name;
  std::optional<double> BudgetFacts::*value;
};
constexpr std::array<Entry, 7> kEntries = {{
    {"instrument_mpe_mm", &BudgetFacts::instrument_mpe_mm},
    {"instrument_u_mm", &BudgetFacts::instrument_u_mm},
    {"nests_mm", &BudgetFacts::nests_mm},
    {"frame_u_mm", &BudgetFacts::frame_u_mm},
    {"alpha_per_k", &BudgetFacts::alpha_per_k},
    {"temperature_spread_k", &BudgetFacts::temperature_spread_k},
    {"length_mm", &BudgetFacts::length_mm},
}};

BudgetFacts facts_of(Fields& fields) {
  BudgetFacts facts;
  facts.instrument = fields.text("instrument", facts.instrument);
  if (find_instrument(facts.instrument) == nullptr) {
    fields.refuse("instrument", "no such instrument: " + facts.instrument,
                  "tracker, interferometer, grid-encoder or unknown");
  }
  for (const Entry& entry : kEntries) {
    facts.*entry.value = fields.optional_number(entry.name);
    const auto& value = facts.*entry.value;
    if (value && !(*value >= 0)) {
      fields.refuse(entry.name, "an uncertainty is not negative", "0 or more");
    }
  }
  if (facts.instrument_mpe_mm && facts.instrument_u_mm) {
    fields.refuse("instrument_u_mm", "the instrument has an MPE and a calibration",
                  "one of the two: the calibration is the better one");
  }
  fields.done();
  return facts;
}

}  // namespace

std::string read_budget(Fields fields) {
  const BudgetFacts facts = facts_of(fields);
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  if (facts.instrument != BudgetFacts{}.instrument) json["instrument"] = facts.instrument;
  for (const Entry& entry : kEntries) {
    if (const auto& value = facts.*entry.value) json[entry.name] = *value;
  }
  return json.dump();
}

BudgetFacts budget_facts(const Campaign& campaign) {
  const auto fact = campaign.facts.find(kBudgetFact);
  if (fact == campaign.facts.end()) return {};
  const JsonFile file = parse_json(fact->second, "the campaign's fact budget");
  Fields fields(file);
  return facts_of(fields);
}

}  // namespace trammel
