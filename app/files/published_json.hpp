#pragma once
// The fact "published" of a campaign: figures that somebody printed of one like it.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/files/fields.hpp"
#include "core/measure/reading.hpp"

namespace trammel {

inline constexpr const char* kPublishedFact = "published";

/// Mean, largest and least error before and after a correction, in the unit of the table.
struct PublishedTable {
  std::string id;     // of the report's table it stands beside: "lsq-80-position"
  std::string table;  // as the publication numbers it: "IV"
  bool in_sample = false;
  std::vector<double> before, after;  // mean, max, min
};

struct Published {
  std::vector<PublishedTable> tables;
  std::map<std::string, double> parameters;  // identified values by name, mm or deg
  std::vector<double> circles_after_mm;      // means of centre x, centre y, radius; or none
  std::optional<double> network_mae_mm, network_mse_mm2;
  std::vector<double> network_r2_pearson;  // per joint, or none
};

/// The object "published" of a protocol, as the one text that is stored with the campaign. Throws
/// InputError where it is not of this form.
std::string read_published(Fields fields);

/// What is stored with a campaign; nothing without the fact. Proof: report_test.cpp.
std::optional<Published> published_of(const Campaign& campaign);

}  // namespace trammel
